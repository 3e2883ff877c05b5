#include "estimator/jobs/pieces/frame_range.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "frontend/base/number_text.h"

namespace tagtwist::internal {
namespace {

constexpr double kMostFrames = 1e12;

class RangeSource : public DataSource {
 public:
  RangeSource(std::unique_ptr<DataSource> source, const FrameRange& range)
      : source_(std::move(source)), range_(range) {
    const std::vector<int64_t>& all_ns = source_->stamps_ns();
    const auto at = [&](size_t i) { return all_ns.begin() + static_cast<std::ptrdiff_t>(i); };
    stamps_ns_.assign(at(range.from), at(range.to));
  }

  Result<std::optional<Frame>> Next() override {
    if (!begun_) {
      if (const Status skipped = source_->Skip(range_.from); !skipped) return skipped.error();
      begun_ = true;
    }
    if (given_ == stamps_ns_.size()) return std::optional<Frame>();
    ++given_;
    return source_->Next();
  }

  const std::vector<int64_t>& stamps_ns() const override { return stamps_ns_; }
  const std::vector<TruthSample>& ground_truth() const override { return source_->ground_truth(); }
  const std::vector<ImuSample>& imu() const override { return source_->imu(); }
  const std::vector<std::string>& notes() const override { return source_->notes(); }
  std::string truth_origin() const override { return source_->truth_origin(); }
  double stamp_step_s() const override { return source_->stamp_step_s(); }

 private:
  std::unique_ptr<DataSource> source_;
  FrameRange range_;
  std::vector<int64_t> stamps_ns_;
  size_t given_ = 0;
  bool begun_ = false;
};

}  // namespace

Result<FrameMark> ParseFrameMark(const std::string& text) {
  const bool is_percent = !text.empty() && text.back() == '%';
  const auto value = ParseNumber(is_percent ? text.substr(0, text.size() - 1) : text);
  const bool fits = value && *value >= 0 && *value <= (is_percent ? 100 : kMostFrames) &&
                    (is_percent || *value == std::floor(*value));
  if (fits) return FrameMark{*value, is_percent};
  return Error{"expected a number of frames, or a share of them as 12.5%, got " +
               QuoteForMessage(text)};
}

size_t FramesBefore(const FrameMark& mark, size_t frames) {
  const double count =
      mark.is_percent ? std::floor(static_cast<double>(frames) * mark.value / 100) : mark.value;
  return std::min(frames, static_cast<size_t>(count));
}

Result<FrameRange> RangeOf(const std::optional<FrameMark>& from, const std::optional<FrameMark>& to,
                           size_t frames) {
  const FrameRange range{from ? FramesBefore(*from, frames) : 0,
                         to ? FramesBefore(*to, frames) : frames};
  if (range.from < range.to) return range;
  return Error{"has " + std::to_string(frames) + " frames, none from " +
               std::to_string(range.from) + " on and before " + std::to_string(range.to)};
}

std::unique_ptr<DataSource> TakeRange(std::unique_ptr<DataSource> source, const FrameRange& range) {
  return std::make_unique<RangeSource>(std::move(source), range);
}

}  // namespace tagtwist::internal

#include "frontend/io/recordings/rig/rig_source.h"

#include <algorithm>
#include <utility>

#include "frontend/base/format_text.h"

namespace tagtwist {

using namespace internal;
namespace {

// Far below a line's time of a rolling shutter and what a body moves; above the rounding of stamps.
constexpr int64_t kSameTimeNs = 20'000;

// Frames of several cameras at one time.
struct Moment {
  int64_t t_ns = 0;
  std::vector<size_t> cameras;  // ascending
};

template <typename Sample>
std::vector<Sample> Shifted(std::vector<Sample> samples, int64_t by_ns) {
  for (Sample& sample : samples) sample.t_ns += by_ns;
  return samples;
}

class RigSource final : public DataSource {
 public:
  RigSource(std::vector<std::unique_ptr<DataSource>> sources,
            const std::vector<RigRecording>& recordings)
      : sources_(std::move(sources)) {
    std::vector<std::pair<int64_t, size_t>> all;
    for (size_t i = 0; i < sources_.size(); ++i) {
      const int64_t offset_ns = recordings[i].clock_offset_ns;
      for (const int64_t t_ns : sources_[i]->stamps_ns()) all.emplace_back(t_ns + offset_ns, i);
      Adopt(*sources_[i], offset_ns);
    }
    std::sort(all.begin(), all.end());
    for (const auto& [t_ns, camera] : all) AddStamp(t_ns, camera);
    for (Moment& moment : moments_) {
      std::sort(moment.cameras.begin(), moment.cameras.end());
      stamps_ns_.push_back(moment.t_ns);
    }
  }

  Result<std::optional<Frame>> Next() override {
    std::optional<Frame> out;
    while (!out && next_ < moments_.size()) {
      const Moment& moment = moments_[next_++];
      for (const size_t camera : moment.cameras) {
        auto frame = sources_[camera]->Next();
        if (!frame) return frame.error();
        if (!*frame) continue;  // it ends sooner than its stamps say
        TakeAs(camera, moment.t_ns, &**frame);
        if (out) {
          out->others.push_back(std::move(**frame));
        } else {
          out = std::move(*frame);
        }
      }
    }
    return out;
  }

  const std::vector<int64_t>& stamps_ns() const override { return stamps_ns_; }
  const std::vector<TruthSample>& ground_truth() const override { return truth_; }
  const std::vector<ImuSample>& imu() const override { return imu_; }
  const std::vector<std::string>& notes() const override { return notes_; }
  std::string truth_origin() const override { return truth_origin_; }
  double stamp_step_s() const override {
    double out = 0;  // the coarsest
    for (const auto& source : sources_) out = std::max(out, source->stamp_step_s());
    return out;
  }

 private:
  static void TakeAs(size_t camera, int64_t t_ns, Frame* frame) {
    frame->t_ns = t_ns;
    frame->camera = static_cast<int>(camera);
    for (TagDetection& tag : frame->detections) tag.camera = frame->camera;
  }

  void Adopt(const DataSource& source, int64_t offset_ns) {
    if (truth_.empty() && !source.ground_truth().empty()) {
      truth_ = Shifted(source.ground_truth(), offset_ns);
      truth_origin_ = source.truth_origin();
    }
    if (imu_.empty()) imu_ = Shifted(source.imu(), offset_ns);
    notes_.insert(notes_.end(), source.notes().begin(), source.notes().end());
  }

  // Stamps come in order.
  void AddStamp(int64_t t_ns, size_t camera) {
    const bool same = !moments_.empty() && t_ns - moments_.back().t_ns <= kSameTimeNs;
    if (!same ||
        std::count(moments_.back().cameras.begin(), moments_.back().cameras.end(), camera) > 0) {
      moments_.push_back({t_ns, {}});
    }
    moments_.back().cameras.push_back(camera);
  }

  std::vector<std::unique_ptr<DataSource>> sources_;
  std::vector<Moment> moments_;
  size_t next_ = 0;
  std::vector<int64_t> stamps_ns_;
  std::vector<TruthSample> truth_;
  std::string truth_origin_;
  std::vector<ImuSample> imu_;
  std::vector<std::string> notes_;
};

std::string SpanText(const std::vector<int64_t>& stamps_ns, int64_t offset_ns) {
  return Format("%.3f to %.3f s", ToSeconds(stamps_ns.front() + offset_ns),
                ToSeconds(stamps_ns.back() + offset_ns));
}

// What lies elsewhere in time would be a recording of its own, tied to the others by nothing.
Status CheckSharesTime(const DataSource& first, const RigRecording& of_first,
                       const DataSource& other, const RigRecording& of_other) {
  const std::vector<int64_t>&a = first.stamps_ns(), &b = other.stamps_ns();
  if (a.empty() || b.empty()) return Ok();
  const int64_t shift_ns = of_other.clock_offset_ns - of_first.clock_offset_ns;
  if (b.front() + shift_ns <= a.back() && b.back() + shift_ns >= a.front()) return Ok();
  return Error{of_other.path + ": " + SpanText(b, of_other.clock_offset_ns) +
               " by the body's clock shares no time with " + of_first.path + ", " +
               SpanText(a, of_first.clock_offset_ns) +
               ": bring both to one clock by clock_offset_s"};
}

}  // namespace

Result<std::unique_ptr<DataSource>> OpenRigSource(const std::vector<RigRecording>& recordings,
                                                  const DataSourceOptions& options) {
  std::vector<std::unique_ptr<DataSource>> sources;
  for (const RigRecording& recording : recordings) {
    DataSourceOptions own = options;
    if (!recording.topic.empty()) own.topic = recording.topic;
    auto source = OpenDataSource(recording.path, own);
    if (!source) return source;
    sources.push_back(std::move(*source));
    const auto fine =
        CheckSharesTime(*sources.front(), recordings.front(), *sources.back(), recording);
    if (!fine) return fine.error();
  }
  return std::unique_ptr<DataSource>(std::make_unique<RigSource>(std::move(sources), recordings));
}

}  // namespace tagtwist

#include "estimator/jobs/pieces/frame_range.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>

#include "frontend/base/format_text.h"

namespace tagtwist::internal::frame_range_test {
namespace {

using ::testing::HasSubstr;

TEST(FrameMark, IsANumberOfFramesOrAShare) {
  EXPECT_EQ(FramesBefore(*ParseFrameMark("30"), 100), 30u);
  EXPECT_EQ(FramesBefore(*ParseFrameMark("300"), 100), 100u);
  EXPECT_EQ(FramesBefore(*ParseFrameMark("12.5%"), 100), 12u);
  EXPECT_EQ(FramesBefore(*ParseFrameMark("100%"), 7), 7u);
  for (const char* bad : {"", "%", "-1", "1.5", "101%", "x", "nan%", "1e30", "3 %%"}) {
    EXPECT_FALSE(ParseFrameMark(bad)) << bad;
  }
}

// However many pieces there are, each frame is in one of them.
TEST(FrameMark, SharesLeaveNoFrameOutAndTakeNoneTwice) {
  for (const size_t frames : {size_t{10}, size_t{121}, size_t{14999}}) {
    for (int pieces = 1; pieces <= 10; ++pieces) {
      size_t reached = 0;
      for (int k = 0; k < pieces; ++k) {
        const auto from = ParseFrameMark(Format("%.6f%%", 100.0 * k / pieces));
        const auto to = ParseFrameMark(Format("%.6f%%", 100.0 * (k + 1) / pieces));
        const auto range = RangeOf(*from, *to, frames);
        ASSERT_TRUE(range) << range.error().message;
        EXPECT_EQ(range->from, reached);
        reached = range->to;
      }
      EXPECT_EQ(reached, frames);
    }
  }
}

TEST(FrameRange, WithoutAFrameIsRefused) {
  const auto empty = RangeOf(FrameMark{9, false}, FrameMark{9, false}, 20);
  ASSERT_FALSE(empty);
  EXPECT_THAT(empty.error().message, HasSubstr("has 20 frames, none from 9 on and before 9"));
  EXPECT_FALSE(RangeOf(FrameMark{20, false}, std::nullopt, 20));
}

class Counted : public DataSource {
 public:
  Result<std::optional<Frame>> Next() override {
    if (next_ == stamps_ns_.size()) return std::optional<Frame>();
    Frame frame;
    frame.t_ns = stamps_ns_[next_++];
    return std::optional<Frame>(std::move(frame));
  }
  const std::vector<int64_t>& stamps_ns() const override { return stamps_ns_; }

 private:
  std::vector<int64_t> stamps_ns_ = {0, 10, 20, 30, 40};
  size_t next_ = 0;
};

TEST(TakeRange, GivesTheFramesOfTheRangeAlone) {
  const auto source = TakeRange(std::make_unique<Counted>(), {1, 4});
  EXPECT_EQ(source->stamps_ns(), (std::vector<int64_t>{10, 20, 30}));
  for (const int64_t t_ns : {10, 20, 30}) EXPECT_EQ((**source->Next()).t_ns, t_ns);
  EXPECT_FALSE(*source->Next());
}

}  // namespace
}  // namespace tagtwist::internal::frame_range_test

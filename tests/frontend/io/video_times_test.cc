// What is made of the times that a video's container gives, or does not give. Whole files are read
// in the programs' tests.
#include "frontend/io/images/video_times.h"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>
#include <string>

#include "frontend/io/images/video_file.h"
#include "frontend/io/recordings/data_source.h"
#include "tests/support/temp_folder.h"
#include "tests/support/test_files.h"

namespace tagtwist::internal::video_times_test {
namespace {

using Stamps = std::vector<int64_t>;

// Three frames of 64 x 48 as Motion JPEG, with other bytes behind each such mark.
std::string VideoWith(const std::string& path, const std::string& mark, size_t after,
                      const std::string& bytes) {
  auto video = VideoFile::Create(path, 25, {64, 48});
  EXPECT_TRUE(video);
  for (int i = 0; i < 3; ++i) (*video)->Add(cv::Mat(48, 64, CV_8UC3, cv::Scalar::all(9)));
  EXPECT_TRUE((*video)->Finish());
  EXPECT_TRUE(OpenDataSource(path, {}));
  std::string text = ReadText(path);
  EXPECT_NE(text.find(mark), std::string::npos);
  for (size_t at = text.find(mark); at != std::string::npos; at = text.find(mark, at + 1)) {
    text.replace(at + after, bytes.size(), bytes);
  }
  WriteText(path, text);
  const auto source = OpenDataSource(path, {});
  return source ? "opened" : source.error().message;
}

TEST(VideoTimes, AFrameOfABillionPixelsIsRefusedBeforeItIsDecoded) {
  const TempFolder folder;
  const std::string path = folder / "x.avi";
  // In the container's header, then in the frames' own.
  EXPECT_EQ(VideoWith(path, "strf", 12, std::string("\0\x80\0\0\0\x80\0\0", 8)),
            path +
                ": expected at most 100 million pixels, got 32768 x 32768 "
                "(--limits frame_pixels=N raises that)");
  EXPECT_NE(VideoWith(path, "\xFF\xC0", 5, std::string("\x80\0\x80\0", 4)), "opened");
}

TEST(VideoTimes, TimesThatGrowAreKept) {
  const auto repaired = RepairStamps({{0, 10, 35, 40}, 30, 1, 0});
  ASSERT_TRUE(repaired);
  EXPECT_EQ(repaired->stamps_ns, (Stamps{0, 10, 35, 40}));
  EXPECT_EQ(repaired->invented + repaired->dropped, 0U);
}

TEST(VideoTimes, OnlyTheTailWithoutTimesIsInvented) {
  const auto repaired = RepairStamps({{0, 10, 35, 45, {}, {}}, 1000, 1, 0});
  ASSERT_TRUE(repaired);
  EXPECT_EQ(repaired->stamps_ns, (Stamps{0, 10, 35, 45, 55, 65}));
  EXPECT_EQ(repaired->invented, 2U);
}

TEST(VideoTimes, FramesThatDoNotGrowAreDropped) {
  const auto repaired = RepairStamps({{0, 10, 10, 5, 20}, 30, 1, 0});
  ASSERT_TRUE(repaired);
  EXPECT_EQ(repaired->stamps_ns, (Stamps{0, 10, 20}));
  EXPECT_EQ(repaired->kept, (std::vector<bool>{true, true, false, false, true}));
  EXPECT_EQ(repaired->dropped, 2U);
}

TEST(VideoTimes, OfWholeStepsAreOffByTheirRounding) {
  constexpr int64_t kMs = 1'000'000;
  EXPECT_EQ(RoundingOf({0, 33 * kMs, 67 * kMs, 100 * kMs}, 1e-3), 1e-3);  // 30 Hz in milliseconds
  EXPECT_EQ(RoundingOf({0, 40 * kMs, 120 * kMs, 160 * kMs}, 1e-3), 0);    // 25 Hz, one is missing
  EXPECT_EQ(RoundingOf({0, 33'333'333, 66'666'667, 133'333'333}, 1.0 / 30), 0);
  EXPECT_EQ(RoundingOf({0}, 1e-3), 0);
}

TEST(VideoTimes, WithoutAnyTimeTheRateCounts) {
  const auto repaired = RepairStamps({{{}, {}, {}}, 50, 0, 0});
  ASSERT_TRUE(repaired);
  EXPECT_TRUE(repaired->by_rate);
  EXPECT_EQ(repaired->stamps_ns, (Stamps{0, 20000000, 40000000}));
  EXPECT_FALSE(RepairStamps({{{}, {}}, 0, 0, 0}));
}

}  // namespace
}  // namespace tagtwist::internal::video_times_test

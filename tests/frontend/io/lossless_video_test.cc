// Images recorded as one file: the same images and stamps come back, however early the file ends.
#include "frontend/io/images/lossless_video.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "frontend/io/images/frame_mark.h"
#include "frontend/io/recordings/data_source.h"
#include "tests/support/temp_folder.h"
#include "tests/support/test_files.h"

namespace tagtwist::internal::lossless_video_test {
namespace {

// Uneven, two of them within one of Matroska's milliseconds, none on a whole one.
std::vector<int64_t> UnevenStamps(int n) {
  std::vector<int64_t> out;
  int64_t t_ns = 1'499'735'676'510'662'001;
  for (int i = 0; i < n; ++i) out.push_back(t_ns += i == 3 ? 200'001 : 19'654'321 + 777'777 * i);
  return out;
}

cv::Mat NoiseImage(uint64_t seed, const cv::Size& size) {
  cv::Mat out(size, CV_8UC1);
  cv::RNG(seed).fill(out, cv::RNG::UNIFORM, 0, 256);
  return out;
}

constexpr int kSeed = 7;

std::unique_ptr<LosslessVideo> Recorded(const std::string& path,
                                        const std::vector<int64_t>& stamps_ns,
                                        const cv::Size& size) {
  auto video = LosslessVideo::Create(path);
  EXPECT_TRUE(video) << video.error().message;
  for (size_t i = 0; i < stamps_ns.size(); ++i) {
    const auto added = (*video)->Add(stamps_ns[i], NoiseImage(kSeed + i, size));
    EXPECT_TRUE(added) << added.error().message;
  }
  return std::move(*video);
}

// Frames that the file has: the first ones of those that were recorded, with nothing wrong.
size_t ReadBack(const std::string& path, const std::vector<int64_t>& stamps_ns,
                const cv::Size& size) {
  const auto source = OpenDataSource(path, {});
  if (!source) return 0;
  const std::vector<int64_t> read = (*source)->stamps_ns();
  EXPECT_LE(read.size(), stamps_ns.size());
  EXPECT_TRUE((*source)->notes().empty());
  EXPECT_EQ((*source)->stamp_step_s(), 0);
  for (size_t i = 0; i < read.size() && i < stamps_ns.size(); ++i) {
    EXPECT_EQ(read[i], stamps_ns[i]);
    const auto frame = (*source)->Next();
    if (!frame || !*frame || (*frame)->image.empty()) {
      ADD_FAILURE() << "frame " << i << " of " << read.size() << " cannot be read";
      return i;
    }
    EXPECT_EQ(cv::norm((*frame)->image, NoiseImage(kSeed + i, size), cv::NORM_INF), 0) << i;
  }
  return read.size();
}

TEST(LosslessVideo, StampsAndImagesComeBackExactly) {
  const TempFolder folder;
  for (const cv::Size& size : {cv::Size(32, 24), cv::Size(61, 47), cv::Size(640, 480)}) {
    const std::string path = folder / std::to_string(size.width) + ".mkv";
    const std::vector<int64_t> stamps_ns = UnevenStamps(12);
    const auto video = Recorded(path, stamps_ns, size);
    EXPECT_EQ(ReadBack(path, stamps_ns, size), 12U) << "the recorder is still there";
    ASSERT_TRUE(video->Finish());
    EXPECT_EQ(ReadBack(path, stamps_ns, size), 12U);
  }
}

TEST(LosslessVideo, CutOffAnywhereItHasTheFramesBefore) {
  const TempFolder folder;
  const cv::Size size(64, 48);
  const std::vector<int64_t> stamps_ns = UnevenStamps(8);
  const auto video = Recorded(folder / "a.mkv", stamps_ns, size);
  const std::string bytes = ReadText(folder / "a.mkv");
  size_t most = 0;
  for (size_t cut = bytes.size() % 1999; cut <= bytes.size(); cut += 1999) {
    WriteText(folder / "b.mkv", bytes.substr(0, cut));
    const size_t n = ReadBack(folder / "b.mkv", stamps_ns, size);
    EXPECT_GE(n, most) << cut;
    most = n;
  }
  EXPECT_EQ(most, 8U);
}

TEST(LosslessVideo, WhatIsThereIsKept) {
  const TempFolder folder;
  WriteText(folder / "a.mkv", "mine");
  const auto video = LosslessVideo::Create(folder / "a.mkv");
  ASSERT_FALSE(video);
  EXPECT_EQ(video.error().message, folder / "a.mkv" + ": exists already");
  EXPECT_EQ(ReadText(folder / "a.mkv"), "mine");
}

TEST(LosslessVideo, WithoutAnImageThereIsNoFile) {
  const TempFolder folder;
  {
    const auto video = LosslessVideo::Create(folder / "a.mkv");
    ASSERT_TRUE(video);
    EXPECT_TRUE((*video)->Finish());
  }
  EXPECT_FALSE(std::filesystem::exists(folder / "a.mkv"));
}

TEST(LosslessVideo, AnImageOfAnotherSizeOrKindIsToldOnce) {
  const TempFolder folder;
  const auto video = Recorded(folder / "a.mkv", {5'000'000, 15'000'000}, {32, 24});
  const auto added = video->Add(25'000'000, NoiseImage(1, {24, 32}));
  ASSERT_FALSE(added);
  EXPECT_EQ(added.error().message, folder / "a.mkv" + ": cannot write: images of different sizes");
  EXPECT_TRUE(video->Add(35'000'000, NoiseImage(1, {32, 24})));
  EXPECT_EQ(ReadBack(folder / "a.mkv", {5'000'000, 15'000'000}, {32, 24}), 2U);
}

TEST(FrameMark, AnotherTextIsNoStamp) {
  EXPECT_EQ(ReadFrameMark(FrameMark(-1'499'735'676'510'662'001)), -1'499'735'676'510'662'001);
  for (const char* text : {"", "t_ns", "t_ns=", "t_ns=1.5", "t_ns=4600000000000000001", "t=1"}) {
    EXPECT_FALSE(ReadFrameMark(text)) << text;
  }
}

}  // namespace
}  // namespace tagtwist::internal::lossless_video_test

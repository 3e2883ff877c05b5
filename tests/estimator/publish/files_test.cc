// Files that grow while a run goes on: what is there when the run is cut off can be read.
#include <gtest/gtest.h>

#include <filesystem>
#include <opencv2/core.hpp>
#include <utility>
#include <vector>

#include "estimator/publish/image_recorder.h"
#include "estimator/publish/mcap_writer.h"
#include "frontend/io/recordings/data_source.h"
#include "tests/support/temp_folder.h"
#include "tests/support/test_files.h"

namespace tagtwist::internal::files_test {
namespace {

// Opcodes and sizes of the records that are whole.
std::vector<std::pair<int, size_t>> Records(const std::string& bytes) {
  std::vector<std::pair<int, size_t>> out;
  const auto byte = [&](size_t at) { return static_cast<size_t>(static_cast<uint8_t>(bytes[at])); };
  for (size_t at = 8; at + 9 <= bytes.size();) {
    size_t size = 0;
    for (size_t i = 0; i < 8; ++i) size |= byte(at + 1 + i) << (8 * i);
    if (size > bytes.size() - at - 9) break;
    out.emplace_back(static_cast<int>(byte(at)), size);
    at += 9 + size;
  }
  return out;
}

TEST(McapWriter, EveryMessageIsThereAtOnce) {
  const TempFolder folder;
  const std::string path = folder / "a.mcap";
  auto writer = McapWriter::Create(path, FoxgloveChannels(PublishedRun()));
  ASSERT_TRUE(writer) << writer.error().message;
  for (int i = 0; i < 5; ++i) ASSERT_TRUE((*writer)->Write({kPose, 1'000'000 * i, "{}"}));
  const auto records = Records(ReadText(path));
  ASSERT_EQ(records.size(), 1u + 12 + 5);  // header, six schemas and channels, messages
  EXPECT_EQ(records.back(), std::pair(5, size_t{2 + 4 + 8 + 8 + 2}));
  ASSERT_TRUE((*writer)->Finish());
  const std::string whole = ReadText(path);
  EXPECT_EQ(whole.substr(0, 8), std::string("\x89MCAP0\r\n", 8));
  EXPECT_EQ(whole.substr(whole.size() - 8), whole.substr(0, 8));
  EXPECT_EQ(Records(whole).back(), std::pair(2, size_t{20}));
}

TEST(McapWriter, AFullDiskIsToldOnce) {
  auto writer = McapWriter::Create("/dev/full", FoxgloveChannels(PublishedRun()));
  ASSERT_FALSE(writer);
  EXPECT_EQ(writer.error().message, "/dev/full: cannot write: No space left on device");
}

TEST(ImageRecorder, WhatIsRecordedCanBeReadAtAnyTime) {
  const TempFolder folder;
  const std::string path = folder / "new/rec";
  auto recorder = ImageRecorder::Create(path);
  ASSERT_TRUE(recorder) << recorder.error().message;
  cv::Mat image(24, 32, CV_8UC1);
  cv::randu(image, 0, 256);
  ASSERT_TRUE((*recorder)->Add(1'000'000'001, image));
  ASSERT_TRUE((*recorder)->Add(1'000'000'002, cv::Mat()));
  ASSERT_TRUE((*recorder)->Add(2'000'000'003, image));
  auto source = OpenDataSource(path, {});  // the recorder is still there
  ASSERT_TRUE(source) << source.error().message;
  EXPECT_EQ((*source)->stamps_ns(),
            (std::vector<int64_t>{1'000'000'001, 1'000'000'002, 2'000'000'003}));
  const auto frame = (*source)->Next();
  ASSERT_TRUE(frame && *frame);
  EXPECT_EQ(cv::norm((*frame)->image, image, cv::NORM_INF), 0);
}

TEST(ImageRecorder, AFolderThatHoldsSomethingIsRefused) {
  const TempFolder folder;
  std::filesystem::create_directory(folder / "rec");
  WriteText(folder / "rec/notes.txt", "mine");
  const auto recorder = ImageRecorder::Create(folder / "rec");
  ASSERT_FALSE(recorder);
  EXPECT_EQ(recorder.error().message, folder / "rec" + ": exists already and is not empty");
}

}  // namespace
}  // namespace tagtwist::internal::files_test

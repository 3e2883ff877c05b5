// Files that grow while a run goes on: what is there when the run is cut off can be read.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <opencv2/core.hpp>
#include <vector>

#include "estimator/publish/image_recorder.h"
#include "estimator/publish/mcap/mcap_writer.h"
#include "frontend/io/recordings/data_source.h"
#include "tests/support/temp_folder.h"
#include "tests/support/test_files.h"

namespace tagtwist::internal::files_test {
namespace {

// Opcode, place and size of the records from a byte on that are whole.
struct Record {
  int opcode;
  size_t at, size;
};
uint64_t NumberAt(const std::string& bytes, size_t at, size_t length = 8) {
  uint64_t out = 0;
  for (size_t i = 0; i < length; ++i) {
    out |= static_cast<uint64_t>(static_cast<uint8_t>(bytes.at(at + i))) << (8 * i);
  }
  return out;
}
std::vector<Record> Records(const std::string& bytes, size_t at, size_t end) {
  std::vector<Record> out;
  while (at + 9 <= end) {
    const size_t size = NumberAt(bytes, at + 1);
    if (size > end - at - 9) break;
    out.push_back({static_cast<uint8_t>(bytes[at]), at + 9, size});
    at += 9 + size;
  }
  return out;
}

size_t CountOf(const std::vector<Record>& records, int opcode) {
  return static_cast<size_t>(std::count_if(
      records.begin(), records.end(), [opcode](const Record& r) { return r.opcode == opcode; }));
}

constexpr int kMessage = 5, kChunk = 6, kMessageIndex = 7, kChunkIndex = 8;
constexpr size_t kChunkFields = 40;

TEST(McapWriter, EveryMessageIsThereAtOnce) {
  const TempFolder folder;
  const std::string path = folder / "a.mcap";
  auto writer = McapWriter::Create(path, FoxgloveChannels(PublishedRun()));
  ASSERT_TRUE(writer) << writer.error().message;
  for (size_t i = 0; i < 50; ++i) {
    ASSERT_TRUE((*writer)->Write(
        {ChannelOf(0, OfBody::kPose), static_cast<int64_t>(100'000'000 * i), "{}"}));
    const std::string bytes = ReadText(path);
    const auto records = Records(bytes, 8, bytes.size());
    EXPECT_EQ(records.back().at + records.back().size, bytes.size()) << "a part of a record";
    size_t messages = CountOf(records, kMessage);
    for (const Record& record : records) {
      if (record.opcode != kChunk) continue;
      messages +=
          CountOf(Records(bytes, record.at + kChunkFields, record.at + record.size), kMessage);
    }
    EXPECT_EQ(messages, i + 1);
  }
  ASSERT_TRUE((*writer)->Finish());
  const std::string whole = ReadText(path);
  EXPECT_EQ(whole.substr(0, 8), std::string("\x89MCAP0\r\n", 8));
  EXPECT_EQ(whole.substr(whole.size() - 8), whole.substr(0, 8));
  const auto records = Records(whole, 8, whole.size() - 8);
  EXPECT_EQ(records.back().opcode, 2);
  EXPECT_EQ(CountOf(records, kMessage), 0U);
}

// From the file's end to each message, as a reader that seeks goes.
TEST(McapWriter, TheIndexLeadsToEachMessage) {
  const TempFolder folder;
  const std::string path = folder / "a.mcap";
  auto writer = McapWriter::Create(path, FoxgloveChannels(PublishedRun()));
  ASSERT_TRUE(writer) << writer.error().message;
  const std::string large(300'000, 'x');  // chunks end by their size, too
  for (int64_t i = 0; i < 60; ++i) {
    ASSERT_TRUE((*writer)->Write({ChannelOf(0, OfBody::kPose), 70'000'000 * (i + 1), "{}"}));
    ASSERT_TRUE((*writer)->Write(
        {ImageChannel(PublishedRun(), 0), 70'000'000 * (i + 1), i < 30 ? large : ""}));
  }
  ASSERT_TRUE((*writer)->Finish());
  const std::string bytes = ReadText(path);
  const size_t footer = bytes.size() - 8 - 20;
  size_t messages = 0, chunks = 0;
  for (const Record& record : Records(bytes, NumberAt(bytes, footer), bytes.size() - 8)) {
    if (record.opcode != kChunkIndex) continue;
    ++chunks;
    const size_t start = NumberAt(bytes, record.at + 16), length = NumberAt(bytes, record.at + 24);
    ASSERT_EQ(bytes[start], kChunk);
    const size_t indexes = NumberAt(bytes, record.at + 32, 4) / 10;
    for (size_t i = 0; i < indexes; ++i) {
      const size_t at = NumberAt(bytes, record.at + 36 + 10 * i + 2);
      EXPECT_GE(at, start + length);
      ASSERT_EQ(bytes[at], kMessageIndex);
      for (size_t j = 0; j < NumberAt(bytes, at + 11, 4); j += 16, ++messages) {
        const size_t t_ns = NumberAt(bytes, at + 15 + j);
        const size_t message = start + 9 + kChunkFields + NumberAt(bytes, at + 15 + j + 8);
        ASSERT_EQ(bytes[message], kMessage);
        EXPECT_EQ(NumberAt(bytes, message + 9, 2), NumberAt(bytes, at + 9, 2)) << "channel";
        EXPECT_EQ(NumberAt(bytes, message + 9 + 6), t_ns);
        EXPECT_GE(t_ns, NumberAt(bytes, record.at));
        EXPECT_LE(t_ns, NumberAt(bytes, record.at + 8));
      }
    }
  }
  EXPECT_EQ(messages, 120U);
  EXPECT_GT(chunks, 8U);
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

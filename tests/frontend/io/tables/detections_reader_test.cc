// A table of detections that is read stamp by stamp says what it says when it is read as a whole.
#include "frontend/io/tables/detections_reader.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <thread>

#include "frontend/base/format_text.h"
#include "frontend/io/tables/csv.h"
#include "frontend/io/tables/detections_csv.h"
#include "tests/support/dataset_fixture.h"
#include "tests/support/sanitizers.h"
#include "tests/support/temp_folder.h"

namespace tagtwist::internal::detections_reader_test {
namespace {

using ::testing::HasSubstr;

constexpr const char* kHeader = "t,id,u1,v1,u2,v2,u3,v3,u4,v4\n";
constexpr const char* kCorners = ",1,2,3,4,5,6,7,8\n";

std::string Row(double t_s, int id) {
  return Format("%08.3f,", t_s) + std::to_string(id) + kCorners;  // as long whatever the stamp
}

// Three tags a stamp, ids that count.
std::string ManyRows(int stamps) {
  std::string out = kHeader;
  for (int i = 0; i < 3 * stamps; ++i) out += Row(0.02 * (i / 3), i);
  return out;
}

class DetectionsReaderTest : public ::testing::Test {
 protected:
  std::string Fault(const std::string& text) const {
    WriteText(path_, text);
    const auto opened = DetectionsReader::Open(path_, TimeUnit::kSeconds);
    return opened ? "" : opened.error().message;
  }
  TempFolder folder_;
  std::string path_ = folder_ / "detections.csv";
};

TEST_F(DetectionsReaderTest, PiecesOfAFileAreItsRows) {
  std::string text = "\xEF\xBB\xBF#t [s], id\r\n";
  for (int i = 0; i < 30000; ++i) text += std::to_string(i) + ", " + std::to_string(7 * i) + "\r\n";
  text += "30000,1";  // the last line has no end
  WriteText(path_, text);
  const auto whole = CsvTable::Read(path_);
  auto pieces = CsvPieces::Open(path_);
  ASSERT_TRUE(whole && pieces);
  EXPECT_EQ(pieces->table().columns(), (std::vector<std::string>{"t", "id"}));
  for (int round = 0; round < 2; ++round) {
    size_t rows = 0, n_pieces = 0;
    while (true) {
      const auto piece = pieces->Next();
      ASSERT_TRUE(piece) << piece.error().message;
      if (*piece == nullptr) break;
      ++n_pieces;
      for (size_t i = 0; i < (*piece)->rows(); ++i, ++rows) {
        ASSERT_EQ((*piece)->Cell(i, 1), whole->Cell(rows, 1));
        ASSERT_EQ((*piece)->line(i), whole->line(rows));
      }
    }
    EXPECT_EQ(rows, whole->rows());
    EXPECT_GT(n_pieces, 4u);
    ASSERT_TRUE(pieces->Rewind());
  }
}

TEST_F(DetectionsReaderTest, StampsThatLieInTwoPiecesAreWhole) {
  constexpr int kStamps = 5000;
  WriteText(path_, ManyRows(kStamps));
  ASSERT_GT(std::filesystem::file_size(path_), 5u << 16U);
  auto reader = DetectionsReader::Open(path_, TimeUnit::kSeconds);
  ASSERT_TRUE(reader) << reader.error().message;
  const std::vector<int64_t> stamps_ns = reader->TakeStamps();
  ASSERT_EQ(stamps_ns.size(), static_cast<size_t>(kStamps));
  for (int i = 0; i < kStamps; ++i) {
    const auto next = reader->Next();
    ASSERT_TRUE(next && *next);
    EXPECT_EQ((*next)->t_ns, stamps_ns[static_cast<size_t>(i)]);
    EXPECT_EQ((*next)->line, 2 + 3 * i);
    ASSERT_EQ((*next)->tags.size(), 3u);
    for (int tag = 0; tag < 3; ++tag) {
      EXPECT_EQ((*next)->tags[static_cast<size_t>(tag)].id, 3 * i + tag);
    }
  }
  const auto end = reader->Next();
  EXPECT_TRUE(end && !*end);
}

TEST_F(DetectionsReaderTest, AFaultIsToldBeforeTheFirstStamp) {
  const std::string many = ManyRows(5000);
  EXPECT_EQ(Fault(many + "100,x" + kCorners), path_ + ":15002: id: expected an integer, got 'x'");
  EXPECT_EQ(Fault(many + "1e,4" + kCorners),
            path_ + ":15002: t: expected a time in seconds, got '1e'");
  EXPECT_EQ(Fault(many + "100,4,5\n"), path_ + ":15002: expected 10 columns, got 3");
}

// What a table is as a whole comes first: its lines, its columns, its stamps, its rows.
TEST_F(DetectionsReaderTest, OfSeveralFaultsTheWidestIsTold) {
  const std::string row = std::string(kHeader) + "0,x" + kCorners;
  const std::string stamp = std::string("nonsense,4") + kCorners, line = "1,2\n";
  EXPECT_THAT(Fault(row), HasSubstr(":2: id: expected an integer"));
  EXPECT_THAT(Fault(row + stamp), HasSubstr(":3: t: expected a time"));
  EXPECT_THAT(Fault(row + Row(-1, 2)), HasSubstr(":3: passed over 1 of 2 rows"));
  EXPECT_THAT(Fault(row + stamp + line), HasSubstr(":4: expected 10 columns"));
  EXPECT_THAT(Fault("t,id\n0,1\n0,1,2\n"), HasSubstr(":3: expected 2 columns"));
  EXPECT_THAT(Fault("t,id\n0,1\n"), HasSubstr(":1: missing column 'u1'"));
}

TEST_F(DetectionsReaderTest, AUnitThatTheStampsGiveAwayIsTaken) {
  std::string text = kHeader;
  for (int i = 0; i < 4000; ++i) {
    text += std::to_string(1'700'000'000'000 + 20 * (i / 2)) + "," + std::to_string(i) + kCorners;
  }
  WriteText(path_, text);
  auto reader = DetectionsReader::Open(path_, TimeUnit::kSeconds);
  ASSERT_TRUE(reader) << reader.error().message;
  ASSERT_EQ(reader->notes().size(), 1u);
  EXPECT_THAT(reader->notes().front(), HasSubstr("stamps are taken for milliseconds"));
  EXPECT_EQ(reader->TakeStamps().size(), 2000u);
  const auto first = reader->Next();
  ASSERT_TRUE(first && *first);
  EXPECT_EQ((*first)->t_ns, 1'700'000'000'000'000'000);
  EXPECT_EQ((*first)->tags.size(), 2u);
}

TEST_F(DetectionsReaderTest, WhatWasPassedOverIsNotedOnce) {
  WriteText(path_, kHeader + Row(0, 1) + Row(1, 2) + Row(0.5, 3) + "nan,4" + kCorners + Row(1, 5) +
                       "2,6,nan,2,3,4,5,6,7,8\n" + Row(3, 7) + Row(3, 8) + Row(4, 9));
  std::vector<std::string> notes;
  const auto read = ReadDetectionsCsv(path_, TimeUnit::kSeconds, {}, &notes);
  ASSERT_TRUE(read) << read.error().message;
  ASSERT_EQ(read->size(), 4u);
  EXPECT_EQ((*read)[2].tags.size(), 2u);
  EXPECT_EQ(notes, (std::vector<std::string>{
                       path_ + ": passed over 1 rows without a stamp",
                       path_ + ": passed over 2 of 8 rows: 1 stamp repeats, 1 runs backwards "
                               "(the first: line 4)",
                       path_ + ": passed over 1 rows without numbers"}));
}

TEST_F(DetectionsReaderTest, AFileIsAsLongAsItWasAtFirst) {
  WriteText(path_, ManyRows(5000));
  auto grown = DetectionsReader::Open(path_, TimeUnit::kSeconds);
  auto cut = DetectionsReader::Open(path_, TimeUnit::kSeconds);
  ASSERT_TRUE(grown && cut);
  std::ofstream(path_, std::ios::app) << "no row\n";
  for (int i = 0; i < 5000; ++i) {
    const auto next = grown->Next();
    ASSERT_TRUE(next && *next);
  }
  const auto end = grown->Next();
  EXPECT_TRUE(end && !*end);
  std::filesystem::resize_file(path_, 1000);
  while (true) {
    const auto next = cut->Next();
    if (next && *next) continue;
    ASSERT_FALSE(next);
    EXPECT_THAT(next.error().message, HasSubstr(path_ + ": was made shorter while it was read"));
    break;
  }
}

TEST_F(DetectionsReaderTest, APipeIsReadOnce) {
  ASSERT_EQ(::mkfifo(path_.c_str(), 0600), 0);
  std::thread writer([&] { WriteText(path_, ManyRows(5000)); });
  const auto read = ReadDetectionsCsv(path_, TimeUnit::kSeconds);
  writer.join();
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->size(), 5000u);
}

TEST_F(DetectionsReaderTest, AnotherFileInItsPlaceEndsTheRecording) {
  WriteText(path_, ManyRows(5000));
  DataSourceOptions options;
  options.use_detections = true;
  const auto source = OpenDataSource(folder_.path(), options);
  ASSERT_TRUE(source) << source.error().message;
  std::string other = kHeader;
  for (int i = 0; i < 15000; ++i) other += Row(0.02 * (i / 3) + 0.011, i);
  WriteText(path_, other);
  std::string fault;
  EXPECT_LT(ReadAllFrames(source->get(), &fault).size(), 5000u);
  EXPECT_EQ(fault, path_ + ": was changed while it was read");
}

TEST_F(DetectionsReaderTest, WhatASkipPassesOverBelongsToNoFrame) {
  WriteText(path_, ManyRows(1000));
  DataSourceOptions options;
  options.use_detections = true;
  const auto source = OpenDataSource(folder_.path(), options);
  ASSERT_TRUE(source);
  ASSERT_TRUE((*source)->Skip(700));
  const auto frame = (*source)->Next();
  ASSERT_TRUE(frame && *frame);
  ASSERT_EQ((*frame)->detections.size(), 3u);
  EXPECT_EQ((*frame)->detections.front().id, 2100);
  EXPECT_EQ((*frame)->name, path_ + ":2102");
}

#ifndef TAGTWIST_SANITIZED
size_t ResidentBytes() {
  size_t size = 0, resident = 0;
  std::ifstream("/proc/self/statm") >> size >> resident;
  return resident * 4096;
}

TEST_F(DetectionsReaderTest, ARecordingIsNeverInMemory) {
  constexpr int kStamps = 40000;
  WriteText(path_, ManyRows(kStamps));
  DataSourceOptions options;
  options.use_detections = true;
  const size_t before = ResidentBytes();
  const auto source = OpenDataSource(folder_.path(), options);
  ASSERT_TRUE(source);
  size_t most = ResidentBytes();
  for (int i = 0; i < kStamps; ++i) {
    const auto frame = (*source)->Next();
    ASSERT_TRUE(frame && *frame);
    if (i % 1000 == 0) most = std::max(most, ResidentBytes());
  }
  // A stamp of each frame, and what finding the clock's unit left behind; all tags are 74 MB.
  EXPECT_LT(most, before + 4'000'000);
}
#endif

}  // namespace
}  // namespace tagtwist::internal::detections_reader_test

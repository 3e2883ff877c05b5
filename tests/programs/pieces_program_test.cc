// A long recording's images searched in pieces, and one estimate of them: --only_detections,
// --pieces.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "tests/support/program_test_util.h"
#include "tests/support/test_files.h"

namespace tagtwist::internal::pieces_program_test {
namespace {

using ::testing::HasSubstr;
using Arguments = std::vector<std::string>;

class PiecesProgram : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TempFolder;
    MakeRecording(folder_->path(), "rec", DatasetFormat::kFolder, true);
    Run({"--dataset", "rec", "--output", "once", "--write_detections", "--write_covariance"});
    Measure("0%", "2", "pieces/0");
    Measure("2", "4", "pieces/1");
    Measure("4", "100%", "pieces/2");
  }
  static void TearDownTestSuite() {
    delete folder_;
    folder_ = nullptr;
  }

  static ProgramRun Run(const Arguments& arguments) {
    return RunProgram(folder_->path(), "tagtwist_estimate", arguments);
  }
  static ProgramRun Measure(const std::string& from, const std::string& to,
                            const std::string& output, const std::string& dataset = "rec") {
    return Run({"--dataset", dataset, "--only_detections", "--from", from, "--to", to, "--output",
                output});
  }
  // A recording whose images show the tags of their right third in the left one, too.
  static void MakeTwins(const std::string& name) {
    MakeRecording(folder_->path(), name, DatasetFormat::kFolder, true);
    for (const auto& entry : std::filesystem::directory_iterator(*folder_ / (name + "/images"))) {
      cv::Mat image = cv::imread(entry.path().string(), cv::IMREAD_GRAYSCALE);
      const int third = image.cols / 3;
      image.colRange(image.cols - third, image.cols).copyTo(image.colRange(0, third));
      ASSERT_TRUE(cv::imwrite(entry.path().string(), image));
    }
  }
  // The refusal of a run with these pieces, which leaves no results.
  static std::string RefusalOf(const std::string& pieces, Arguments more = {}) {
    more.insert(more.begin(), {"--dataset", "rec", "--pieces", pieces, "--output", "refused"});
    const ProgramRun run = Run(more);
    EXPECT_EQ(run.status, 1) << run.err;
    EXPECT_TRUE(IsOneLine(run.err)) << run.err;
    EXPECT_FALSE(std::filesystem::exists(*folder_ / "refused/states.csv"));
    return run.err;
  }
  static void Copy(const std::string& from, const std::string& to) {
    std::filesystem::create_directories(*folder_ / to);
    std::filesystem::copy(*folder_ / from, *folder_ / to, std::filesystem::copy_options::recursive);
  }

  static TempFolder* folder_;
};
TempFolder* PiecesProgram::folder_ = nullptr;

TEST_F(PiecesProgram, JoinedIsTheSameBytesAsAtOnce) {
  const ProgramRun run = Run({"--dataset", "rec", "--pieces", "pieces", "--output", "joined",
                              "--write_detections", "--write_covariance"});
  ASSERT_EQ(run.status, 0) << run.err;
  for (const char* name : {"states.csv", "optimised.tum", "closed_form.tum", "covariance.csv",
                           "detections.csv", "ground_truth.tum"}) {
    EXPECT_EQ(ReadText(*folder_ / ("joined/" + std::string(name))),
              ReadText(*folder_ / ("once/" + std::string(name))))
        << name;
    EXPECT_FALSE(ReadText(*folder_ / ("once/" + std::string(name))).empty()) << name;
  }
}

// A tag that one frame shows twice is told, and left out, only by who knows of every such frame.
TEST_F(PiecesProgram, TellOfIdsThatTwoTagsHave) {
  MakeTwins("twins");
  Measure("0", "3", "halves/0", "twins");
  Measure("3", "100%", "halves/1", "twins");
  const Arguments all = {"--dataset", "twins", "--write_detections"};
  const auto run_with = [&](Arguments more) {
    more.insert(more.end(), all.begin(), all.end());
    return Run(more);
  };
  const ProgramRun once = run_with({"--tracks=false", "--output", "twins_once"});
  ASSERT_EQ(once.status, 0) << once.err;
  ASSERT_THAT(once.err, HasSubstr("is seen at two places at once in 6 frames"));
  const ProgramRun joined =
      run_with({"--tracks=false", "--pieces", "halves", "--output", "twins_joined"});
  EXPECT_EQ(joined.err, once.err);
  std::filesystem::create_directories(*folder_ / "corners");
  std::filesystem::copy(*folder_ / "twins_once/detections.csv", *folder_ / "corners");
  const ProgramRun again = Run({"--dataset", "corners", "--use_detections", "--write_detections",
                                "--output", "twins_again"});
  EXPECT_EQ(again.err, once.err);
  for (const char* name : {"joined/states.csv", "joined/detections.csv", "again/detections.csv"}) {
    const std::string of_once =
        "twins_once" + std::string(name).substr(std::string(name).find('/'));
    EXPECT_EQ(ReadText(*folder_ / ("twins_" + std::string(name))), ReadText(*folder_ / of_once))
        << name;
  }
}

TEST_F(PiecesProgram, ThatHaveNotEachFrameOnceAreRefused) {
  Copy("pieces/0", "gap/0");
  Copy("pieces/2", "gap/2");
  EXPECT_THAT(RefusalOf("gap"), HasSubstr("gap: its 2 pieces have not each frame once: expected "
                                          "one that begins at frame 2 of 6"));
  Copy("pieces", "twice");
  Copy("pieces/2", "twice/3");
  EXPECT_THAT(RefusalOf("twice"), HasSubstr("twice: its 4 pieces have not each frame once"));
  std::filesystem::create_directories(*folder_ / "none");
  EXPECT_THAT(RefusalOf("none"), HasSubstr("none: holds no pieces"));
}

TEST_F(PiecesProgram, OfAnotherSetUpOrRecordingAreRefused) {
  WriteText(*folder_ / "other.yaml", "detector:\n  border_px: 7\n");
  EXPECT_THAT(RefusalOf("pieces", {"--config", "other.yaml"}),
              HasSubstr("measured with another camera, map or detector"));
  MakeRecording(folder_->path(), "moved", DatasetFormat::kFolder, true);
  ReplaceLine(*folder_ / "moved/timestamps.csv", 7, "0.11,images/000005.png");
  const ProgramRun run = Run({"--dataset", "moved", "--pieces", "pieces", "--output", "refused"});
  EXPECT_EQ(run.status, 1);
  EXPECT_THAT(run.err, HasSubstr("is of another recording"));
}

TEST_F(PiecesProgram, ThatAreDamagedAreRefused) {
  Copy("pieces", "cut");
  Truncate(*folder_ / "cut/1/piece.json", -20);
  EXPECT_THAT(RefusalOf("cut"), HasSubstr("cut/1/piece.json: expected what --only_detections"));
  Copy("pieces", "torn");
  Truncate(*folder_ / "torn/1/detections.csv", -50);
  EXPECT_THAT(RefusalOf("torn"), HasSubstr("torn/1/detections.csv:"));
  Copy("pieces", "old");
  const std::string piece = ReadText(*folder_ / "old/1/piece.json");
  WriteText(*folder_ / "old/1/piece.json",
            piece.substr(0, piece.find("\"version\"")) + "\"version\": \"0.0.1\"\n}\n");
  EXPECT_THAT(RefusalOf("old"), HasSubstr("measured by version 0.0.1"));
}

TEST_F(PiecesProgram, ARangeIsARecordingOfItsFrames) {
  const ProgramRun run = Run({"--dataset", "rec", "--from", "2", "--to", "5", "--output", "part"});
  ASSERT_EQ(run.status, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("rec: 3 frames"));
  const std::string states = ReadText(*folder_ / "part/states.csv");
  EXPECT_EQ(std::count(states.begin(), states.end(), '\n'), 4);
  EXPECT_THAT(states, HasSubstr("\n0.040000000,"));
  const ProgramRun none = Run({"--dataset", "rec", "--from", "6", "--output", "part"});
  EXPECT_EQ(none.status, 1);
  EXPECT_THAT(none.err, HasSubstr("rec: has 6 frames, none from 6 on and before 6"));
}

TEST_F(PiecesProgram, WrongUseIsToldInOneLine) {
  for (const auto& [flags, fault] : std::vector<std::pair<Arguments, const char*>>{
           {{"--from", "x"}, "--from: expected a number of frames"},
           {{"--to", "101%"}, "--to: expected a number of frames"},
           {{"--pieces", "pieces", "--from", "1"}, "--pieces: excludes --from, --to"},
           {{"--pieces", "pieces", "--sliding_window"}, "--pieces: excludes --sliding_window"},
           {{"--pieces", "pieces", "--calibrate"}, "--pieces: excludes --calibrate"},
           {{"--only_detections", "--use_detections"}, "--only_detections: excludes"}}) {
    Arguments all = {"--dataset", "rec", "--output", "refused"};
    all.insert(all.end(), flags.begin(), flags.end());
    const ProgramRun run = Run(all);
    EXPECT_EQ(run.status, 2) << fault;
    EXPECT_TRUE(IsOneLine(run.err)) << run.err;
    EXPECT_THAT(run.err, HasSubstr(fault));
  }
}

// The recording's own corners are an input.
TEST_F(PiecesProgram, NeverGoOverARecordingsCorners) {
  const std::string before = ReadText(*folder_ / "rec/detections.csv");
  const ProgramRun run = Run({"--dataset", "rec", "--only_detections", "--output", "rec"});
  EXPECT_EQ(run.status, 1);
  EXPECT_THAT(run.err, HasSubstr("--output would overwrite it"));
  EXPECT_EQ(ReadText(*folder_ / "rec/detections.csv"), before);
}

}  // namespace
}  // namespace tagtwist::internal::pieces_program_test

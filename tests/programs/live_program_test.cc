// tagtwist_estimate --realtime and --dataset camera:.
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>

#include "tests/support/program_test_util.h"
#include "tests/support/test_files.h"

namespace tagtwist::internal::live_program_test {
namespace {

using Arguments = std::vector<std::string>;

class LiveProgram : public testing::Test {
 protected:
  void Simulate(const Arguments& more) {
    Arguments arguments = {"--output", "flight", "--trajectory", "hover"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const ProgramRun run = RunProgram(Folder(), "tagtwist_simulate", arguments);
    ASSERT_EQ(run.status, 0) << run.err;
  }
  static Arguments Window(const std::string& dataset, const Arguments& more) {
    Arguments out = {"--dataset", dataset, "--sliding_window", "--output", "out"};
    out.insert(out.end(), more.begin(), more.end());
    return out;
  }
  nlohmann::json Summary() const {
    const std::string text = ReadText(folder_ / "out/summary.json");
    return text.empty() ? nlohmann::json() : nlohmann::json::parse(text);
  }
  // Lines but for the header.
  int Rows(const std::string& name) const {
    const std::string text = ReadText(folder_ / name);
    return static_cast<int>(std::count(text.begin(), text.end(), '\n')) - 1;
  }
  std::string Folder() const { return folder_.path(); }

  TempFolder folder_;
};

// On a machine that is busy frames may be dropped; none is lost count of.
TEST_F(LiveProgram, ARecordingPlayedAsIfLive) {
  Simulate({"--duration", "2", "--rate", "15"});
  const int n = Rows("flight/timestamps.csv");
  const ProgramRun run =
      RunProgram(Folder(), "tagtwist_estimate", Window("flight", {"--realtime"}));
  ASSERT_EQ(run.status, 0) << run.err;
  const auto summary = Summary();
  EXPECT_EQ(summary["frames"].get<int>() + summary["live"]["frames_dropped"].get<int>(), n);
  EXPECT_GT(summary["frames"].get<int>(), 2);
  EXPECT_GT(summary["wall_s"].get<double>(), 1.8);
  EXPECT_GT(summary["live"]["latency_ms"]["p50"].get<double>(), 0);
  EXPECT_NE(run.err.find("tagtwist_estimate: live: "), std::string::npos) << run.err;
}

TEST_F(LiveProgram, CtrlCEndsItWithItsResultsWhole) {
  Simulate({"--images=false", "--duration", "100", "--imu_rate", "0"});
  const int n = Rows("flight/timestamps.csv");
  const ProgramRun run =
      RunProgram(Folder(), "tagtwist_estimate",
                 Window("flight", {"--realtime", "--use_detections", "--stream", "rows.csv"}),
                 [&] { return Rows("rows.csv") > 20; });
  ASSERT_EQ(run.status, 0) << run.err;
  EXPECT_GT(Summary()["frames"].get<int>(), 20);
  EXPECT_LT(Summary()["frames"].get<int>(), n / 2);
  EXPECT_EQ(ReadText(folder_ / "rows.csv"), ReadText(folder_ / "out/states.csv"));
}

// The page's clients have a third of a second at the end: 60 more frames would come meanwhile.
TEST_F(LiveProgram, WhatComesAfterTheEndIsNotCountedAsDropped) {
  Simulate({"--images=false", "--duration", "20", "--imu_rate", "0", "--rate", "200"});
  const ProgramRun run = RunProgram(
      Folder(), "tagtwist_estimate",
      Window("flight", {"--realtime", "--use_detections", "--page", "0", "--max_frames", "50"}));
  ASSERT_EQ(run.status, 0) << run.err;
  const std::string states = ReadText(folder_ / "out/states.csv");
  const std::string last = states.substr(states.rfind('\n', states.size() - 2) + 1);
  const double last_s = std::stod(last);
  EXPECT_LE(Summary()["frames"].get<int>() + Summary()["live"]["frames_dropped"].get<int>(),
            200 * last_s + 30);
}

// FFmpeg's way in, which needs no camera: a file comes as fast as it is read.
TEST_F(LiveProgram, WhateverOpenCvOpensIsACamera) {
  Simulate({"--duration", "1", "--rate", "12"});
  cv::VideoWriter writer(Folder() + "/flight.avi", cv::VideoWriter::fourcc('M', 'J', 'P', 'G'), 12,
                         {376, 240}, false);
  ASSERT_TRUE(writer.isOpened());
  int n = 0;
  for (const std::string& name : ListTree(Folder())) {
    if (name.find(".png") == std::string::npos) continue;
    writer.write(cv::imread(Folder() + "/" + name, cv::IMREAD_GRAYSCALE));
    ++n;
  }
  writer.release();
  const ProgramRun run = RunProgram(Folder(), "tagtwist_estimate", Window("camera:flight.avi", {}));
  ASSERT_EQ(run.status, 0) << run.err;
  EXPECT_EQ(Summary()["frames"].get<int>() + Summary()["live"]["frames_dropped"].get<int>(), n);
}

// Stamps that jitter, so that a container's milliseconds would show.
TEST_F(LiveProgram, SlowARecordedRunIsEstimatedAgainFromAFolderAsFromAVideo) {
  Simulate({"--duration", "2", "--rate", "10", "--jitter_ms", "3"});
  const std::string folder = Folder();
  for (const std::string place : {"rec", "rec.mkv"}) {
    const ProgramRun live =
        RunProgram(folder, "tagtwist_estimate", Window("flight", {"--record", place}));
    ASSERT_EQ(live.status, 0) << live.err;
    const ProgramRun again =
        RunProgram(folder, "tagtwist_estimate", {"--dataset", place, "--output", place + "_out"});
    ASSERT_EQ(again.status, 0) << again.err;
  }
  EXPECT_EQ(ReadText(folder_ / "rec/timestamps.csv"), ReadText(folder_ / "flight/timestamps.csv"));
  const std::string states = ReadText(folder_ / "rec_out/states.csv");
  EXPECT_EQ(std::count(states.begin(), states.end(), '\n'), Rows("flight/timestamps.csv") + 1);
  EXPECT_EQ(ReadText(folder_ / "rec.mkv_out/states.csv"), states);
  const ProgramRun over =
      RunProgram(folder, "tagtwist_estimate", Window("rec", {"--record", "rec.mkv"}));
  EXPECT_EQ(over.status, 1);
  EXPECT_NE(over.err.find("rec.mkv: exists already"), std::string::npos) << over.err;
}

}  // namespace
}  // namespace tagtwist::internal::live_program_test

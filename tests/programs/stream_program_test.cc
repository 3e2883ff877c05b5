// tagtwist_estimate --stream, and runs that end early.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <thread>

#include "tests/support/program_test_util.h"
#include "tests/support/test_files.h"

namespace tagtwist::internal::stream_program_test {
namespace {

using Arguments = std::vector<std::string>;

class StreamProgram : public testing::Test {
 protected:
  void SetUp() override { Simulate("flight", "1"); }
  void Simulate(const std::string& name, const std::string& duration) {
    const ProgramRun run = RunProgram(
        Folder(), "tagtwist_simulate",
        {"--output", name, "--images=false", "--duration", duration, "--trajectory", "hover"});
    ASSERT_EQ(run.status, 0) << run.err;
  }
  ProgramRun Estimate(const Arguments& more, const std::string& name = "flight") {
    Arguments arguments = {"--dataset",        name,       "--use_detections",
                           "--sliding_window", "--output", "results"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return RunProgram(Folder(), "tagtwist_estimate", arguments);
  }
  std::string Folder() const { return folder_.path(); }
  std::string States() const { return ReadText(folder_ / "results/states.csv"); }

  TempFolder folder_;
};

TEST_F(StreamProgram, StandardOutputIsStatesCsvAndNothingElse) {
  const ProgramRun run = Estimate({"--stream", "-"});
  ASSERT_EQ(run.status, 0) << run.err;
  EXPECT_EQ(run.out, States());
  EXPECT_NE(run.err.find("report: results/report.html"), std::string::npos) << run.err;
}

TEST_F(StreamProgram, AFileIsTheSame) {
  ASSERT_EQ(Estimate({"--stream", "rows.csv"}).status, 0);
  EXPECT_EQ(ReadText(folder_ / "rows.csv"), States());
}

TEST_F(StreamProgram, AReaderThatGoesAwayEndsTheStreamAlone) {
  Simulate("long", "8");  // more than a pipe holds
  const std::string fifo = Folder() + "/fifo";
  ASSERT_EQ(mkfifo(fifo.c_str(), 0600), 0);
  std::string got;
  std::thread reader([&] {
    const int descriptor = open(fifo.c_str(), O_RDONLY);
    std::array<char, 64> buffer{};
    const ssize_t n = read(descriptor, buffer.data(), buffer.size());
    if (n > 0) got.assign(buffer.data(), static_cast<size_t>(n));
    close(descriptor);
  });
  const ProgramRun run = Estimate({"--stream", "fifo"}, "long");
  reader.join();
  ASSERT_EQ(run.status, 0) << run.err;
  EXPECT_EQ(got.substr(0, 8), "t,x,y,z,");
  EXPECT_TRUE(IsOneLine(run.err)) << run.err;
  EXPECT_NE(run.err.find("warning: stream to fifo ended after "), std::string::npos) << run.err;
  EXPECT_NE(run.err.find(" rows: its reader is gone"), std::string::npos) << run.err;
  EXPECT_GT(States().size(), 8u * 49 * 100);
}

TEST_F(StreamProgram, EndsAfterSoManyFramesOrSeconds) {
  const auto rows = [&]() -> int {
    const std::string states = States();
    return static_cast<int>(std::count(states.begin(), states.end(), '\n')) - 1;
  };
  ASSERT_EQ(Estimate({"--max_frames", "17"}).status, 0);
  EXPECT_EQ(rows(), 17);
  ASSERT_EQ(Estimate({"--duration", "0.5"}).status, 0);
  EXPECT_NEAR(rows(), 25, 1);
}

}  // namespace
}  // namespace tagtwist::internal::stream_program_test

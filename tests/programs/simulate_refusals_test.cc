// Every refusal of tagtwist_simulate, of the program as it is run.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/program_test_util.h"
#include "tests/support/test_files.h"

namespace tagtwist::internal::simulate_refusals_test {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

constexpr char kHeader[] = "t,x,y,z,qx,qy,qz,qw\n";
constexpr char kPose[] = ",1,1,1,1,0,0,0\n";

std::string Poses(const std::vector<std::string>& stamps) {
  std::string text = kHeader;
  for (const std::string& stamp : stamps) text += stamp + kPose;
  return text;
}

struct Refusal {
  const char* name;
  std::string text;                    // of the file "input", where there is one
  std::vector<std::string> arguments;  // besides --output; "input" is that file
  const char* fault;                   // the line on stderr holds it
  int status = 1;
};
void PrintTo(const Refusal& refusal, std::ostream* out) { *out << refusal.name; }

std::vector<Refusal> Refusals() {
  const std::vector<std::string> trajectory = {"--trajectory", "input"};
  const std::vector<std::string> times = {"--image_times", "input"};
  const std::vector<std::string> config = {"--config", "input"};
  const std::string good = Poses({"0", "0.1", "0.2", "0.3"});
  return {
      {"NoOutput", "", {"--output", ""}, "--output", 2},
      {"UnknownFlag", "", {"--speed", "3"}, "--speed", 2},
      {"FlagOfWrongType", "", {"--rate", "fast"}, "rate", 2},
      {"FlagOutOfRange", "", {"--rate", "-3"}, "--rate", 2},
      {"UnknownFormat", "", {"--format", "rosbag"}, "--format", 2},
      {"ArgumentTooMany", "", {"more"}, "more", 2},
      {"UnknownFlight", "", {"--trajectory", "spiral"}, "spiral: no such file, and no flight"},

      {"EmptyTrajectory", "", trajectory, "input"},
      {"GarbageTrajectory", Garbage(), trajectory, "input"},
      {"TrajectoryOfNoRow", kHeader, trajectory, "input"},
      {"TrajectoryCutInARow", good.substr(0, good.size() - 8), trajectory, "input:5: expected 8"},
      {"TrajectoryWithoutColumn", "t,x,y,z\n0,1,1,1\n", trajectory, "input"},
      {"TrajectoryStampsRunBack", Poses({"3", "2", "1", "0"}), trajectory, "input:3: "},
      {"TrajectoryQuaternionNotUnit", std::string(kHeader) + "0,1,1,1,1,1,1,1\n1,1,1,1,1,0,0,0\n",
       trajectory, "input:2: "},

      {"MissingImageTimes", "", {"--image_times", "absent.csv"}, "absent.csv: cannot open"},
      {"EmptyImageTimes", "", times, "input"},
      {"GarbageImageTimes", Garbage(), times, "input"},
      {"ImageTimesRepeat", "t\n0.1\n0.2\n0.2\n", times, "input:4: "},
      {"ImageTimesRunBack", "t\n0.1\n0.3\n0.2\n", times, "input:4: "},
      {"ImageTimesNan", "t\n0.1\nnan\n", times, "input:3: "},
      {"ImageTimesOutsideTheFlight", "t\n1000\n1001\n", times, "input: no stamp lies within"},

      {"MissingConfig", "", {"--config", "absent.yaml"}, "absent.yaml: cannot open"},
      {"EmptyConfig", "", config, "input: expected YAML, got an empty file"},
      {"GarbageConfig", Garbage(), config, "input"},
      {"UnknownKey", "camera:\n  with: 3\n", config, "input:2: camera.with: expected one of "},
      {"RepeatedKey", "klt: {}\nklt: {}\n", config, "input:2: klt: expected the key once"},
      {"MistypedKey", "klt:\n  max_points: many\n", config, "input:2: klt.max_points: expected "},
      {"KeyOutOfRange", "klt: {max_points: -1}\n", config, "input:1: klt.max_points: expected "},
  };
}

class SimulateRefusals : public ::testing::TestWithParam<Refusal> {};

TEST_P(SimulateRefusals, OneLineAndNothingWritten) {
  const TempFolder folder;
  WriteText(folder / "input", GetParam().text);
  std::vector<std::string> arguments = {"--output", "flight", "--duration", "1", "--rate", "5"};
  arguments.insert(arguments.end(), GetParam().arguments.begin(), GetParam().arguments.end());
  const ProgramRun run = RunProgram(folder.path(), "tagtwist_simulate", arguments);
  EXPECT_EQ(run.status, GetParam().status) << run.err;
  EXPECT_TRUE(IsOneLine(run.err)) << run.err;
  EXPECT_THAT(run.err, StartsWith("tagtwist_simulate: "));
  EXPECT_THAT(run.err, HasSubstr(GetParam().fault));
  EXPECT_EQ(run.out, "");
  EXPECT_EQ(ListTree(folder.path()), std::vector<std::string>{"input"});
}
INSTANTIATE_TEST_SUITE_P(All, SimulateRefusals, ::testing::ValuesIn(Refusals()),
                         [](const auto& test) { return std::string(test.param.name); });

// Small and quick to render.
std::vector<std::string> Quick(const std::string& output, const std::string& format) {
  return {"--output", output, "--format",        format, "--duration", "1",
          "--rate",   "5",    "--supersampling", "1",    "--scribble", "0"};
}

TEST(SimulateOutput, ThatExistsIsRefusedAndLeftAlone) {
  const TempFolder folder;
  for (const char* format : {"folder", "euroc", "mat"}) {
    WriteText(folder / "taken", "mine");
    const ProgramRun run = RunProgram(folder.path(), "tagtwist_simulate", Quick("taken", format));
    EXPECT_EQ(run.status, 1) << format;
    EXPECT_TRUE(IsOneLine(run.err)) << run.err;
    EXPECT_THAT(run.err, HasSubstr("taken"));
    EXPECT_EQ(ReadText(folder / "taken"), "mine");
    EXPECT_EQ(ListTree(folder.path()), std::vector<std::string>{"taken"});
  }
}

TEST(SimulateOutput, ThatCannotBeMadeIsRefused) {
  const TempFolder folder;
  WriteText(folder / "file", "");
  for (const char* format : {"folder", "euroc", "mat"}) {
    const ProgramRun run =
        RunProgram(folder.path(), "tagtwist_simulate", Quick("file/below", format));
    EXPECT_EQ(run.status, 1) << format << ": " << run.err;
    EXPECT_TRUE(IsOneLine(run.err)) << run.err;
    EXPECT_THAT(run.err, HasSubstr("file/below"));
    EXPECT_EQ(ListTree(folder.path()), std::vector<std::string>{"file"});
  }
}

TEST(SimulateOutput, AppearsWholeInEachFormat) {
  const TempFolder folder;
  for (const char* format : {"folder", "euroc", "mat"}) {
    const ProgramRun run = RunProgram(folder.path(), "tagtwist_simulate", Quick(format, format));
    EXPECT_EQ(run.status, 0) << format << ": " << run.err;
    EXPECT_EQ(run.err, "");
    EXPECT_TRUE(std::filesystem::exists(folder / format));
  }
  for (const std::string& path : ListTree(folder.path())) {
    EXPECT_EQ(path.find("partial"), std::string::npos) << path;
  }
}

}  // namespace
}  // namespace tagtwist::internal::simulate_refusals_test

// Every refusal of tagtwist_compare, of the program as it is run.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "tests/support/program_test_util.h"
#include "tests/support/test_files.h"

namespace tagtwist::internal::compare_refusals_test {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

constexpr char kTum[] = "0 1 1 1 0 0 0 1\n1 2 1 1 0 0 0 1\n2 3 1 1 0 0 0 1\n3 3 2 1 0 0 0 1\n";
constexpr char kStates[] =
    "t,x,y,z,qx,qy,qz,qw,vx_world,vy_world,vz_world,wx_body,wy_body,wz_body\n";

struct Refusal {
  const char* name;
  std::string text;  // of the file "input"; "good.tum" is good
  std::vector<std::string> arguments;
  const char* fault;  // the line on stderr holds it
  int status = 1;
};
void PrintTo(const Refusal& refusal, std::ostream* out) { *out << refusal.name; }

std::vector<Refusal> Refusals() {
  const std::vector<std::string> input = {"input", "--ground_truth", "good.tum"};
  const std::vector<std::string> truth = {"good.tum", "--ground_truth", "input"};
  const std::string good = kTum, states = kStates;
  return {
      {"NoInput", "", {}, "expected an output folder or a file", 2},
      {"UnknownFlag", "", {"good.tum", "--aligned", "se3"}, "--aligned", 2},
      {"UnknownAlignment", "", {"good.tum", "--align", "sim3"}, "--align: expected none, se3", 2},
      {"TimeOffsetNoNumber", "", {"good.tum", "--time_offset", "nan"}, "--time_offset", 2},

      {"MissingInput", "", {"absent.tum"}, "absent.tum: "},
      {"FolderWithoutResults", "", {"folder"}, "folder"},
      {"EmptyInput", "", input, "input: "},
      {"GarbageInput", Garbage(), input, "input:"},
      {"CommentsOnly", "# t x y z qx qy qz qw\n", input, "input:"},
      {"TumCutInALine", good.substr(0, good.size() - 6), input, "input:4: "},
      {"TumStampsRepeat", "1 1 1 1 0 0 0 1\n1 1 1 1 0 0 0 1\n", input, "input:2: "},
      {"TumStampsRunBack", "1 1 1 1 0 0 0 1\n0 1 1 1 0 0 0 1\n", input, "input:2: "},
      {"TumStampNan", "nan 1 1 1 0 0 0 1\n", input, "input:1: "},
      {"TumNumberNan", "1 nan 1 1 0 0 0 1\n", input, "input:1: "},
      {"TumQuaternionZero", "1 1 1 1 0 0 0 0\n", input, "input:1: "},
      {"StatesCutInARow", states + "0,1,1,1,0,0,0,1,0,0,0,0,0,0\n1,1,1", input, "input:3: "},
      {"StatesNoNumber", states + "0,1,1,1,0,0,0,1,x,0,0,0,0,0\n", input, "input:2: "},
      {"StatesStampsRepeat", states + "0,1,1,1,0,0,0,1,0,0,0,0,0,0\n0,1,1,1,0,0,0,1,0,0,0,0,0,0\n",
       input, "input:3: "},
      {"StatesWithoutRow", states, input, "input:1: no rows"},

      {"MissingTruth", "", {"good.tum", "--ground_truth", "absent.csv"}, "absent.csv: "},
      {"EmptyTruth", "", truth, "input"},
      {"GarbageTruth", Garbage(), truth, "input"},
      {"TruthCutInARow", good.substr(0, good.size() - 6), truth, "input:4: "},
      {"TruthStampsRunBack", "1 1 1 1 0 0 0 1\n0 1 1 1 0 0 0 1\n", truth, "input:2: "},
      {"TruthStampNan", "nan 1 1 1 0 0 0 1\n", truth, "input:1: "},
      {"TruthOfAnotherTime", "100 1 1 1 0 0 0 1\n101 1 1 1 0 0 0 1\n", truth, "good.tum: "},

      {"JsonBelowAFile", "", {"good.tum", "--json", "input/x.json"}, "input/x.json: "},
      {"JsonInNowhere", "", {"good.tum", "--json", "absent/x.json"}, "absent/x.json: "},
      {"HtmlBelowAFile", "", {"good.tum", "--html", "input/x.html"}, "input/x.html: "},
  };
}

class CompareRefusals : public ::testing::TestWithParam<Refusal> {};

TEST_P(CompareRefusals, OneLineAndNothingWritten) {
  const TempFolder folder;
  WriteText(folder / "input", GetParam().text);
  WriteText(folder / "good.tum", kTum);
  std::filesystem::create_directory(folder / "folder");
  const ProgramRun run = RunProgram(folder.path(), "tagtwist_compare", GetParam().arguments);
  EXPECT_EQ(run.status, GetParam().status) << run.err;
  EXPECT_TRUE(IsOneLine(run.err)) << run.err;
  EXPECT_THAT(run.err, StartsWith("tagtwist_compare: "));
  EXPECT_THAT(run.err, HasSubstr(GetParam().fault));
  EXPECT_EQ(run.out, "");
  EXPECT_EQ(ListTree(folder.path()), (std::vector<std::string>{"folder", "good.tum", "input"}));
}
INSTANTIATE_TEST_SUITE_P(All, CompareRefusals, ::testing::ValuesIn(Refusals()),
                         [](const auto& test) { return std::string(test.param.name); });

}  // namespace
}  // namespace tagtwist::internal::compare_refusals_test

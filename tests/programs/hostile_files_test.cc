// Files and places that nobody should give: one line within seconds, in bounded memory.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <thread>

#include "tests/support/program_test_util.h"
#include "tests/support/test_files.h"

namespace tagtwist {
namespace {

using Arguments = std::vector<std::string>;
using ::testing::HasSubstr;
using ::testing::StartsWith;

class HostileFiles : public testing::Test {
 protected:
  void SetUp() override {
    MakeRecording(folder_.path(), "rec", DatasetFormat::kFolder, /*images=*/false);
    WriteText(folder_ / "good.tum", "0 1 1 1 0 0 0 1\n1 2 1 1 0 0 0 1\n2 3 1 1 0 0 0 1\n");
  }
  ProgramRun Run(const std::string& program, const Arguments& arguments) {
    return RunProgram(folder_.path(), program, arguments);
  }
  ProgramRun Estimate(const Arguments& more) {
    Arguments arguments = {"--dataset", "rec", "--use_detections", "--output", "out"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return Run("tagtwist_estimate", arguments);
  }
  static void ExpectRefused(const ProgramRun& run, const std::string& fault) {
    EXPECT_EQ(run.status, 1) << fault;
    EXPECT_TRUE(IsOneLine(run.err)) << run.err;
    EXPECT_THAT(run.err, HasSubstr(fault));
    EXPECT_LT(run.wall_s, 5) << fault;
    EXPECT_LT(run.peak_rss_mib, 500) << fault;
  }

  TempFolder folder_;
};

TEST_F(HostileFiles, YamlThatNeverEndsOrHoldsItself) {
  const std::string key(60, 'k');
  for (const std::string& text :
       {std::string(","), std::string("[1],"), std::string("\xEF\xBB\xBF,x"),
        std::string("&a [*a]"), std::string("a: &a {b: *a}"), key + ": &a {" + key + ": *a}"}) {
    WriteText(folder_ / "x", text);
    ExpectRefused(Estimate({"--config", "x"}), "x:");
    ExpectRefused(Estimate({"--camera_file", "x"}), "x:");
    ExpectRefused(Estimate({"--map", "x"}), "x:");
  }
}

TEST_F(HostileFiles, XmlOfNumbersAlone) {
  std::string text = "<opencv_storage><a>";
  for (int i = 0; i < 4'000'000; ++i) text += "1 ";
  WriteText(folder_ / "x", text + "</a></opencv_storage>");
  ExpectRefused(Estimate({"--camera_file", "x"}), "x: expected a smaller file");
}

TEST_F(HostileFiles, TablesOfNamesAlone) {
  std::string header = "t";
  for (int i = 0; i < 420'000; ++i) header += ",c" + std::to_string(i);
  WriteText(folder_ / "x", header + "\n");
  ExpectRefused(Estimate({"--ground_truth", "x"}), "x:");
}

TEST_F(HostileFiles, DevicesAreNoFiles) {
  const std::string fault = "/dev/zero: expected a file, got a device";
  for (const char* flag : {"--config", "--camera_file", "--map", "--ground_truth", "--dataset"}) {
    ExpectRefused(Estimate({flag, "/dev/zero"}), fault);
  }
  ExpectRefused(Run("tagtwist_map", {"--check", "/dev/zero"}), fault);
  ExpectRefused(Run("tagtwist_compare", {"good.tum", "--ground_truth", "/dev/zero"}), fault);
  ExpectRefused(Run("tagtwist_compare", {"/dev/zero", "--ground_truth", "good.tum"}), fault);
  ExpectRefused(Run("tagtwist_simulate", {"--output", "sim", "--trajectory", "/dev/zero"}), fault);
  ExpectRefused(Run("tagtwist_simulate", {"--output", "sim", "--image_times", "/dev/zero"}), fault);
}

TEST_F(HostileFiles, PipesAreReadOnceOrRefused) {
  const std::string pipe = folder_ / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  for (const char* flag : {"--config", "--camera_file", "--map", "--ground_truth", "--dataset"}) {
    ExpectRefused(Estimate({flag, "pipe"}), "pipe: ");
  }
  const auto feed = [&](const std::string& text) {
    return std::thread([=] { WriteText(pipe, text); });
  };
  std::thread writer = feed(ReadText(std::string(TAGTWIST_SOURCE_DIR) + "/configs/course.yaml"));
  const ProgramRun configured = Estimate({"--config", "pipe"});
  writer.join();
  EXPECT_EQ(configured.status, 0) << configured.err;
  writer = feed(ReadText(folder_ / "good.tum"));
  const ProgramRun compared = Run("tagtwist_compare", {"good.tum", "--ground_truth", "pipe"});
  writer.join();
  EXPECT_EQ(compared.status, 0) << compared.err;
}

TEST_F(HostileFiles, AFullStandardOutputIsTold) {
  Surroundings full;
  full.out = "/dev/full";
  const auto run = [&](const std::string& program, const Arguments& arguments) {
    return RunProgram(folder_.path(), program, arguments, {}, full);
  };
  const std::string fault = "standard output: cannot write";
  const std::string map = std::string(TAGTWIST_SOURCE_DIR) + "/configs/course.yaml";
  ExpectRefused(run("tagtwist_map", {"--check", map}), fault);
  ExpectRefused(run("tagtwist_map", {"--help"}), fault);
  ExpectRefused(run("tagtwist_compare", {"good.tum", "--ground_truth", "good.tum"}), fault);
  ExpectRefused(run("tagtwist_simulate", {"--output", "sim", "--images=false", "--duration", "1"}),
                fault);
  ExpectRefused(run("tagtwist_estimate", {"--dataset", "rec", "--use_detections"}), fault);
}

}  // namespace
}  // namespace tagtwist

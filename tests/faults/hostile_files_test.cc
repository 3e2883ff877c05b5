// Files and places that nobody should give: one line within seconds, in bounded memory.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <zlib.h>

#include <nlohmann/json.hpp>
#include <thread>

#include "tests/support/program_test_util.h"
#include "tests/support/test_files.h"

namespace tagtwist::internal::hostile_files_test {
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
  ExpectRefused(Estimate({"--camera_file", "x"}),
                "x: expected a smaller file (--limits nodes=N raises that)");
}

TEST_F(HostileFiles, TablesOfNamesAlone) {
  std::string header = "t";
  for (int i = 0; i < 420'000; ++i) header += ",c" + std::to_string(i);
  WriteText(folder_ / "x", header + "\n");
  ExpectRefused(Estimate({"--ground_truth", "x"}), "x:");
}

TEST_F(HostileFiles, DevicesAreNoFiles) {
  const std::string fault = "/dev/zero: expected a file, got a device";
  for (const char* flag : {"--config", "--camera_file", "--map", "--ground_truth"}) {
    ExpectRefused(Estimate({flag, "/dev/zero"}), fault);
  }
  ExpectRefused(Run("tagtwist_estimate", {"--dataset", "/dev/zero", "--output", "out"}), fault);
  ExpectRefused(Run("tagtwist_map", {"--check", "/dev/zero"}), fault);
  ExpectRefused(Run("tagtwist_compare", {"good.tum", "--ground_truth", "/dev/zero"}), fault);
  ExpectRefused(Run("tagtwist_compare", {"/dev/zero", "--ground_truth", "good.tum"}), fault);
  ExpectRefused(Run("tagtwist_simulate", {"--output", "sim", "--trajectory", "/dev/zero"}), fault);
  ExpectRefused(Run("tagtwist_simulate", {"--output", "sim", "--image_times", "/dev/zero"}), fault);
}

TEST_F(HostileFiles, PipesAreReadOnceOrRefused) {
  const std::string pipe = folder_ / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  for (const char* flag : {"--config", "--camera_file", "--map", "--ground_truth"}) {
    ExpectRefused(Estimate({flag, "pipe"}), "pipe: ");
  }
  ExpectRefused(Run("tagtwist_estimate", {"--dataset", "pipe", "--output", "out"}), "pipe: ");
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

TEST_F(HostileFiles, SizesBeyondAllNumbersAreRefusedInBothModes) {
  const std::string course = ReadText(std::string(TAGTWIST_SOURCE_DIR) + "/configs/course.yaml");
  for (const auto& [key, value] : {std::pair("fx", "1e308"), {"tag_size_m", "1e-300"}}) {
    std::string text = course;
    const size_t at = text.find(std::string(key) + ": ") + std::string(key).size() + 2;
    text.replace(at, text.find_first_of(" #\n", at) - at, value);
    WriteText(folder_ / "x", text);
    ExpectRefused(Estimate({"--config", "x"}), key);
    ExpectRefused(Estimate({"--config", "x", "--sliding_window"}), key);
  }
}

TEST_F(HostileFiles, AWindowWithoutAnyPoseIsTold) {
  const std::string course = ReadText(std::string(TAGTWIST_SOURCE_DIR) + "/configs/course.yaml");
  std::string text = course;
  const size_t at = text.find("fx: ") + 4;
  text.replace(at, text.find_first_of(" #\n", at) - at, "1e-6");
  WriteText(folder_ / "x", text);
  const ProgramRun run = Estimate({"--config", "x", "--sliding_window"});
  EXPECT_EQ(run.status, 1) << run.out;
}

TEST_F(HostileFiles, AStreamOntoAFullDiskIsTold) {
  const ProgramRun run = Estimate({"--sliding_window", "--stream", "/dev/full"});
  ExpectRefused(run, "stream to /dev/full ended after 0 rows: No space left on device");
  EXPECT_TRUE(std::filesystem::exists(folder_ / "out/states.csv")) << "the results are there";
}

TEST_F(HostileFiles, NumbersOfFlagsAreNumbers) {
  for (const char* flag : {"--accel_psd=", "--accel_psd=0x10", "--max_frames=0x10",
                           "--threads=", "--accel_psd=+-1", "--accel_psd=nan"}) {
    const ProgramRun run = Estimate({flag});
    EXPECT_EQ(run.status, 2) << flag;
    EXPECT_TRUE(IsOneLine(run.err)) << run.err;
  }
  WriteText(folder_ / "x", "estimator: {accel_psd: +-1}\n");
  ExpectRefused(Estimate({"--config", "x"}), "accel_psd: expected a finite number");
}

TEST_F(HostileFiles, ACompressedVariableOfZerosIsNotInflatedWhole) {
  const uLong zeros = 120'000'000;
  std::string plain(zeros + 8, '\0'), packed(compressBound(zeros + 8), '\0');
  plain[0] = 14;  // a matrix, and its length
  for (int i = 0; i < 4; ++i) plain[size_t(4 + i)] = static_cast<char>(zeros >> (8 * i) & 0xFF);
  uLongf size = packed.size();
  ASSERT_EQ(compress(reinterpret_cast<Bytef*>(packed.data()), &size,
                     reinterpret_cast<const Bytef*>(plain.data()), plain.size()),
            Z_OK);
  std::string file(124, ' ');
  file += std::string("\0\1IM", 4) + std::string("\x0f\0\0\0", 4);
  for (int i = 0; i < 4; ++i) file += static_cast<char>(size >> (8 * i) & 0xFF);
  WriteText(folder_ / "x.mat", file + packed.substr(0, size));
  ExpectRefused(Run("tagtwist_estimate", {"--dataset", "x.mat", "--output", "out"}),
                "becomes larger than any recording");
}

TEST_F(HostileFiles, ABagWhoseHeaderIsLongerThanItIs) {
  WriteText(folder_ / "x.bag", std::string("#ROSBAG V2.0\n\x04\0\0\0\x3f\x42\x0f\0\0\0\0\0", 25));
  ExpectRefused(Run("tagtwist_estimate", {"--dataset", "x.bag", "--output", "out"}), "x.bag: ");
}

bool IsUtf8(const std::string& text) {
  for (size_t i = 0; i < text.size();) {
    const auto first = static_cast<unsigned char>(text[i++]);
    const int more = first < 0x80   ? 0
                     : first < 0xC2 ? -1
                     : first < 0xE0 ? 1
                     : first < 0xF0 ? 2
                     : first < 0xF5 ? 3
                                    : -1;
    if (more < 0) return false;
    for (int k = 0; k < more; ++k, ++i) {
      if (i >= text.size() || (static_cast<unsigned char>(text[i]) & 0xC0) != 0x80) return false;
    }
  }
  return true;
}

TEST_F(HostileFiles, ANameThatIsNoTextLeavesReportsText) {
  std::filesystem::rename(folder_ / "rec", folder_ / "r\xff<b>c");
  const ProgramRun run =
      Run("tagtwist_estimate", {"--dataset", "r\xff<b>c", "--use_detections", "--output", "out"});
  ASSERT_EQ(run.status, 0) << run.err;
  EXPECT_TRUE(IsUtf8(ReadText(folder_ / "out/report.html")));
  EXPECT_TRUE(IsUtf8(ReadText(folder_ / "out/summary.json")));
}

// What frames wait is the machine's time, whatever their stamps say.
TEST_F(HostileFiles, StampsAtTheEndOfAllNumbersHaveALatency) {
  for (const std::string seconds : {"4599999999.", "-4599999999."}) {
    const std::string rows = ReadText(folder_ / "rec/detections.csv");
    std::filesystem::create_directory(folder_ / ("at" + seconds));
    std::string text = rows.substr(0, rows.find('\n') + 1);
    for (size_t at = text.size(); at < rows.size();) {
      const std::string row = rows.substr(at, rows.find('\n', at) + 1 - at);
      const double t_s = std::stod(row);
      const int ms = static_cast<int>(1e3 * (seconds[0] == '-' ? 0.9 - t_s : t_s) + 0.5);
      const std::string digits = std::to_string(1000 + ms).substr(1);
      text += seconds + digits + row.substr(row.find(','));
      at += row.size();
    }
    WriteText(folder_ / ("at" + seconds) + "/detections.csv", text);
    const ProgramRun run =
        Run("tagtwist_estimate", {"--dataset", "at" + seconds, "--use_detections", "--output",
                                  "out", "--sliding_window", "--realtime"});
    ASSERT_EQ(run.status, 0) << run.err;
    const auto summary = nlohmann::json::parse(ReadText(folder_ / "out/summary.json"));
    EXPECT_GT(summary["live"]["latency_ms"]["p50"].get<double>(), 0);
    EXPECT_LT(summary["live"]["latency_ms"]["max"].get<double>(), 1e5);
  }
}

}  // namespace
}  // namespace tagtwist::internal::hostile_files_test

// MCAP files that the format's own library and another's serialisation of ROS 2 messages have
// written: the same trajectory as the folder that they were made from.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "frontend/io/recordings/data_source.h"
#include "tests/support/program_test_util.h"
#include "tests/support/test_files.h"

namespace tagtwist::internal::mcap_of_others_test {
namespace {

namespace fs = std::filesystem;

// Installed once for all builds and runs of one source tree's build folder; "" where that cannot
// be.
std::string NodeModules() {
  const std::string folder = TAGTWIST_NODE_DIR;
  if (std::system("command -v node >/dev/null && command -v npm >/dev/null") != 0) return "";
  if (!fs::exists(folder + "/node_modules/@mcap/core")) {
    fs::create_directories(folder);
    fs::copy_file(std::string(TAGTWIST_SOURCE_DIR) + "/tests/mcap/package.json",
                  folder + "/package.json", fs::copy_options::overwrite_existing);
    const std::string install =
        "cd '" + folder + "' && timeout 60 npm install --no-audit --no-fund >npm.log 2>&1";
    if (std::system(install.c_str()) != 0) return "";
  }
  return folder + "/node_modules";
}

class McapOfOthers : public testing::Test {
 protected:
  void SetUp() override {
    modules_ = NodeModules();
    if (modules_.empty()) GTEST_SKIP() << "npm is not there, or has not the packages";
    MakeRecording(folder_.path(), "rec", DatasetFormat::kFolder, true);
  }

  // The recording as write_mcap.mjs takes it.
  void WriteJson() {
    auto source = std::move(*OpenDataSource(folder_ / "rec", {}));
    nlohmann::json out;
    for (auto frame = source->Next(); frame && *frame; frame = source->Next()) {
      const cv::Mat& image = (*frame)->image;
      out["width"] = image.cols;
      out["height"] = image.rows;
      const std::string name = std::to_string((*frame)->t_ns) + ".gray";
      WriteText(folder_ / name, std::string(image.datastart, image.dataend));
      out["images"].push_back({{"t_ns", std::to_string((*frame)->t_ns)}, {"gray", name}});
    }
    for (const TruthSample& sample : source->ground_truth()) {
      const Eigen::Vector3d p = sample.world_from_body.translation();
      const Eigen::Quaterniond q(sample.world_from_body.rotation());
      out["poses"].push_back({{"t_ns", std::to_string(sample.t_ns)},
                              {"pose", {p.x(), p.y(), p.z(), q.x(), q.y(), q.z(), q.w()}}});
    }
    WriteText(folder_ / "recording.json", out.dump());
  }

  std::vector<double> Estimate(const std::string& dataset) {
    const ProgramRun run = RunProgram(folder_.path(), "tagtwist_estimate",
                                      {"--dataset", dataset, "--tracks=false", "--output", "out"});
    EXPECT_EQ(run.status, 0) << run.err;
    EXPECT_EQ(run.err, "") << dataset;
    std::istringstream in(ReadText(folder_ / "out/optimised.tum") +
                          ReadText(folder_ / "out/ground_truth.tum"));
    std::vector<double> out;
    for (std::string line; std::getline(in, line);) {
      std::istringstream words(line);
      for (double number = 0; words >> number;) out.push_back(number);
    }
    return out;
  }

  const TempFolder folder_;
  std::string modules_;
};

TEST_F(McapOfOthers, EveryFormGivesTheTrajectoryOfTheFolder) {
  WriteJson();
  const std::string command = "node '" + std::string(TAGTWIST_SOURCE_DIR) +
                              "/tests/mcap/write_mcap.mjs' '" + modules_ + "' '" + folder_.path() +
                              "/recording.json'";
  ASSERT_EQ(std::system(command.c_str()), 0);
  const std::vector<double> expected = Estimate("rec");
  ASSERT_GT(expected.size(), 60u);
  for (const char* name :
       {"unchunked.mcap", "chunked.mcap", "lz4.mcap", "zstd.mcap", "noindex.mcap"}) {
    const std::vector<double> read = Estimate(name);
    ASSERT_EQ(read.size(), expected.size()) << name;
    for (size_t i = 0; i < read.size(); ++i) EXPECT_NEAR(read[i], expected[i], 1e-9) << name;
  }
}

}  // namespace
}  // namespace tagtwist::internal::mcap_of_others_test

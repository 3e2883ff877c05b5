// Each target over the inputs that once showed a fault (corpus/NAME), over what the project's own
// writers make, and over that cut and spoiled: no crash, and no promise broken.
#include <gtest/gtest.h>

#include <filesystem>
#include <opencv2/core/utils/logger.hpp>

#include "tests/fuzz/fuzz_target.h"
#include "tests/support/test_files.h"

namespace tagtwist::internal::replay_test {
namespace {

namespace fs = std::filesystem;

class Fuzz : public testing::TestWithParam<FuzzTarget> {
 protected:
  static void SetUpTestSuite() {
    cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
    ::setenv("OPENCV_FFMPEG_LOGLEVEL", "-8", 0);
  }
  static bool Run(const std::string& bytes, const std::string& name) {
    try {
      return GetParam().run(bytes);
    } catch (const Broken& broken) {
      ADD_FAILURE() << GetParam().name << " " << name << ": " << broken.what();
    }
    return false;
  }
};

TEST_P(Fuzz, CorpusHolds) {
  const fs::path corpus = fs::path(TAGTWIST_SOURCE_DIR) / "tests/fuzz/corpus" / GetParam().name;
  if (!fs::exists(corpus)) return;
  for (const auto& entry : fs::directory_iterator(corpus)) {
    Run(ReadText(entry.path()), entry.path().filename());
  }
}

TEST_P(Fuzz, SeedsCutAndSpoiledHold) {
  const std::vector<FuzzSeed> seeds = GetParam().seeds();
  ASSERT_FALSE(seeds.empty());
  constexpr uint32_t kSpoiled = 24, kCut = 8;
  uint32_t draw = 7;
  for (const FuzzSeed& seed : seeds) {
    ASSERT_FALSE(seed.bytes.empty()) << seed.name;
    EXPECT_TRUE(Run(seed.bytes, seed.name)) << seed.name << ": refused";
    for (uint32_t i = 1; i < kCut; ++i) {
      Run(seed.bytes.substr(0, seed.bytes.size() * i / kCut), seed.name + " cut");
    }
    for (uint32_t i = 0; i < kSpoiled; ++i) {
      std::string bytes = seed.bytes;
      for (uint32_t k = 0; k <= i % 4; ++k) {
        draw = draw * 1664525 + 1013904223;
        bytes[(draw >> 8) % bytes.size()] = static_cast<char>(draw >> 3);
      }
      Run(bytes, seed.name + " spoiled " + std::to_string(i));
    }
  }
}

std::string NameOfTarget(const testing::TestParamInfo<FuzzTarget>& target) {
  return target.param.name;
}
INSTANTIATE_TEST_SUITE_P(Targets, Fuzz, testing::ValuesIn(FuzzTargets()), NameOfTarget);

}  // namespace
}  // namespace tagtwist::internal::replay_test

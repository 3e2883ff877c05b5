// A target for libFuzzer: tagtwist_fuzz --target=NAME FOLDER... -max_total_time=SECONDS. With
// --seeds=FOLDER it writes what the target starts from, and ends.
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <opencv2/core/utility.hpp>
#include <opencv2/core/utils/logger.hpp>
#include <string>

#include "tests/fuzz/fuzz_target.h"
#include "tests/support/test_files.h"

namespace {

const tagtwist::internal::FuzzTarget* g_target = nullptr;

std::string FlagOf(int argc, char** argv, const std::string& name) {
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word.rfind("--" + name + "=", 0) == 0) return word.substr(name.size() + 3);
  }
  return "";
}

}  // namespace

extern "C" int LLVMFuzzerInitialize(int* argc, char*** argv) {
  g_target = tagtwist::internal::FindFuzzTarget(FlagOf(*argc, *argv, "target"));
  if (g_target == nullptr) {
    std::fprintf(stderr, "--target=NAME: expected one of");
    for (const auto& target : tagtwist::internal::FuzzTargets())
      std::fprintf(stderr, " %s", target.name);
    std::fprintf(stderr, "\n");
    std::exit(2);
  }
  cv::setNumThreads(1);
  cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
  ::setenv("OPENCV_FFMPEG_LOGLEVEL", "-8", 0);
  const std::string folder = FlagOf(*argc, *argv, "seeds");
  if (folder.empty()) return 0;
  std::filesystem::create_directories(folder);
  for (const auto& seed : g_target->seeds()) {
    tagtwist::internal::WriteText(folder + "/" + seed.name, seed.bytes);
  }
  std::exit(0);
}

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  g_target->run(std::string(reinterpret_cast<const char*>(data), size));
  return 0;
}

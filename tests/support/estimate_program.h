#pragma once
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/support/program_test_util.h"
#include "tests/support/test_files.h"

namespace tagtwist::internal {

namespace fs = std::filesystem;
using Arguments = std::vector<std::string>;

/// tagtwist_estimate on flights that tagtwist_simulate draws, in a folder of its own.
class EstimateProgram : public testing::Test {
 protected:
  void Run(const std::string& program, const Arguments& arguments) {
    const ProgramRun run = RunProgram(folder_.path(), program, arguments);
    ASSERT_EQ(run.status, 0) << run.err;
  }
  void Simulate(const std::string& name, Arguments arguments) {
    arguments.insert(arguments.end(), {"--output", name});
    Run("tagtwist_simulate", arguments);
  }
  /// Runs the estimate into a folder of that name and returns its summary.
  nlohmann::json Estimate(const std::string& output, Arguments arguments) {
    arguments.insert(arguments.end(), {"--output", output});
    Run("tagtwist_estimate", arguments);
    const std::string text = ReadText(Path(output) / "summary.json");
    return text.empty() ? nlohmann::json() : nlohmann::json::parse(text);
  }
  fs::path Path(const std::string& name) const { return folder_ / name; }

  TempFolder folder_;
};

/// Of a summary: errors against those of the low-passed closed form.
inline double Ratio(const nlohmann::json& summary, const std::string& key,
                    const std::string& rows = "optimised") {
  return summary["accuracy"][rows][key].get<double>() /
         summary["accuracy"]["closed_form"][key].get<double>();
}

}  // namespace tagtwist::internal

#include <gflags/gflags.h>

#include <iostream>

#include "apps/compare/collect.h"
#include "apps/support/clean_end.h"
#include "apps/support/guarded_main.h"
#include "apps/support/limits_flag.h"
#include "apps/support/usage.h"
#include "estimator/report/html/comparison_report.h"
#include "frontend/base/files/atomic_file.h"
#include "frontend/base/files/run_files.h"
#include "frontend/base/number_text.h"
#include "frontend/io/trajectories/trajectory_file.h"

DEFINE_string(ground_truth, "",
              "Ground truth of all inputs: CSV with columns t,x,y,z,qx,qy,qz,qw and where it has "
              "them the twist, TUM, EuRoC/ASL or a course .mat. Without it: what lies beside an "
              "input.");
DEFINE_string(align, "none",
              "none; se3: the world moved rigidly onto the truth's; handeye: besides, a rigid "
              "transform between the body and the frame that the truth measures.");
DEFINE_string(time_offset, "none",
              "none; estimate; or seconds that the truth's clock is ahead of the estimate's.");
DEFINE_string(json, "", "Writes all figures to this file.");
DEFINE_bool(collect, false,
            "The inputs are folders of results of many recordings (tagtwist_fleet's, or any that "
            "have summaries below them): they are gathered in fleet.html, fleet.csv, fleet.json.");
DEFINE_string(output, "", "With --collect: where these go; the first folder where left out.");
DEFINE_string(against, "",
              "With --collect: an older folder, or its fleet.json: what became better or worse, "
              "beyond what chance would do.");
DEFINE_bool(mix_versions, false, "With --collect: results of several versions in one table.");
DEFINE_string(html, "", "Writes a page with the table and plots to this file.");

namespace tagtwist::internal {
namespace {

Usage CompareUsage() {
  return {
      "tagtwist_compare",
      "DIR|FILE [...] [--ground_truth FILE] [--align none|se3|handeye] [--json FILE]",
      "Compares trajectories with ground truth: ATE, RPE, velocity, rates, NEES. An input is an\n"
      "output folder of tagtwist_estimate, a states.csv, or poses as TUM, CSV or EuRoC/ASL.",
      {{"Ground truth", {"ground_truth", "align", "time_offset"}},
       {"Output", {"json", "html"}},
       {"Many recordings", {"collect", "output", "against", "mix_versions"}},
       {"Running", {"limits"}}},
      /*max_arguments=*/1000,
      {{"Batch against window, with the truth of both",
        "tagtwist_compare batch window --html compare.html"},
       {"Against motion capture of a marker, its clock unknown",
        "tagtwist_compare results --ground_truth vicon.csv --align handeye --time_offset "
        "estimate"},
       {"All runs below a folder in one table, and what changed since",
        "tagtwist_compare --collect results --against results_before"}}};
}

Result<EvaluationOptions> OptionsFromFlags() {
  EvaluationOptions out;
  const auto kind = ParseAlignmentKind(FLAGS_align);
  if (!kind) return Error{"--align: expected none, se3 or handeye, got '" + FLAGS_align + "'"};
  out.alignment.kind = *kind;
  if (FLAGS_time_offset == "estimate") {
    out.alignment.estimate_time_offset = true;
  } else if (FLAGS_time_offset != "none") {
    const auto seconds = ParseNumber(FLAGS_time_offset);
    if (!seconds) {
      return Error{"--time_offset: expected none, estimate or seconds, got '" + FLAGS_time_offset +
                   "'"};
    }
    out.alignment.time_offset_s = *seconds;
  }
  return out;
}

Result<Comparison> ReadAndCompare(const std::vector<std::string>& paths,
                                  const EvaluationOptions& options, const Limits& limits) {
  std::vector<NamedSeries> series;
  std::vector<TruthSample> truth;
  std::string truth_path = FLAGS_ground_truth;
  if (!truth_path.empty()) {
    auto read = ReadGroundTruth(truth_path, limits);
    if (!read) return read.error();
    truth = std::move(*read);
  }
  for (const std::string& path : paths) {
    auto results = ReadResultsAt(path, limits);
    if (!results) return results.error();
    for (NamedSeries& named : results->series) series.push_back(std::move(named));
    if (truth.empty() && !results->truth.empty()) {
      truth = std::move(results->truth);
      truth_path = results->truth_path;
    }
  }
  return Compare(std::move(series), std::move(truth), truth_path, options);
}

Status CheckInputsAreKept(const std::vector<std::string>& paths) {
  RunFiles files;
  for (const std::string& path : paths) {
    for (const std::string& file : FilesReadAt(path)) files.Reads("input", file);
  }
  files.Reads("--ground_truth", FLAGS_ground_truth);
  for (const auto& checked : {files.Writes("--json", FLAGS_json),
                              files.Writes("--html", FLAGS_html), files.WritesStandardOutput()}) {
    if (!checked) return checked;
  }
  return Ok();
}

Status Run(const std::vector<std::string>& paths, const EvaluationOptions& options,
           const Limits& limits) {
  if (const auto kept = CheckInputsAreKept(paths); !kept) return kept;
  const auto comparison = ReadAndCompare(paths, options, limits);
  if (!comparison) return comparison.error();
  if (!FLAGS_json.empty()) {
    const std::string json = FormatComparisonJson(*comparison);
    if (auto written = WriteFileAtomically(FLAGS_json, json); !written) return written;
  }
  if (!FLAGS_html.empty()) {
    const std::string html = FormatComparisonReport(*comparison);
    if (auto written = WriteFileAtomically(FLAGS_html, html); !written) return written;
  }
  std::cout << FormatComparisonTable(comparison->rows, options.rpe_seconds);
  return Ok();
}

int Main(int argc, char** argv, const Usage& usage) {
  const auto paths = ParseFlagsOrExit2(argc, argv, usage);
  if (paths.empty()) return Fail(usage, "expected an output folder or a file", 2);
  const auto options = OptionsFromFlags();
  if (!options) return Fail(usage, options.error().message, 2);
  const auto limits = LimitsFromFlag();
  if (!limits) return Fail(usage, limits.error().message, 2);
  if (FLAGS_collect) {
    const std::string output = FLAGS_output.empty() ? paths.front() : FLAGS_output;
    const CleanEnd end(usage, {{}, output});
    const auto told = Collect({paths, output, FLAGS_against, FLAGS_mix_versions});
    if (!told) return Fail(usage, told.error().message);
    std::cout << *told;
    return 0;
  }
  if (!FLAGS_output.empty() || !FLAGS_against.empty() || FLAGS_mix_versions) {
    return Fail(usage, "--output, --against, --mix_versions: expected with --collect", 2);
  }
  const CleanEnd end(usage, {{FLAGS_json, FLAGS_html}, ""});
  const auto done = Run(paths, *options, *limits);
  return done ? 0 : Fail(usage, done.error().message);
}

}  // namespace
}  // namespace tagtwist::internal

int main(int argc, char** argv) {
  return tagtwist::internal::GuardedMain(argc, argv, tagtwist::internal::CompareUsage,
                                         tagtwist::internal::Main);
}

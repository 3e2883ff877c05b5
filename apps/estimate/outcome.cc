#include "apps/estimate/outcome.h"

#include <ostream>

#include "estimator/report/findings/findings.h"
#include "estimator/report/findings/verdict.h"

namespace tagtwist::internal {

Outcome TellResults(const EstimateJob& job, const Estimate& estimate, const ResultContext& context,
                    std::ostream* told) {
  const std::vector<Finding> findings =
      Findings(estimate, context.facts, context.map, context.truth);
  for (const Finding& finding : findings) {
    *told << "finding: " << finding.fact << " " << finding.advice << "\n";
  }
  *told << FormatComparisonTable(context.rows) << "\nreport: " << job.output
        << "/report.html\nverdict: "
        << VerdictText(estimate, findings, context.truth, context.facts.doubts) << "\n";
  if (!estimate.warnings.empty()) return Outcome::kWarnings;
  return findings.empty() ? Outcome::kClean : Outcome::kFindings;
}

Error FailureOf(const EstimateJob& job, const Error& error, const Inputs& taken,
                const Doubts& doubts, const RunFacts& facts) {
  std::vector<std::string> told = taken.warnings;
  for (const Fault& fault : doubts) told.push_back(TextOf(fault));
  const auto written = WriteFailure(job.output, error.message, told, facts);
  return written ? WithDoubts(error, taken, doubts) : written.error();
}

}  // namespace tagtwist::internal

#include "apps/estimate/rows.h"

#include <utility>

#include "frontend/base/spans.h"

namespace tagtwist::internal {
namespace {

constexpr size_t kMostKept = 8192;  // two and a half minutes at 60 Hz; some 30 MB

// The overlay and the gyro's alignment go over all states once more; results do not.
bool NeedsAllStates(const EstimateJob& job) { return !job.overlay.empty() || job.calibrate; }

}  // namespace

void WriteAsTheyCome(const EstimateJob& job, ResultRows* rows, RunOptions* options) {
  if (!options->sliding_window) return;
  if (!NeedsAllStates(job)) options->most_kept = kMostKept;
  options->on_state = [rows](size_t body, const FrameEstimate& frame) {
    return rows->Add(body, frame);
  };
  options->on_lagged = [rows](size_t body, const FrameEstimate& frame) {
    return rows->AddLagged(body, frame);
  };
}

RowsAsked RowsOf(const EstimateJob& job, const Config& config) {
  RowsAsked out{job.write_covariance, job.write_detections, {config.body}};
  for (const TaggedBody& other : config.bodies) out.bodies.push_back(other.name);
  return out;
}

Status WriteResultsOf(const EstimateJob& job, std::unique_ptr<ResultRows> rows,
                      const Estimate& estimate, const ResultContext& context) {
  const Span span(job.run.spans, "write results");
  if (!job.run.sliding_window) {
    const Status added = AddStates(estimate, context.of_others, rows.get());
    if (!added) return added;
  }
  return WriteResults(job.output, std::move(rows), estimate, context);
}

}  // namespace tagtwist::internal

#include "estimator/batch/imu/imu_stage.h"

#include <algorithm>
#include <utility>

#include "estimator/batch/batch_states.h"
#include "estimator/imu/surer_states.h"
#include "estimator/result/imu_left_out.h"
#include "estimator/solve/contradictions.h"

namespace tagtwist::internal {

namespace {

struct ImuStage {
  std::vector<int> state_of_frame;
  ImuSolution solved;
};

Result<ImuStage> SolveStage(const EstimatorSetup& setup, const NoiseModel& noise,
                            const ImuRecord& imu, const std::vector<FrameMeasurements>& measured,
                            const std::vector<GraphFrame>& stamped,
                            const std::vector<int>& state_of_frame, const GraphInput& input,
                            const Trajectory& states) {
  ImuStage out;
  std::vector<GraphFrame> frames;
  std::vector<const std::vector<TagDetection>*> seen;
  const std::vector<ImuSample> samples = InBody(imu.samples, CalibrationAsTold(imu.options));
  for (size_t i = 0; i < stamped.size(); ++i) {
    const int k = state_of_frame[i];
    out.state_of_frame.push_back(-1);
    if (k < 0 && !Covers(samples, stamped[i].t_ns)) continue;
    out.state_of_frame.back() = static_cast<int>(frames.size());
    seen.push_back(&measured[i].tags);
    if (k >= 0) {
      frames.push_back(input.frames[static_cast<size_t>(k)]);
    } else {
      frames.push_back(stamped[i]);
      frames.back().tags.clear();
      frames.back().state = states.At(stamped[i].t_ns)->state;
    }
  }
  auto solved = SolveWithImu(setup, noise, imu, std::move(frames));
  if (!solved) return solved.error();
  out.solved = std::move(*solved);
  std::vector<GraphFrame> revised = out.solved.input.frames;
  if (ReviseTags(setup, noise, out.solved.solution.graph, seen, /*readmit=*/true, &revised)) {
    const ImuModel found = out.solved.model;
    solved = SolveWithImu(setup, noise, imu, std::move(revised), &found);
    if (!solved) return solved.error();
    out.solved = std::move(*solved);
  }
  return out;
}

}  // namespace

std::vector<Eigen::VectorXd> TakeImu(const EstimatorSetup& setup,
                                     const std::optional<ImuRecord>& imu,
                                     const std::vector<FrameMeasurements>& measured,
                                     const std::vector<GraphFrame>& stamped,
                                     const SolvedByTags& solved, Estimate* out) {
  if (!imu) return {};
  const Trajectory by_tags =
      MakeTrajectory(solved.solution->graph.states, solved.solution->covariance, out->noise);
  // Which way the body turned in a gap the gyro says; of mirrored poses it was not asked.
  const bool is_open = std::any_of(solved.open->begin(), solved.open->end(),
                                   [](const OpenAccounts& accounts) { return !accounts.of_turns; });
  auto stage = is_open ? Error{"small tags leave two poses open"}
                       : SolveStage(setup, out->noise, *imu, measured, stamped,
                                    *solved.state_of_frame, *solved.input, by_tags);
  if (!stage) {
    out->warnings.push_back(ImuLeftOut(stage.error().message));
    return {};
  }
  solved.open->clear();
  *solved.state_of_frame = std::move(stage->state_of_frame);
  std::swap(stage->solved.input.segments, solved.input->segments);
  *solved.input = std::move(stage->solved.input);
  *solved.solution = std::move(stage->solved.solution);
  out->noise = stage->solved.noise;
  out->imu = stage->solved.found;
  return std::move(stage->solved.shared_errors);
}

void TakeSurer(Estimate by_tags, Estimate* out) {
  SurerStates surer;
  size_t n_by_tags = 0;
  for (size_t i = 0; i < out->frames.size(); ++i) {
    if (surer.Choose(by_tags.frames[i], &out->frames[i])) ++n_by_tags;
  }
  if (2 * n_by_tags > out->frames.size()) out->trajectory = std::move(by_tags.trajectory);
}

}  // namespace tagtwist::internal

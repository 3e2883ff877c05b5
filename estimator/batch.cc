#include "estimator/batch.h"

#include <string>
#include <utility>

#include "estimator/seeding.h"
#include "estimator/smoother.h"

namespace tagtwist {
namespace {

Trajectory MakeTrajectory(const Solution& solution, const NoiseModel& noise) {
  Trajectory out;
  out.linear = noise.linear;
  out.angular = noise.angular;
  out.states = solution.graph.states;
  for (int k = 0; k < solution.covariance.size(); ++k) {
    out.covariances.push_back(solution.covariance.At(k, k));
    if (k + 1 < solution.covariance.size()) {
      out.cross_covariances.push_back(solution.covariance.At(k + 1, k));
    }
  }
  return out;
}

// Solves under white noise on jerk and, where that is open, under white noise on acceleration too;
// the likelier one stays.
Result<Solution> SolveWithLikelierPrior(const EstimatorSetup& setup, const SolveOptions& options,
                                        GraphInput* input, NoiseModel* noise) {
  *noise = InitialNoise(setup.options);
  if (!MotionPriorIsOpen(setup.options)) return SolveAndLearn(setup, options, input, noise);
  GraphInput other_input = *input;
  auto solution = SolveAndLearn(setup, options, input, noise);
  if (!solution) return solution;
  NoiseModel other = InitialNoise(setup.options, WhiteNoiseOn::kAcceleration);
  other.corner_sigma_px = noise->corner_sigma_px;
  other.track_sigma_px = noise->track_sigma_px;
  auto other_solution = SolveAndLearn(setup, options, &other_input, &other);
  if (other_solution && other_solution->log_likelihood > solution->log_likelihood) {
    *input = std::move(other_input);
    *noise = other;
    return other_solution;
  }
  return solution;
}

}  // namespace

BatchEstimator::BatchEstimator(EstimatorSetup setup)
    : setup_(std::move(setup)),
      segmenter_({setup_.options.max_tracks_per_frame, setup_.options.track_segment_frames}) {}

void BatchEstimator::Add(FrameMeasurements measurement) {
  segmenter_.Add(measurement.tracks, static_cast<int>(measurement.tags.size()));
  n_tracks_.push_back(static_cast<int>(measurement.tracks.size()));
  measurement.tracks = {};
  measurements_.push_back(std::move(measurement));
}

Result<BatchResult> BatchEstimator::Solve() const {
  auto seeds = SeedFrames(setup_, measurements_);
  if (!seeds) return seeds.error();
  GraphInput input;
  input.frames = std::move(*seeds);
  input.segments = segmenter_.segments();

  BatchResult out;
  const SolveOptions options{setup_.options.max_iterations};
  auto solution = SolveWithLikelierPrior(setup_, options, &input, &out.noise);
  if (!solution) return solution.error();
  if (const auto wrong = ContradictedTags(solution->graph); !wrong.empty()) {
    out.warnings.push_back(std::to_string(wrong.size()) +
                           " tag observations contradict the others and are left out");
    DropTags(wrong, &input.frames);
    solution = SolveAndLearn(setup_, options, &input, &out.noise);
    if (!solution) return solution.error();
  }
  for (size_t i = 0; i < input.frames.size(); ++i) {
    const int k = static_cast<int>(i);
    out.frames.push_back(ToFrameEstimate(measurements_[i].closed_form, n_tracks_[i],
                                         input.frames[i], BodyCovariance(solution->covariance, k)));
    const std::vector<double> errors = ReprojectionErrors(setup_, input.frames[i]);
    out.reprojection_px.insert(out.reprojection_px.end(), errors.begin(), errors.end());
  }
  out.trajectory = MakeTrajectory(*solution, out.noise);
  return out;
}

Result<BatchResult> RunBatch(const EstimatorSetup& setup,
                             const std::vector<FrameMeasurements>& measurements) {
  BatchEstimator batch(setup);
  for (const FrameMeasurements& m : measurements) batch.Add(m);
  return batch.Solve();
}

}  // namespace tagtwist

#include "estimator/batch.h"

#include <string>
#include <utility>

#include "estimator/seeding.h"
#include "estimator/smoother.h"

namespace tagtwist {
namespace {

Trajectory MakeTrajectory(const std::vector<GraphFrame>& frames,
                          const BlockBandedMatrix& covariance, const NoiseModel& noise) {
  Trajectory out;
  out.accel_psd = noise.accel_psd;
  out.angular_accel_psd = noise.angular_accel_psd;
  for (size_t i = 0; i < frames.size(); ++i) {
    const int k = static_cast<int>(i);
    out.t_ns.push_back(frames[i].t_ns);
    out.states.push_back(frames[i].state);
    out.covariances.push_back(covariance.At(k, k));
    if (i + 1 < frames.size()) out.cross_covariances.push_back(covariance.At(k + 1, k));
  }
  return out;
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
  out.noise = InitialNoise(setup_.options);
  const SolveOptions options{setup_.options.max_iterations};
  auto solution = SolveAndLearn(setup_, options, &input, &out.noise);
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
                                         input.frames[i], solution->covariance.At(k, k)));
    const std::vector<double> errors = ReprojectionErrors(setup_, input.frames[i]);
    out.reprojection_px.insert(out.reprojection_px.end(), errors.begin(), errors.end());
  }
  out.trajectory = MakeTrajectory(input.frames, solution->covariance, out.noise);
  return out;
}

Result<BatchResult> RunBatch(const EstimatorSetup& setup,
                             const std::vector<FrameMeasurements>& measurements) {
  BatchEstimator batch(setup);
  for (const FrameMeasurements& m : measurements) batch.Add(m);
  return batch.Solve();
}

}  // namespace tagtwist

#include "estimator/batch.h"

#include <string>
#include <utility>

#include "estimator/seeding.h"
#include "estimator/smoother.h"
#include "estimator/track_segments.h"

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

Result<BatchResult> RunBatch(const EstimatorSetup& setup,
                             const std::vector<FrameMeasurements>& measurements) {
  auto seeds = SeedFrames(setup, measurements);
  if (!seeds) return seeds.error();
  TrackSegmenter segmenter(
      {setup.options.max_tracks_per_frame, setup.options.track_segment_frames});
  for (const FrameMeasurements& m : measurements) segmenter.Add(m.tracks);

  GraphInput input;
  input.frames = std::move(*seeds);
  input.segments = segmenter.segments();
  BatchResult out;
  out.noise = InitialNoise(setup.options);
  const SolveOptions options{setup.options.max_iterations};
  auto solution = SolveAndLearn(setup, options, &input, &out.noise);
  if (!solution) return solution.error();
  if (const int dropped = DropContradictedTags(solution->graph, &input.frames); dropped > 0) {
    out.warnings.push_back(std::to_string(dropped) + " tag observations contradict the others");
    solution = SolveAndLearn(setup, options, &input, &out.noise);
    if (!solution) return solution.error();
  }
  for (size_t i = 0; i < input.frames.size(); ++i) {
    const int k = static_cast<int>(i);
    out.frames.push_back(
        ToFrameEstimate(measurements[i], input.frames[i], solution->covariance.At(k, k)));
    const std::vector<double> errors = ReprojectionErrors(setup, input.frames[i]);
    out.reprojection_px.insert(out.reprojection_px.end(), errors.begin(), errors.end());
  }
  out.trajectory = MakeTrajectory(input.frames, solution->covariance, out.noise);
  return out;
}

}  // namespace tagtwist

#include "estimator/batch/rig/rig_calibration.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "estimator/batch/batch.h"
#include "estimator/batch/first_solve.h"
#include "estimator/batch/model_choice.h"
#include "estimator/batch/rig/rig_start.h"
#include "estimator/batch/uneven_motion.h"
#include "estimator/rig/rig_tags.h"
#include "estimator/rig/tags_at_stamp.h"
#include "estimator/solve/contradictions.h"
#include "estimator/solve/noise_learning.h"
#include "estimator/solve/noise_rounds.h"
#include "estimator/start/recording_start.h"
#include "frontend/types/so3.h"
#include "residuals/lens.h"

namespace tagtwist::internal {
namespace {

// What data have to overrule: any mount on a body that one carries.
constexpr double kAnyMountRad = 0.3, kAnyMountM = 0.3;

EstimatorOptions WithoutTracks(EstimatorOptions options) {
  options.use_tracks = false;
  return options;
}

// Of one camera, as if it were the body; where it stands, in whose place the map is.
SetUp Alone(const SetUp& set_up, size_t camera) {
  SetUp out = set_up;
  out.rig.cameras = {set_up.rig.cameras[camera]};
  out.rig.front().cam_from_body = Pose();
  out.rig.front().covariance.resize(0, 0);
  return out;
}

std::vector<FrameMeasurements> OfCamera(const std::vector<FrameMeasurements>& measurements,
                                        int camera) {
  std::vector<FrameMeasurements> out;
  for (const FrameMeasurements& frame : measurements) {
    std::vector<TagDetection> tags = TagsOfCamera(frame.tags, camera);
    if (tags.empty()) continue;
    for (TagDetection& tag : tags) tag.camera = 0;
    out.push_back({frame.t_ns, std::move(tags), {}, {}, false, {}});
  }
  return out;
}

// With each camera's clock moved on; what falls on one stamp is one frame.
std::vector<FrameMeasurements> MoveClocks(const std::vector<FrameMeasurements>& measurements,
                                          const std::vector<double>& clocks_s) {
  std::map<int64_t, FrameMeasurements> by_stamp;
  for (const FrameMeasurements& frame : measurements) {
    for (const TagDetection& tag : frame.tags) {
      const double clock_s = clocks_s[static_cast<size_t>(tag.camera)];
      const int64_t t_ns = frame.t_ns + std::llround(1e9 * clock_s);
      FrameMeasurements& moved = by_stamp[t_ns];
      moved.t_ns = t_ns;
      moved.tags.push_back(tag);
    }
  }
  std::vector<FrameMeasurements> out;
  for (auto& [t_ns, frame] : by_stamp) out.push_back(std::move(frame));
  return out;
}

Result<Estimate> RunRig(const SetUp& set_up, const EstimatorOptions& options,
                        const std::vector<FrameMeasurements>& measurements,
                        const ForRanges& for_ranges) {
  BatchEstimator batch(set_up, options, for_ranges);
  for (const FrameMeasurements& frame : measurements) batch.Add(frame);
  return batch.Solve();
}

// Under a rolling shutter the corners as of the stamps.
Result<std::vector<FrameMeasurements>> AsOfStamps(const SetUp& set_up,
                                                  const EstimatorOptions& options,
                                                  std::vector<FrameMeasurements> measurements,
                                                  const ForRanges& for_ranges) {
  const EstimatorSetup setup = MakeEstimatorSetup(set_up, options);
  if (!setup.HasRollingShutter()) return measurements;
  const auto estimate = RunRig(set_up, options, measurements, for_ranges);
  if (!estimate) return estimate.error();
  const Trajectory& states = estimate->trajectory;
  for (FrameMeasurements& frame : measurements) {
    const auto motion =
        MotionOfRows(setup, frame.t_ns, [&](int64_t t_ns) { return states.At(t_ns); });
    if (motion) frame.tags = TagsAsOfStamp(setup, *motion, std::move(frame.tags));
  }
  return measurements;
}

// All frames with tags, solved, and what that says of the mounts.
Result<MountBorder> BorderOf(const SetUp& set_up, const EstimatorOptions& options,
                             const MountPriors& priors,
                             const std::vector<FrameMeasurements>& seen) {
  const EstimatorSetup setup = MakeEstimatorSetup(set_up, options);
  auto starts = StartFrames(setup, seen);
  if (!starts) return starts.error();
  GraphInput input;
  std::vector<const std::vector<TagDetection>*> tags;
  for (size_t i = 0; i < starts->size(); ++i) {
    if ((*starts)[i].tags.empty()) continue;
    input.frames.push_back(std::move((*starts)[i]));
    tags.push_back(&seen[i].tags);
  }
  const SolveOptions solve{options.max_iterations, 0};
  NoiseModel noise = ChooseNoise(setup, input.frames, InitialNoise(options));
  auto solution = SolveFromStarts(setup, solve, &input, &noise);
  constexpr int kMostRounds = 4;
  for (int round = 0; solution && round < kMostRounds; ++round) {
    if (!ReviseTags(setup, noise, solution->graph, tags, round == 0, &input.frames)) break;
    solution = SolveAndLearn(setup, solve, &input, &noise);
  }
  if (!solution) return solution.error();
  solution = LetMotionVary(setup, solve, std::move(*solution), &input, &noise);
  if (!solution) return solution.error();
  const SystematicBasis basis(setup, TagsSeenMost(input.frames), /*mounts_are_right=*/true);
  SystematicErrors errors;
  if (options.systematic_errors) errors = LearnSystematicErrors(basis, noise, input.frames);
  auto out = MakeMountBorder(basis, errors, priors, setup.n_cameras(), noise, solution->graph,
                             input.frames);
  if (!out) return Error{"the mounts are tied by nothing"};
  return std::move(*out);
}

class RigCalibrator {
 public:
  RigCalibrator(const SetUp& set_up, const EstimatorOptions& options, const MountPriors& priors,
                const std::vector<FrameMeasurements>& measurements, const ForRanges& for_ranges)
      : given_(set_up),
        now_(set_up),
        options_(WithoutTracks(options)),
        priors_{priors.rotation_rad > 0 ? kAnyMountRad : 0, priors.position_m > 0 ? kAnyMountM : 0,
                priors.clock_s},
        measurements_(measurements),
        for_ranges_(for_ranges),
        clocks_s_(set_up.rig.cameras.size(), 0.0),
        open_clocks_s_(clocks_s_) {
    for (RigCamera& camera : now_.rig.cameras) HoldMount(&camera);
  }

  // Each camera by itself.
  Status Start() {
    Trajectory first;
    for (size_t i = 0; i < now_.rig.cameras.size(); ++i) {
      RigCamera& camera = now_.rig.cameras[i];
      const auto own = OfCamera(measurements_, static_cast<int>(i));
      frames_.push_back(static_cast<int>(own.size()));
      const auto wrong = [&](const std::string& why) {
        return Error{camera.name + ": " + why + ", and so nothing says how it is mounted"};
      };
      if (own.empty()) return wrong("sees no tag of the map");
      auto alone = RunRig(Alone(given_, i), options_, own, for_ranges_);
      if (!alone) return wrong(alone.error().message);
      if (i == 0) {
        first = std::move(alone->trajectory);
        continue;
      }
      const auto mount = StartMount(first, alone->frames, now_.rig.mounted_on, priors_.clock_s);
      if (!mount) return wrong(mount.error().message);
      Pose start = mount->cam_from_first * now_.rig.front().cam_from_body;
      const Pose& given = camera.cam_from_body;
      if (priors_.rotation_rad == 0) start = MakePose(given.rotation(), start.translation());
      if (priors_.position_m == 0) start = MakePose(start.rotation(), given.translation());
      camera.cam_from_body = start;
      MoveClock(i, mount->clock_s);
    }
    return Ok();
  }

  // States of all with mounts and clocks, in turns.
  Status Refine() {
    constexpr int kMostRounds = 6;
    constexpr double kSettled = 0.1;
    for (rounds_ = 1; rounds_ <= kMostRounds; ++rounds_) {
      const auto seen =
          AsOfStamps(now_, options_, MoveClocks(measurements_, clocks_s_), for_ranges_);
      if (!seen) return seen.error();
      auto border = BorderOf(now_, options_, priors_, *seen);
      if (!border) return border.error();
      border_ = std::move(*border);
      // What stood open of the clocks is in the step again.
      MountBorder step = border_;
      for (size_t i = 1; i < clocks_s_.size(); ++i) {
        step.step(Entry(i) + 6) -= open_clocks_s_[i];
        Take(i, border_.step.segment<MountBorder::kEntries>(Entry(i)));
      }
      if (step.StepInSigmas() < kSettled) return Ok();
    }
    return Ok();  // as near as it comes: the sigmas have what is left
  }

  RigCalibration Finish() && {
    RigCalibration out;
    for (size_t i = 1; i < now_.rig.cameras.size(); ++i) out.cameras.push_back(Found(i));
    out.rounds = rounds_;
    out.set_up = std::move(now_);
    return out;
  }

 private:
  static Eigen::Index Entry(size_t camera) {
    return MountBorder::kEntries * (static_cast<Eigen::Index>(camera) - 1);
  }

  // What was known of a mount is not known of the one that is found.
  static void HoldMount(RigCamera* camera) {
    if (camera->covariance.size() == 0) return;
    camera->covariance.rightCols<6>().setZero();
    camera->covariance.bottomRows<6>().setZero();
  }

  // Into the stamps where it is worth states of their own; else it stands open.
  void MoveClock(size_t camera, double by_s) {
    constexpr double kWorthItS = 5e-4;
    if (std::abs(by_s) > kWorthItS) {
      clocks_s_[camera] += by_s;
      by_s = 0;
    }
    open_clocks_s_[camera] = by_s;
  }

  void Take(size_t i, const Eigen::Matrix<double, MountBorder::kEntries, 1>& step) {
    RigCamera& camera = now_.rig.cameras[i];
    camera.cam_from_body =
        camera.cam_from_body * MakePose(ExpSo3(step.head<3>()), step.segment<3>(3));
    MoveClock(i, step(6));
  }

  MountFound Found(size_t i) {
    RigCamera& camera = now_.rig.cameras[i];
    MountFound out;
    out.name = camera.name;
    out.frames = frames_[i];
    out.change = Difference(camera.cam_from_body, given_.rig.cameras[i].cam_from_body);
    // Of cam_from_body's step: the shift in the camera's axes.
    Eigen::Matrix<double, 6, 6> to_step = Eigen::Matrix<double, 6, 6>::Identity();
    to_step.bottomRightCorner<3, 3>() = camera.cam_from_body.rotation().toRotationMatrix();
    const Eigen::Matrix<double, 6, 6> covariance =
        to_step * border_.covariance.block<6, 6>(Entry(i), Entry(i)) * to_step.transpose();
    out.sigma = covariance.diagonal().cwiseMax(0).cwiseSqrt();
    const Eigen::Index lens = LensSize(camera.camera);
    if (camera.covariance.size() == 0) camera.covariance.setZero(lens + 6, lens + 6);
    camera.covariance.bottomRightCorner<6, 6>() = covariance;
    const Eigen::Index clock = Entry(i) + 6;
    out.clock_s = clocks_s_[i] + open_clocks_s_[i];
    out.clock_sigma_s = std::sqrt(std::max(0.0, border_.covariance(clock, clock)));
    constexpr double kSeen = 3, kHardly = 0.5;
    out.clock_is_seen = out.clock_sigma_s > 0 && std::abs(out.clock_s) > kSeen * out.clock_sigma_s;
    if (out.clock_is_seen) camera.clock_offset_s += out.clock_s;
    const char* const names[] = {"turn about x", "turn about y", "turn about z", "x", "y", "z"};
    for (Eigen::Index e = 0; e < 6; ++e) {
      const double prior = e < 3 ? priors_.rotation_rad : priors_.position_m;
      if (prior > 0 && out.sigma(e) > kHardly * prior) out.unseen.emplace_back(names[e]);
    }
    if (out.clock_sigma_s > kHardly * priors_.clock_s) out.unseen.emplace_back("clock");
    return out;
  }

  const SetUp& given_;
  SetUp now_;
  EstimatorOptions options_;
  MountPriors priors_;
  const std::vector<FrameMeasurements>& measurements_;
  const ForRanges& for_ranges_;
  std::vector<int> frames_;            // of each camera, with tags
  std::vector<double> clocks_s_;       // that stamps have grown by,
  std::vector<double> open_clocks_s_;  // and what they were left without
  MountBorder border_;
  int rounds_ = 0;
};

}  // namespace

Result<RigCalibration> CalibrateRig(const SetUp& set_up, const EstimatorOptions& options,
                                    const MountPriors& priors,
                                    const std::vector<FrameMeasurements>& measurements,
                                    const ForRanges& for_ranges) {
  RigCalibrator calibrator(set_up, options, priors, measurements, for_ranges);
  if (const Status started = calibrator.Start(); !started) return started.error();
  if (const Status refined = calibrator.Refine(); !refined) return refined.error();
  return std::move(calibrator).Finish();
}

}  // namespace tagtwist::internal

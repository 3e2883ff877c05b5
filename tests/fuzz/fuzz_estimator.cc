// Batch and window over any detections, tracks, stamps and options in range: no state without a
// number, every covariance positive, every refusal told.
#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "estimator/batch/batch.h"
#include "estimator/online/config.h"
#include "estimator/window/sliding_window.h"
#include "frontend/tags/filter_tags.h"
#include "tests/fuzz/fuzz_bytes.h"
#include "tests/fuzz/fuzz_target.h"

namespace tagtwist::internal {
namespace {

const SetUp& CourseSetUpOnce() {
  static const SetUp set_up = DefaultConfig().set_up;
  return set_up;
}

std::optional<double> Maybe(FuzzBytes* in, double low_exponent, double high_exponent) {
  if (in->Below(3) != 0) return std::nullopt;
  return std::pow(10, in->Between(low_exponent, high_exponent));
}

EstimatorOptions TakeOptions(FuzzBytes* in) {
  EstimatorOptions out;
  out.corner_sigma_px = Maybe(in, -3, 2);
  out.track_sigma_px = Maybe(in, -3, 2);
  out.accel_psd = Maybe(in, -6, 6);
  out.angular_accel_psd = Maybe(in, -6, 6);
  out.jerk_psd = Maybe(in, -6, 6);
  out.angular_jerk_psd = Maybe(in, -6, 6);
  out.motion_prior = static_cast<MotionPriorChoice>(in->Below(3));
  out.clock = static_cast<ClockChoice>(in->Below(3));
  out.use_tracks = in->Below(2) == 1;
  out.max_tracks_per_frame = static_cast<int>(in->Below(20));
  out.track_segment_frames = 2 + static_cast<int>(in->Below(5));
  out.robust_scale = std::pow(10, in->Between(-2, 3));
  out.window_frames = 2 + static_cast<int>(in->Below(8));
  out.max_iterations = 1 + static_cast<int>(in->Below(10));
  out.window_iterations = 1 + static_cast<int>(in->Below(5));
  return out;
}

// Long gaps are two at most: each may take hundreds of states, under the sanitizers seconds.
int64_t TakeStep(FuzzBytes* in, int* long_gaps) {
  constexpr int64_t kLongNs = 300'000'000;
  const size_t kind = in->Below(8);
  if (kind < 5) return 20'408'163;
  const auto step_ns =
      std::max<int64_t>(1, std::llround(std::pow(10, in->Between(0, kind == 5 ? 12 : 9))));
  return step_ns < kLongNs || ++*long_gaps <= 2 ? step_ns : step_ns % kLongNs + 1;
}

// Where the body is: over the mat, drifting; with a byte in 16 anywhere.
Pose TakePose(FuzzBytes* in) {
  const bool anywhere = in->Below(16) == 0;
  const double far = anywhere ? 50 : 0.3, turned = anywhere ? 3 : 0.3;
  const auto vector =
      [&](double most) {  // one after the other: compilers order arguments as they like
        Eigen::Vector3d out;
        for (double& value : out) value = in->Between(-most, most);
        return out;
      };
  const Eigen::Vector3d turn = vector(turned);
  const Eigen::Vector3d at = Eigen::Vector3d(1.5, 1.3, anywhere ? 0 : 1.2) + vector(far);
  const Eigen::Vector3d axis = turn.norm() > 0 ? turn.normalized() : Eigen::Vector3d::UnitX();
  return MakePose(Eigen::Quaterniond(Eigen::AngleAxisd(turn.norm(), axis)), at);
}

OptionalApart<Eigen::Matrix<double, 8, 8>> TakeCovariance(FuzzBytes* in) {
  if (in->Below(3) != 0) return std::nullopt;
  Eigen::Matrix<double, 8, 1> common, own;
  for (int i = 0; i < 8; ++i) {
    own(i) = std::pow(10, in->Between(-4, 2));
    common(i) = in->Between(-1, 1);
  }
  return Eigen::Matrix<double, 8, 8>(common * common.transpose() * own.mean() +
                                     Eigen::Matrix<double, 8, 8>(own.asDiagonal()));
}

TagDetection TakeTag(FuzzBytes* in, const Pose& world_from_body) {
  const SetUp& set_up = CourseSetUpOnce();
  const RigCamera& seen_by = set_up.rig.front();
  const Pose cam_from_world = seen_by.cam_from_body * Inverse(world_from_body);
  const Tag& tag = set_up.map.tags()[in->Take<uint8_t>() % set_up.map.tags().size()];
  TagDetection out;
  out.id = tag.id;
  const size_t kind = in->Below(8);
  const double noise_px = kind < 5 ? 0.3 : kind < 7 ? 20 : 500;
  const auto corners = TagCornersInWorld(tag);
  for (size_t k = 0; k < 4; ++k) {
    Eigen::Vector2d pixel(188, 120);
    if (kind != 7) seen_by.camera.Project(cam_from_world * corners[k], &pixel);
    for (double& coordinate : pixel) coordinate += in->Between(-noise_px, noise_px);
    out.corners[k] = pixel;
  }
  out.covariance = TakeCovariance(in);
  return out;
}

std::vector<TrackObservation> TakeTracks(FuzzBytes* in, int64_t* newest) {
  std::map<int64_t, TrackObservation> out;
  for (size_t n = in->Below(6); n > 0; --n) {
    TrackObservation track;
    const auto back = static_cast<int64_t>(in->Below(4));
    track.track_id = back == 0 ? ++*newest : std::max<int64_t>(0, *newest - back);
    track.pixel = {in->Between(-20, 400), in->Between(-20, 260)};
    track.on_tag = in->Below(4) == 0;
    out[track.track_id] = track;
  }
  std::vector<TrackObservation> tracks;
  for (const auto& [id, track] : out) tracks.push_back(track);
  return tracks;
}

std::vector<FrameMeasurements> TakeFrames(FuzzBytes* in) {
  const SetUp& set_up = CourseSetUpOnce();
  std::vector<FrameMeasurements> out;
  int64_t t_ns = in->Take<int32_t>(), newest_track = 0;
  Pose world_from_body = TakePose(in);
  int long_gaps = 0;
  for (size_t n = 1 + in->Below(12); n > 0; --n) {
    FrameMeasurements frame;
    frame.t_ns = t_ns += TakeStep(in, &long_gaps);
    if (in->Below(8) == 0) world_from_body = TakePose(in);
    std::vector<TagDetection> tags;
    for (size_t k = in->Below(6); k > 0; --k) tags.push_back(TakeTag(in, world_from_body));
    frame.tags = FilterTags(tags, set_up.map, set_up.rig.front().camera, 0);
    frame.tracks = TakeTracks(in, &newest_track);
    frame.cut_short = in->Below(16) == 0;
    out.push_back(std::move(frame));
  }
  return out;
}

void PromiseSound(const FrameEstimate& frame) {
  Promise(std::set<std::string>{"ok", "hurried", "predicted", "ambiguous", "no_fix"}.count(
              ToString(frame.status)) == 1,
          "a status without a name");
  if (frame.status == FrameStatus::kNoFix) return;
  Promise(frame.state.world_from_body.params.allFinite(), "a pose without a number");
  Promise(frame.state.twist.v_world.allFinite() && frame.state.twist.omega_body.allFinite(),
          "a twist without a number");
  Promise(frame.covariance.allFinite(), "a covariance without a number");
  const StateVector sigmas = frame.covariance.diagonal().cwiseSqrt();
  Promise(sigmas.allFinite() && (sigmas.array() > 0).all(), "a variance that is not positive");
  StateCovariance correlation = frame.covariance;
  correlation.array() /= (sigmas * sigmas.transpose()).array();
  Promise((correlation - correlation.transpose()).cwiseAbs().maxCoeff() < 1e-6,
          "a covariance that is not symmetric");
  const StateCovariance lifted = correlation + 1e-9 * StateCovariance::Identity();
  Promise(lifted.llt().info() == Eigen::Success, "a covariance that is not positive");
}

bool RunWindow(const EstimatorOptions& options, const std::vector<FrameMeasurements>& frames) {
  SlidingWindow window(CourseSetUpOnce(), options);
  for (const FrameMeasurements& frame : frames) {
    const auto out = window.Add(frame);
    if (!IsTaken(out)) return false;
    Promise(out->current.t_ns == frame.t_ns, "the answer for another frame");
    PromiseSound(out->current);
    for (const FrameEstimate& lagged : out->lagged) PromiseSound(lagged);
  }
  const auto ahead = window.PredictAt(frames.back().t_ns + 30'000'000);
  if (ahead) Promise(ahead->covariance.allFinite(), "a prediction without a number");
  IsTaken(window.CheckSetUp());
  for (const FrameEstimate& frame : window.Finish()) PromiseSound(frame);
  window.Warnings();
  return true;
}

}  // namespace

bool FuzzEstimator(const std::string& bytes) {
  FuzzBytes in(bytes);
  const EstimatorOptions options = TakeOptions(&in);
  if (options.Problem()) return false;
  const std::vector<FrameMeasurements> frames = TakeFrames(&in);
  const bool taken = RunWindow(options, frames);
  const auto batch = RunBatch(CourseSetUpOnce(), options, frames);
  if (!IsTaken(batch)) return taken;
  Promise(batch->frames.size() == frames.size(), "frames that got lost");
  for (const FrameEstimate& frame : batch->frames) PromiseSound(frame);
  return true;
}

std::vector<FuzzSeed> EstimatorSeeds() {
  std::vector<FuzzSeed> out;
  uint32_t state = 1;
  for (int n = 0; n < 24; ++n) {
    std::string bytes;
    for (int i = 0; i < 900; ++i) {
      state = state * 1664525 + 1013904223;
      bytes += static_cast<char>(state >> 24);
    }
    // The options' bytes say that nothing is given, in most of them.
    if (n % 3 != 0) bytes.replace(0, 6, std::string(6, '\1'));
    if (FuzzEstimator(bytes)) out.push_back({"draw" + std::to_string(n), bytes});
  }
  return out;
}

}  // namespace tagtwist::internal

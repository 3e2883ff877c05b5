// Batch and window over any detections, tracks, stamps and options in range, of a dozen frames.
#include <algorithm>
#include <cmath>
#include <map>

#include "frontend/tags/filter_tags.h"
#include "tests/fuzz/fuzz_bytes.h"
#include "tests/fuzz/fuzz_estimating.h"
#include "tests/fuzz/fuzz_target.h"

namespace tagtwist::internal {
namespace {

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

}  // namespace

bool FuzzEstimator(const std::string& bytes) {
  FuzzBytes in(bytes);
  const EstimatorOptions options = TakeOptions(&in);
  if (options.Problem()) return false;
  const std::vector<FrameMeasurements> frames = TakeFrames(&in);
  return EstimatesSoundly(options, frames);
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

#include "estimator/calibration/set_up/set_up_fault.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "estimator/calibration/set_up/set_up_hypotheses.h"
#include "estimator/calibration/set_up/set_up_variants.h"
#include "frontend/base/format_text.h"
#include "frontend/geometry/frame_pose.h"
#include "frontend/geometry/pose_refine.h"

namespace tagtwist::internal {
namespace {

constexpr size_t kMostFrames = 30, kMostForVariants = 12;
constexpr size_t kLeastTags = 4;  // a frame on average: to say that the map is another
constexpr double kGoodPx = 1;     // the median tag of a good set-up stays below

// Frames with at least two tags, spread over the recording, those with more tags first among
// neighbours.
std::vector<size_t> Spread(const std::vector<SeenTags>& frames, size_t most) {
  std::vector<size_t> out;
  for (size_t part = 0; part < most; ++part) {
    const size_t begin = part * frames.size() / most, end = (part + 1) * frames.size() / most;
    size_t best = frames.size();
    for (size_t i = begin; i < end; ++i) {
      const bool better = best == frames.size() || frames[i].tags.size() > frames[best].tags.size();
      if (frames[i].tags.size() >= 2 && better) best = i;
    }
    if (best < frames.size()) out.push_back(best);
  }
  return out;
}

struct Agreement {
  double share = 0;  // of the tags that agree with their frame's pose
  double rms_px = 0;
};

Agreement AgreementOf(const std::vector<SeenTags>& frames, const Camera& camera,
                      const TagMap& map) {
  size_t agree = 0, all = 0;
  double squares = 0;
  for (const SeenTags& frame : frames) {
    const FramePose seed = FindFramePose(frame.tags, map, camera, Pose());
    all += frame.tags.size();
    if (seed.status != FramePoseStatus::kOk) continue;
    const auto inliers =
        static_cast<size_t>(std::count(seed.tag_inlier.begin(), seed.tag_inlier.end(), true));
    agree += inliers >= 2 ? inliers : 0;
    squares += seed.rms_px * seed.rms_px;
  }
  if (all == 0) return {};
  return {static_cast<double>(agree) / static_cast<double>(all),
          std::sqrt(squares / static_cast<double>(frames.size()))};
}

// Another map under which nearly all tags agree, where they do not as given.
std::optional<Fault> FindVariant(const std::vector<SeenTags>& frames, const Camera& camera,
                                 const TagMap& map) {
  constexpr double kAgree = 0.75, kBetter = 0.3;
  const Agreement given = AgreementOf(frames, camera, map);
  if (given.share > 0.6) return std::nullopt;
  std::optional<Fault> out;
  Agreement best{0, std::numeric_limits<double>::infinity()};
  for (const SetUpVariant& variant : SetUpVariants(map)) {
    const Agreement with = AgreementOf(frames, camera, variant.map);
    const bool better = with.share > best.share + 0.02 ||
                        (with.share > best.share - 0.02 && with.rms_px < best.rms_px);
    if (!(with.share >= kAgree && with.share > given.share + kBetter) || !better) continue;
    best = with;
    out = Fault{variant.fact, variant.advice};
  }
  return out;
}

// The frame's pose as all its corners have it.
std::optional<Pose> PoseOf(const SeenTags& frame, const Camera& camera, const TagMap& map) {
  const FramePose seed = FindFramePose(frame.tags, map, camera, Pose());
  if (seed.status != FramePoseStatus::kOk) return std::nullopt;
  std::vector<PointInImage> points;
  for (const TagDetection& tag : frame.tags) {
    for (size_t i = 0; i < 4; ++i)
      points.push_back({map.CornersInWorld(tag.id)[i], tag.corners[i]});
  }
  const Pose start = Inverse(seed.world_from_body);
  const RefinedPose refined = RefinePose(start, points, camera);
  return std::isfinite(refined.squared_error_px2) ? refined.cam_from_world : start;
}

std::vector<PosedFrame> Posed(const std::vector<SeenTags>& frames, const Camera& camera,
                              const TagMap& map) {
  constexpr double kLongestS = 0.25;
  std::vector<PosedFrame> out;
  for (const size_t i : Spread(frames, kMostFrames)) {
    const auto pose = PoseOf(frames[i], camera, map);
    if (!pose) continue;
    PosedFrame frame{frames[i], *pose, Pose(), Pose(), 0};
    if (i > 0 && i + 1 < frames.size() && frames[i - 1].tags.size() >= 2 &&
        frames[i + 1].tags.size() >= 2) {
      const double between_s = ToSeconds(frames[i + 1].t_ns - frames[i - 1].t_ns);
      const auto before = PoseOf(frames[i - 1], camera, map);
      const auto after = PoseOf(frames[i + 1], camera, map);
      if (between_s > 0 && between_s < kLongestS && before && after) {
        frame.cam_before = *before;
        frame.cam_after = *after;
        frame.between_s = between_s;
      }
    }
    out.push_back(std::move(frame));
  }
  return out;
}

// Starts from where a descent may reach the truth though it lies far off.
std::vector<SetUpChange> StartsOf(const FreeChanges& free) {
  std::vector<SetUpChange> out(1);
  for (const double factor : {0.5, 0.7, 1.4, 2.0}) {
    SetUpChange start;
    if (free[0]) start.log_focal = std::log(factor);
    if (free[10]) {
      start.log_squeeze = std::log(factor);
    } else if (free[1]) {
      start.log_resolution = std::log(factor);
    }
    if (free[6]) start.log_size = 0.5 * std::log(factor);
    if (free[4]) start.radial.x() = 0.36 * std::log(factor);  // k1 from -0.25 to 0.25
    if (free[8]) start.log_stretch.setConstant(std::log(factor));
    if (free[0] || free[1] || free[4] || free[6] || free[8]) out.push_back(start);
  }
  return out;
}

// Information criterion: corners give two numbers each.
double Score(const SetUpFit& fit, const FreeChanges& free) {
  const double numbers = 2 * static_cast<double>(fit.corners);
  const auto count = static_cast<double>(std::count(free.begin(), free.end(), true));
  return numbers * std::log(fit.cost / numbers) + count * std::log(numbers);
}

double RmsOf(const SetUpFit& fit) {
  return std::sqrt(fit.cost / static_cast<double>(std::max<size_t>(1, fit.corners)));
}

std::optional<Fault> FindChange(const std::vector<PosedFrame>& frames, const Camera& camera,
                                double line_time_s, const TagMap& map) {
  constexpr double kMended = 0.65, kLeastGainPx = 0.1;  // what anyone would see
  constexpr double kMostLeftPx = 3;                     // where it explains everything
  constexpr double kGained = 0.9, kCertain = 200;       // what only many corners show
  SetUpChange as_given;
  as_given.line_time_s = line_time_s;
  const SetUpFit rough = FitSetUp(frames, camera, map, {}, as_given, 1e3);
  const double huber_px = std::max(1.0, 2 * rough.median_px);
  const SetUpFit given = FitSetUp(frames, camera, map, {}, as_given, huber_px);
  const double at_first = Score(given, {});
  std::optional<Fault> out;
  double best = std::numeric_limits<double>::infinity();
  for (const SetUpHypothesis& hypothesis : SetUpHypotheses()) {
    for (SetUpChange start : StartsOf(hypothesis.free)) {
      start.line_time_s = line_time_s;
      const SetUpFit fit = FitSetUp(frames, camera, map, hypothesis.free, start, huber_px);
      const bool seen = fit.median_px < kMended * given.median_px &&
                        given.median_px - fit.median_px > kLeastGainPx;
      const double score = Score(fit, hypothesis.free);
      const bool certain = fit.cost < kGained * given.cost && score < at_first - kCertain;
      if (!(seen || certain) || !(score < best) || !(fit.median_px < kMostLeftPx)) continue;
      const auto words = hypothesis.words(fit, camera, seen ? 1 : 2.5, line_time_s);
      if (!words) continue;
      best = score;
      out = words;
      out->fact +=
          Format(" Errors fall from %.2f to %.2f px RMS with it.", RmsOf(given), RmsOf(fit));
    }
  }
  const size_t tags = given.corners / 4;
  if (out || !(given.median_px > 4 * kGoodPx) || tags < kLeastTags * frames.size()) return out;
  return Fault{Format("The tags do not lie as the map has them: the median tag is %.0f px off, "
                      "and no single mistake in focal length, resolution, crop, lens, sizes "
                      "or shutter explains it.",
                      given.median_px),
               "Look whether the map is of these tags, in the order of their ids, and the "
               "calibration of this camera."};
}

}  // namespace

std::optional<Fault> FindSetUpFault(const std::vector<SeenTags>& frames, const Camera& camera,
                                    double line_time_s, const TagMap& map) {
  std::vector<SeenTags> known;
  for (const SeenTags& frame : frames) {
    SeenTags in_map{frame.t_ns, {}};
    for (const TagDetection& tag : frame.tags) {
      if (map.Find(tag.id) != nullptr) in_map.tags.push_back(tag);
    }
    known.push_back(std::move(in_map));
  }
  std::vector<SeenTags> few;
  for (const size_t i : Spread(known, kMostForVariants)) few.push_back(known[i]);
  if (few.size() < 3) return std::nullopt;
  if (auto variant = FindVariant(few, camera, map)) return variant;
  std::vector<PosedFrame> posed = Posed(known, camera, map);
  if (line_time_s != 0) {  // where nothing is known of the motion, it cannot be undone
    posed.erase(std::remove_if(posed.begin(), posed.end(),
                               [](const PosedFrame& frame) { return !(frame.between_s > 0); }),
                posed.end());
  }
  if (posed.size() < 3) return std::nullopt;
  return FindChange(posed, camera, line_time_s, map);
}

}  // namespace tagtwist::internal

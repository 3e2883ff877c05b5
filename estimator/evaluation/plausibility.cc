#include "estimator/evaluation/plausibility.h"

#include <algorithm>
#include <cmath>

#include "frontend/base/format_text.h"
#include "frontend/types/lens/lens.h"

namespace tagtwist::internal {
namespace {

double Median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

void AddFieldOfView(const Camera& camera, std::vector<Fault>* out) {
  constexpr double kLeastDeg = 1, kMostDeg = 175;
  const double focal = FocalLengthOnAxis(camera), aspect = camera.fy / camera.fx;
  const double width_deg = 2 * 57.29578 * std::atan(0.5 * camera.width / focal);
  const double height_deg = 2 * 57.29578 * std::atan(0.5 * camera.height / (aspect * focal));
  const auto bad = [&](double deg) { return deg < kLeastDeg || deg > kMostDeg; };
  if (camera.lens == LensModel::kRadialTangential && (bad(width_deg) || bad(height_deg))) {
    out->push_back({Format("The calibration gives the camera a field of view of %.3g x %.3g deg.",
                           width_deg, height_deg),
                    "Focal lengths are in pixels, of images of the size that is told."});
  }
}

void AddCentre(const Camera& camera, std::vector<Fault>* out) {
  const double u = camera.cx / camera.width, v = camera.cy / camera.height;
  if (u > 0 && u < 1 && v > 0 && v < 1) return;
  out->push_back({Format("The calibration's principal point (%.0f, %.0f) is off its images of "
                         "%d x %d px.",
                         camera.cx, camera.cy, camera.width, camera.height),
                  "It is for images of another resolution, or width and height are exchanged; of a "
                  "crop far from the middle it may be right."});
}

// Whether two tags lie on one sheet.
bool AreCoplanar(const Tag& a, const Tag& b) {
  const Eigen::Vector3d up = a.world_from_tag.rotation() * Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d other = b.world_from_tag.rotation() * Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d apart = b.world_from_tag.translation() - a.world_from_tag.translation();
  return up.dot(other) > 0.99 && std::abs(up.dot(apart)) < 0.1 * a.size_m;
}

void AddGaps(const TagMap& map, std::vector<Fault>* out) {
  constexpr double kLeastShare = 0.06;  // of the side: half a cell of the coarsest families
  const std::vector<Tag>& tags = map.tags();
  size_t close = 0;
  double least_m = INFINITY, size_m = 0;
  for (size_t i = 1; i < tags.size(); ++i) {  // ids that follow each other lie side by side
    const Tag &a = tags[i - 1], &b = tags[i];
    const double side_m = 0.5 * (a.size_m + b.size_m);
    const double gap_m =
        (a.world_from_tag.translation() - b.world_from_tag.translation()).norm() - side_m;
    if (!(gap_m < kLeastShare * side_m) || !AreCoplanar(a, b)) continue;
    ++close;
    if (gap_m < least_m) size_m = side_m;
    least_m = std::min(least_m, gap_m);
  }
  if (2 * close < tags.size() || tags.size() < 2) return;
  out->push_back(
      {Format("The map's tags of %.4g m lie %.3g m apart, %.3f of their size: without a white "
              "border between them none is found.",
              size_m, least_m, least_m / size_m),
       "Kalibr's tagSpacing is a share of the size, not metres; gaps are between black squares."});
}

}  // namespace

std::vector<Fault> ImplausibleMap(const TagMap& map) {
  constexpr double kLargestM = 5, kSmallestM = 1e-3;
  std::vector<Fault> out;
  double smallest_m = INFINITY, largest_m = 0;
  for (const Tag& tag : map.tags()) {
    smallest_m = std::min(smallest_m, tag.size_m);
    largest_m = std::max(largest_m, tag.size_m);
  }
  if (largest_m > kLargestM) {
    out.push_back({Format("The map has tags of %.4g m.", largest_m),
                   "Lengths are in metres: are these millimetres?"});
  } else if (smallest_m < kSmallestM) {
    out.push_back(
        {Format("The map has tags of %.3g mm.", 1e3 * smallest_m), "Lengths are in metres."});
  }
  AddGaps(map, &out);
  return out;
}

std::vector<Fault> ImplausibleSetUp(const Camera& camera, const TagMap& map) {
  std::vector<Fault> out = ImplausibleMap(map);
  AddFieldOfView(camera, &out);
  AddCentre(camera, &out);
  return out;
}

std::vector<Fault> ImplausibleMotion(const std::vector<TimedPose>& poses) {
  constexpr double kFastestMps = 50, kLongS = 2, kSmooth = 0.3;
  constexpr size_t kLeast = 10;
  std::vector<Fault> out;
  std::vector<double> steps_s, speeds_mps, firsts_m, seconds_m;
  for (size_t i = 1; i < poses.size(); ++i) {
    const Eigen::Vector3d step =
        poses[i].world_from_body.translation() - poses[i - 1].world_from_body.translation();
    steps_s.push_back(ToSeconds(poses[i].t_ns - poses[i - 1].t_ns));
    speeds_mps.push_back(step.norm() / steps_s.back());
    firsts_m.push_back(step.norm());
    if (i + 1 == poses.size()) continue;
    const Eigen::Vector3d next =
        poses[i + 1].world_from_body.translation() - poses[i].world_from_body.translation();
    seconds_m.push_back((next - step).norm());
  }
  if (steps_s.size() < kLeast) return out;
  const double interval_s = Median(steps_s), speed_mps = Median(speeds_mps);
  const double first_m = Median(firsts_m), second_m = Median(seconds_m);
  if (speed_mps > kFastestMps) {
    out.push_back({Format("The body moves at %.0f m/s (median), with a frame in %.3g ms.",
                          speed_mps, 1e3 * interval_s),
                   "Stamps in another unit (microseconds for nanoseconds), or a map in "
                   "millimetres, do that."});
  } else if (interval_s > kLongS && second_m < kSmooth * first_m) {
    out.push_back(
        {Format("Frames come one in %.3g s, and yet the body moves on from frame to frame "
                "as in a film.",
                interval_s),
         Format("Stamps in milliseconds do that: these would come at %.3g Hz.", 1e3 / interval_s)});
  }
  return out;
}

}  // namespace tagtwist::internal

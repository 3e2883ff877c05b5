#include "estimator/calibration/lens/layout_from_nothing.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "estimator/calibration/lens/lens_start.h"
#include "estimator/calibration/mapping.h"
#include "frontend/base/statistics/quantile.h"
#include "frontend/geometry/homography.h"

namespace tagtwist::internal {
namespace {

constexpr size_t kFramesToPlace = 3;  // a tag

// In the plane, in sides of a tag: centre, the turned side, and how long it is against the others.
struct Placed {
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();
  Eigen::Vector2d along_x = Eigen::Vector2d::UnitX();
  double side = 1;
};
using Sheet = std::map<int, Placed>;

std::array<Eigen::Vector2d, 4> CornersOf(const Placed& tag) {
  const Eigen::Vector2d x = 0.5 * tag.along_x.normalized(), y(-x.y(), x.x());
  return {tag.centre - x - y, tag.centre + x - y, tag.centre + x + y, tag.centre - x + y};
}

std::optional<Eigen::Matrix3d> PlaneFromImage(const FrameMeasurements& frame, const Sheet& sheet) {
  std::vector<Eigen::Vector2d> in_plane, in_image;
  for (const TagDetection& tag : frame.tags) {
    const auto placed = sheet.find(tag.id);
    if (placed == sheet.end()) continue;
    const auto corners = CornersOf(placed->second);
    in_plane.insert(in_plane.end(), corners.begin(), corners.end());
    in_image.insert(in_image.end(), tag.corners.begin(), tag.corners.end());
  }
  return FitHomography(in_image, in_plane, true);
}

// nullopt where the homography throws it far off: it is near the horizon.
std::optional<Placed> Seen(const TagDetection& tag, const Eigen::Matrix3d& plane_from_image) {
  constexpr double kFarthest = 1000;  // sides
  std::array<Eigen::Vector2d, 4> c;
  for (size_t i = 0; i < 4; ++i) {
    c[i] = Transfer(plane_from_image, tag.corners[i]);
    if (!(c[i].norm() < kFarthest)) return std::nullopt;
  }
  Placed out;
  out.centre = 0.25 * (c[0] + c[1] + c[2] + c[3]);
  const Eigen::Vector2d x = 0.5 * (c[1] - c[0] + c[2] - c[3]);
  const Eigen::Vector2d y = 0.5 * (c[3] - c[0] + c[2] - c[1]);
  out.along_x = x + Eigen::Vector2d(y.y(), -y.x());  // y turned back by a right angle
  out.side = 0.5 * (x.norm() + y.norm());
  if (!(out.along_x.norm() > 0)) return std::nullopt;
  out.along_x.normalize();
  return out;
}

// What frames propose for each tag that is not placed.
std::map<int, std::vector<Placed>> Proposals(const std::vector<FrameMeasurements>& frames,
                                             const Sheet& sheet) {
  std::map<int, std::vector<Placed>> out;
  for (const FrameMeasurements& frame : frames) {
    const auto plane_from_image = PlaneFromImage(frame, sheet);
    if (!plane_from_image) continue;
    for (const TagDetection& tag : frame.tags) {
      if (sheet.count(tag.id) != 0) continue;
      if (const auto seen = Seen(tag, *plane_from_image)) out[tag.id].push_back(*seen);
    }
  }
  return out;
}

double Median(const std::vector<Placed>& all, double (*of)(const Placed&)) {
  std::vector<double> values;
  for (const Placed& one : all) values.push_back(of(one));
  return Quantile(values, 0.5);
}

Placed MedianOf(const std::vector<Placed>& all) {
  Placed out;
  out.centre = {Median(all, [](const Placed& p) { return p.centre.x(); }),
                Median(all, [](const Placed& p) { return p.centre.y(); })};
  out.along_x = {Median(all, [](const Placed& p) { return p.along_x.x(); }),
                 Median(all, [](const Placed& p) { return p.along_x.y(); })};
  out.side = Median(all, [](const Placed& p) { return p.side; });
  return out;
}

int SeenMostOften(const std::vector<FrameMeasurements>& frames) {
  std::map<int, size_t> count;
  for (const FrameMeasurements& frame : frames) {
    for (const TagDetection& tag : frame.tags) ++count[tag.id];
  }
  int out = -1;
  size_t most = 0;
  for (const auto& [id, n] : count) {
    if (n > most) most = n, out = id;
  }
  return out;
}

TagMap AsMap(const Sheet& sheet, const LayoutSought& sought) {
  std::vector<Tag> tags;
  for (const auto& [id, placed] : sheet) {
    const double angle = std::atan2(placed.along_x.y(), placed.along_x.x());
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()));
    const Eigen::Vector2d at = sought.tag_size_m * placed.centre;
    tags.push_back({id, MakePose(turn, {at.x(), at.y(), 0}), sought.tag_size_m, 0});
  }
  return TagMap(sought.family, std::move(tags));
}

// The sheet as it grows, and what its homographies disagree by.
struct SheetFound {
  Sheet sheet;
  std::vector<double> errors;  // sides, of each tag's proposals to the one that was taken
  std::optional<std::pair<int, double>> odd;  // the first tag of another size, and the ratio
  double error() const { return errors.empty() ? 1e9 : Quantile(errors, 0.5); }
};

SheetFound GrowSheet(const std::vector<FrameMeasurements>& frames, int root) {
  constexpr double kMostRatio = 1.1;  // of sides; what is left of the lens makes some of it
  SheetFound out;
  out.sheet[root] = {};
  while (true) {
    const auto proposals = Proposals(frames, out.sheet);
    const std::pair<const int, std::vector<Placed>>* most = nullptr;
    for (const auto& one : proposals) {
      if (most == nullptr || one.second.size() > most->second.size()) most = &one;
    }
    if (most == nullptr || most->second.size() < kFramesToPlace) return out;
    const Placed placed = MedianOf(most->second);
    for (const Placed& one : most->second) {
      out.errors.push_back((one.centre - placed.centre).norm() + std::abs(one.side - 1));
    }
    const bool fits = placed.side < kMostRatio && placed.side > 1 / kMostRatio;
    if (!fits && !out.odd) out.odd = {most->first, placed.side};
    out.sheet[most->first] = placed;
  }
}

// The corners as a pinhole would see them instead of an equidistant lens of that focal length; tags
// that no pinhole sees are left out.
std::vector<FrameMeasurements> Straightened(const std::vector<FrameMeasurements>& frames,
                                            const LayoutSought& sought, double focal_px) {
  constexpr double kFarthestRad = 1.2;  // from the axis
  const Eigen::Vector2d centre(0.5 * (sought.width - 1), 0.5 * (sought.height - 1));
  std::vector<FrameMeasurements> out = frames;
  for (FrameMeasurements& frame : out) {
    std::vector<TagDetection> kept;
    for (TagDetection tag : frame.tags) {
      bool is_seen = true;
      for (Eigen::Vector2d& corner : tag.corners) {
        const Eigen::Vector2d from_centre = corner - centre;
        const double radius = from_centre.norm(), angle_rad = radius / focal_px;
        is_seen = is_seen && angle_rad < kFarthestRad;
        if (is_seen && radius > 0) corner = std::tan(angle_rad) * focal_px / radius * from_centre;
      }
      if (is_seen) kept.push_back(tag);
    }
    frame.tags = std::move(kept);
  }
  return out;
}

}  // namespace

// Equidistant lenses from no bending of lines to that of a fisheye, which a barrel's comes near,
// too.
Result<TagMap> SheetByHomographies(const std::vector<FrameMeasurements>& frames,
                                   const LayoutSought& sought) {
  const int root = SeenMostOften(frames);
  if (root < 0) return Error{"no frame shows a tag"};
  SheetFound best;
  double best_widths = 0;
  const auto consider = [&](double widths) {
    SheetFound found = GrowSheet(Straightened(frames, sought, widths * sought.width), root);
    const bool has_more = found.sheet.size() > best.sheet.size();
    const bool is_nearer = found.sheet.size() == best.sheet.size() && found.error() < best.error();
    if (!has_more && !is_nearer) return;
    best = std::move(found);
    best_widths = widths;
  };
  for (const double widths : {100.0, 1.4, 1.0, 0.75, 0.6, 0.5, 0.42, 0.36, 0.31, 0.27, 0.23}) {
    consider(widths);
  }
  const double coarse = best_widths;
  for (const double factor : {0.92, 0.96, 1.04, 1.08}) consider(factor * coarse);
  if (best.sheet.size() < 2) return Error{"no two tags are seen together often enough"};
  if (best.odd) {
    return Error{"tags " + std::to_string(root) + " and " + std::to_string(best.odd->first) +
                 " are not of one size on one plane"};
  }
  return AsMap(best.sheet, sought);
}

std::vector<FrameMeasurements> OfMap(const std::vector<FrameMeasurements>& frames,
                                     const TagMap& map) {
  std::vector<FrameMeasurements> out;
  for (const FrameMeasurements& frame : frames) {
    FrameMeasurements kept = frame;
    const auto is_other = [&](const TagDetection& tag) { return map.Find(tag.id) == nullptr; };
    kept.tags.erase(std::remove_if(kept.tags.begin(), kept.tags.end(), is_other), kept.tags.end());
    if (kept.tags.size() >= 2) out.push_back(std::move(kept));
  }
  return out;
}

Result<TagMap> LayoutFromNothing(const std::vector<FrameMeasurements>& frames,
                                 const LayoutSought& sought) {
  auto map = SheetByHomographies(frames, sought);
  for (int round = 0; round < 2 && map; ++round) {
    std::optional<LensStart> best;
    for (const LensModel model : {LensModel::kRadialTangential, LensModel::kEquidistant}) {
      const auto start =
          FindLensStart(OfMap(frames, *map), *map, sought.width, sought.height, model);
      if (start && !(best && best->error_px <= start->error_px)) best = start;
    }
    if (!best) return Error{"no frame shows two tags of one plane"};
    MappingOptions options;
    options.tag_size_m = sought.tag_size_m;
    options.family = sought.family;
    options.least_frames = static_cast<int>(kFramesToPlace);
    auto mapped = MapTags(best->camera, frames, options);
    if (!mapped) return mapped.error();
    map = std::move(mapped->map);
  }
  return map;
}

}  // namespace tagtwist::internal

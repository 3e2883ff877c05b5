#include "estimator/calibration/lens/lens_start.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "estimator/calibration/set_up/set_up_fit.h"
#include "frontend/base/statistics/quantile.h"
#include "frontend/geometry/homography.h"
#include "frontend/geometry/pose_refine.h"
#include "frontend/types/tag_planes.h"

namespace tagtwist::internal {
namespace {

constexpr size_t kFrames = 20;   // that a lens is tried on
constexpr double kWorstPx = 50;  // of a corner: what is farther off counts as this

// A frame's tags on one plane.
struct PlaneView {
  int64_t t_ns = 0;
  Pose world_from_plane;
  std::vector<TagDetection> tags;
};

PlaneView OnMainPlane(const FrameMeasurements& frame, const TagPlanes& planes) {
  const size_t main = MainPlane(planes, frame.tags);
  PlaneView out;
  out.t_ns = frame.t_ns;
  out.world_from_plane = planes.world_from_plane[main];
  for (const TagDetection& tag : frame.tags) {
    if (planes.plane_of_tag.at(tag.id) == main) out.tags.push_back(tag);
  }
  return out;
}

// Those with the most tags, spread over the recording.
std::vector<PlaneView> ToTryOn(const std::vector<FrameMeasurements>& frames, const TagMap& map) {
  const TagPlanes planes = FindTagPlanes(map.tags());
  std::vector<PlaneView> out;
  const size_t n = std::min(kFrames, frames.size());
  for (size_t k = 0; k < n; ++k) {
    const auto first = frames.begin() + static_cast<std::ptrdiff_t>(k * frames.size() / n);
    const auto last = frames.begin() + static_cast<std::ptrdiff_t>((k + 1) * frames.size() / n);
    const auto best = std::max_element(
        first, last, [](const auto& a, const auto& b) { return a.tags.size() < b.tags.size(); });
    if (best->tags.empty()) continue;
    PlaneView view = OnMainPlane(*best, planes);
    if (view.tags.size() >= 2) out.push_back(std::move(view));
  }
  return out;
}

std::vector<Eigen::Matrix3d> Homographies(const std::vector<PlaneView>& views, const TagMap& map) {
  std::vector<Eigen::Matrix3d> out;
  for (const PlaneView& view : views) {
    const Pose plane_from_world = Inverse(view.world_from_plane);
    std::vector<Eigen::Vector2d> in_plane, in_image;
    for (const TagDetection& tag : view.tags) {
      const auto& corners = map.CornersInWorld(tag.id);
      for (size_t c = 0; c < 4; ++c) {
        in_plane.emplace_back((plane_from_world * corners[c]).head<2>());
        in_image.push_back(tag.corners[c]);
      }
    }
    if (const auto h = FitHomography(in_plane, in_image, true)) out.push_back(*h);
  }
  return out;
}

// The pose by the homography, then by the whole lens.
std::optional<Pose> PoseUnder(const Camera& camera, const PlaneView& view, const TagMap& map) {
  const auto start = PoseFromTags(view.tags, map, view.world_from_plane, camera, {});
  if (!start) return std::nullopt;
  std::vector<PointInImage> points;
  for (const TagDetection& tag : view.tags) {
    const auto& corners = map.CornersInWorld(tag.id);
    for (size_t c = 0; c < 4; ++c) {
      if (camera.Unproject(tag.corners[c])) points.push_back({corners[c], tag.corners[c]});
    }
  }
  return RefinePose(Inverse(*start), points, camera).cam_from_world;
}

// Mean square of a view's corners under the camera.
double ErrorOf(const Camera& camera, const PlaneView& view, const TagMap& map) {
  const auto pose = PoseUnder(camera, view, map);
  if (!pose) return kWorstPx * kWorstPx;
  double sum = 0;
  for (const TagDetection& tag : view.tags) {
    const auto& corners = map.CornersInWorld(tag.id);
    for (size_t c = 0; c < 4; ++c) {
      Eigen::Vector2d pixel;
      const bool seen = camera.Project(*pose * corners[c], &pixel);
      const double error = seen ? (pixel - tag.corners[c]).norm() : kWorstPx;
      sum += std::pow(std::min(error, kWorstPx), 2);
    }
  }
  return sum / static_cast<double>(4 * view.tags.size());
}

double ErrorOf(const Camera& camera, const std::vector<PlaneView>& views, const TagMap& map) {
  if (camera.Problem()) return std::numeric_limits<double>::infinity();
  std::vector<double> errors;
  for (const PlaneView& view : views) errors.push_back(ErrorOf(camera, view, map));
  return Quantile(errors, 0.5);
}

std::vector<Camera> Candidates(const std::vector<PlaneView>& views, const TagMap& map, int width,
                               int height, LensModel lens) {
  constexpr int kFocalSteps = 14;
  Camera camera;
  camera.width = width, camera.height = height;
  camera.cx = 0.5 * (width - 1), camera.cy = 0.5 * (height - 1);
  camera.lens = lens;
  const Eigen::Vector2d centre(camera.cx, camera.cy);
  std::vector<double> focal_px;
  for (int step = 0; step <= kFocalSteps; ++step) {
    focal_px.push_back(width * 0.2 * std::pow(20.0, static_cast<double>(step) / kFocalSteps));
  }
  if (const auto zhang = FocalLengthByHomographies(Homographies(views, map), centre)) {
    focal_px.push_back(*zhang);
  }
  std::vector<Camera> out;
  for (const double focal : focal_px) {
    camera.fx = camera.fy = focal;
    camera.k1 = 0;
    out.push_back(camera);
    if (lens != LensModel::kRadialTangential) continue;
    camera.k1 = -0.2;
    out.push_back(camera);
  }
  return out;
}

// Focal length, centre, k1 and k2 by least squares over all views, with their poses.
Camera Polished(const Camera& camera, const std::vector<PlaneView>& views, const TagMap& map) {
  constexpr double kHuberPx = 1;
  std::vector<PosedFrame> frames;
  for (const PlaneView& view : views) {
    const auto pose = PoseUnder(camera, view, map);
    if (!pose) continue;
    PosedFrame frame;
    frame.seen = {view.t_ns, view.tags};
    frame.cam_from_world = *pose;
    frames.push_back(std::move(frame));
  }
  if (frames.empty()) return camera;
  FreeChanges free{};
  for (const size_t entry : {0, 2, 3, 4, 5}) free[entry] = true;  // focal, centre, k1 and k2
  return Changed(camera, FitSetUp(frames, camera, map, free, {}, kHuberPx).change);
}

}  // namespace

std::optional<double> FocalLengthByHomographies(
    const std::vector<Eigen::Matrix3d>& pixel_from_plane, const Eigen::Vector2d& principal_point) {
  constexpr double kLeast = 1e-3;  // of the sum of squares, of a plane that is tilted at all
  double ab = 0, aa = 0, n = 0;
  for (const Eigen::Matrix3d& h : pixel_from_plane) {
    Eigen::Matrix3d centred = h;
    centred.topRows<2>() -= principal_point * h.row(2);
    const double unit = std::sqrt(centred.topLeftCorner<2, 2>().squaredNorm() / 2);
    if (!(unit > 0)) continue;
    centred /= unit;
    const Eigen::Vector3d p = centred.col(0), q = centred.col(1);
    // x / f^2 + y = 0 for each of the two constraints.
    const double x[] = {p.head<2>().dot(q.head<2>()),
                        p.head<2>().squaredNorm() - q.head<2>().squaredNorm()};
    const double y[] = {p.z() * q.z(), p.z() * p.z() - q.z() * q.z()};
    for (int i = 0; i < 2; ++i) ab += x[i] * y[i], aa += x[i] * x[i];
    n += 1;
  }
  if (!(aa > kLeast * n) || !(-ab > 0)) return std::nullopt;
  return std::sqrt(aa / -ab);
}

std::optional<LensStart> FindLensStart(const std::vector<FrameMeasurements>& frames,
                                       const TagMap& map, int width, int height, LensModel lens) {
  const std::vector<PlaneView> views = ToTryOn(frames, map);
  if (views.empty()) return std::nullopt;
  LensStart out;
  double least = std::numeric_limits<double>::infinity();
  const auto consider = [&](const Camera& camera) {
    const double error = ErrorOf(camera, views, map);
    if (!(error < least)) return;
    least = error;
    out.camera = camera;
  };
  for (const Camera& camera : Candidates(views, map, width, height, lens)) consider(camera);
  if (!std::isfinite(least)) return std::nullopt;
  consider(Polished(out.camera, views, map));
  out.error_px = std::sqrt(least);
  return out;
}

}  // namespace tagtwist::internal

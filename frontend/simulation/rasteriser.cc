#include "frontend/simulation/rasteriser.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "frontend/types/lens/lens.h"

namespace tagtwist::internal {
namespace {

// What is nearer by less than this share of its depth counts as lying in the same plane.
constexpr float kSamePlane = 1e-4F;

// The ray [x y 1] of a sample meets the plane of a patch where
//   [u v 1]' / depth = plane_from_ray [x y 1]' =: [a b w]',  u = a / w, v = b / w, depth = 1 / w.
struct PatchPlane {
  Eigen::Matrix3f plane_from_ray;
  Eigen::Vector3f step_x, step_y;  // of [a b w] from one sample to the next
  bool front = true;               // the camera sees the side that u x v points to
};

std::optional<PatchPlane> MakePlane(const SampleGrid& grid, const Pose& cam_from_world,
                                    const Patch& patch) {
  Eigen::Matrix3d ray_from_plane;
  ray_from_plane << cam_from_world.rotation() * patch.half_u,
      cam_from_world.rotation() * patch.half_v, cam_from_world * patch.centre;
  const double scale = patch.half_u.norm() * patch.half_v.norm();
  const double determinant = ray_from_plane.determinant();
  if (!(std::abs(determinant) > 1e-6 * scale)) return std::nullopt;  // seen from its edge
  PatchPlane out;
  const Eigen::Matrix3d inverse = ray_from_plane.inverse();
  out.plane_from_ray = inverse.cast<float>();
  const double focal = FocalLengthOnAxis(grid.camera), aspect = grid.camera.fy / grid.camera.fx;
  out.step_x = (inverse.col(0) / (focal * grid.per_pixel)).cast<float>();
  out.step_y = (inverse.col(1) / (aspect * focal * grid.per_pixel)).cast<float>();
  out.front = determinant < 0;
  return out;
}

struct SampleBox {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;  // half-open
};

std::array<Eigen::Vector3d, 4> CornersInCam(const Pose& cam_from_world, const Patch& patch) {
  return {cam_from_world * (patch.centre - patch.half_u - patch.half_v),
          cam_from_world * (patch.centre + patch.half_u - patch.half_v),
          cam_from_world * (patch.centre + patch.half_u + patch.half_v),
          cam_from_world * (patch.centre - patch.half_u + patch.half_v)};
}

// True when all corners lie outside one side of the grid's view, or behind the camera.
bool IsOutOfView(const SampleGrid& grid, const std::array<Eigen::Vector3d, 4>& corners) {
  const auto all = [&](const auto& outside) {
    return std::all_of(corners.begin(), corners.end(), outside);
  };
  using CamPoint = Eigen::Vector3d;
  return all([&](const CamPoint& p) { return p.x() < grid.x_min * p.z(); }) ||
         all([&](const CamPoint& p) { return p.x() > grid.x_max * p.z(); }) ||
         all([&](const CamPoint& p) { return p.y() < grid.y_min * p.z(); }) ||
         all([&](const CamPoint& p) { return p.y() > grid.y_max * p.z(); }) ||
         all([&](const CamPoint& p) { return p.z() <= 0; });
}

// Samples that may see a quad: the bounds of its outline as projected, or the whole grid where the
// outline cannot be followed (behind the camera, or far off where the lens model may fold).
SampleBox FindBox(const SampleGrid& grid, const std::array<Eigen::Vector3d, 4>& corners) {
  const SampleBox whole{0, 0, grid.width, grid.height};
  constexpr int kPointsPerEdge = 8;
  const int points = grid.camera.IsDistorted() ? kPointsPerEdge : 1;
  const double widest = 1.5 * std::max({-grid.x_min, grid.x_max, -grid.y_min, grid.y_max});
  Eigen::AlignedBox2d box;
  for (size_t i = 0; i < 4; ++i) {
    for (int k = 0; k < points; ++k) {
      const double share = static_cast<double>(k) / points;
      const Eigen::Vector3d p = (1 - share) * corners[i] + share * corners[(i + 1) % 4];
      Eigen::Vector2d pixel;
      if (!grid.camera.Project(p, &pixel)) return whole;
      const bool far_off = std::abs(p.x()) > widest * p.z() || std::abs(p.y()) > widest * p.z();
      if (far_off && points > 1) return whole;
      box.extend(pixel);
    }
  }
  const double margin = 1 + (points > 1 ? 1 + 0.02 * box.sizes().norm() : 0);
  const auto to_sample = [&](double pixel, int most) {
    const double sample = (pixel + 0.5 + grid.padding_px) * grid.per_pixel;
    return static_cast<int>(std::clamp(sample, 0.0, static_cast<double>(most)));
  };
  return {to_sample(box.min().x() - margin, grid.width),
          to_sample(box.min().y() - margin, grid.height),
          to_sample(box.max().x() + margin, grid.width),
          to_sample(box.max().y() + margin, grid.height)};
}

// Share of the footprint [t - size/2, t + size/2] that lies in [-1, 1].
inline float CoverInterval(float t, float size) {
  if (std::abs(t) + 0.5F * size <= 1) return 1;
  const float inverse = 1 / size;
  const float up_to_right = std::clamp((1 - t) * inverse + 0.5F, 0.0F, 1.0F);
  const float up_to_left = std::clamp((-1 - t) * inverse + 0.5F, 0.0F, 1.0F);
  return up_to_right - up_to_left;
}

inline float CoverEllipse(float u, float v, float size_u, float size_v) {
  const float radius = std::sqrt(u * u + v * v);
  if (radius < 1e-3F) return 1;
  return std::clamp((1 - radius) * radius / (size_u * std::abs(u) + size_v * std::abs(v)) + 0.5F,
                    0.0F, 1.0F);
}

// The two cells that a footprint of `size` < 1 cells around t touches, and the share of the second.
struct CellPair {
  int first, second;
  float share;
};
inline CellPair FindCells(float t, float size, int cells) {
  const auto floor = [](float value) { return static_cast<int>(value + 4) - 4; };  // value > -4
  const float end = t + 0.5F * size;
  const int first = floor(t - 0.5F * size), second = floor(end);
  const float share = second > first ? (end - static_cast<float>(second)) / size : 0;
  return {std::clamp(first, 0, cells - 1), std::clamp(second, 0, cells - 1), share};
}

// Share of white in the footprint around (u, v), each in [-1, 1].
inline float WhiteShare(const TagPattern& pattern, float u, float v, float size_u, float size_v) {
  const float half = 0.5F * static_cast<float>(pattern.cells);
  const CellPair column = FindCells((u + 1) * half, std::min(size_u * half, 1.0F), pattern.cells);
  const CellPair row = FindCells((1 - v) * half, std::min(size_v * half, 1.0F), pattern.cells);
  const auto at = [&](int c, int r) { return static_cast<float>(pattern.IsWhite(c, r)); };
  const auto along_row = [&](int r) {
    return (1 - column.share) * at(column.first, r) + column.share * at(column.second, r);
  };
  return (1 - row.share) * along_row(row.first) + row.share * along_row(row.second);
}

// Where and how large, in the patch's own coordinates, a sample's footprint is.
struct Footprint {
  float u, v, size_u, size_v;
};
inline Footprint MakeFootprint(const PatchPlane& plane, const Eigen::Vector3f& abw) {
  const float inverse_w = 1 / abw.z();
  const float u = abw.x() * inverse_w, v = abw.y() * inverse_w;
  const Eigen::Vector3f &dx = plane.step_x, &dy = plane.step_y;
  return {u, v, (std::abs(dx.x() - u * dx.z()) + std::abs(dy.x() - u * dy.z())) * inverse_w,
          (std::abs(dx.y() - v * dx.z()) + std::abs(dy.y() - v * dy.z())) * inverse_w};
}

// Grey of a patch at a sample and how much of the sample it covers.
class PatchShader {
 public:
  PatchShader(const Patch& patch, bool front, const PaintGreys& greys)
      : patch_(patch),
        pattern_(front ? patch.pattern : nullptr),
        plain_(patch.pattern != nullptr ? greys.white : static_cast<float>(patch.grey)),
        black_(greys.black),
        contrast_(greys.white - greys.black) {}

  float Cover(const Footprint& f) const {
    if (patch_.shape == Patch::Shape::kEllipse) return CoverEllipse(f.u, f.v, f.size_u, f.size_v);
    return CoverInterval(f.u, f.size_u) * CoverInterval(f.v, f.size_v);
  }
  float Grey(const Footprint& f) const {
    if (pattern_ == nullptr) return plain_;
    return black_ + contrast_ * WhiteShare(*pattern_, f.u, f.v, f.size_u, f.size_v);
  }

 private:
  const Patch& patch_;
  const TagPattern* pattern_;  // the back of a tag is plain paper
  float plain_, black_, contrast_;
};

}  // namespace

SampleGrid::SampleGrid(const Camera& the_camera, int samples_per_pixel, int padding)
    : per_pixel(samples_per_pixel),
      padding_px(padding),
      width((the_camera.width + 2 * padding) * samples_per_pixel),
      height((the_camera.height + 2 * padding) * samples_per_pixel),
      camera(the_camera) {
  const size_t count = static_cast<size_t>(width) * static_cast<size_t>(height);
  x.reserve(count);
  y.reserve(count);
  x_min = y_min = std::numeric_limits<float>::max();
  x_max = y_max = std::numeric_limits<float>::lowest();
  const auto to_pixel = [this](int i) { return (i + 0.5) / per_pixel - 0.5 - padding_px; };
  for (int row = 0; row < height; ++row) {
    for (int column = 0; column < width; ++column) {
      const auto ray = camera.Unproject({to_pixel(column), to_pixel(row)});
      const float nan = std::numeric_limits<float>::quiet_NaN();
      x.push_back(ray ? static_cast<float>(ray->x()) : nan);
      y.push_back(ray ? static_cast<float>(ray->y()) : nan);
      if (!ray) continue;
      x_min = std::min(x_min, x.back());
      x_max = std::max(x_max, x.back());
      y_min = std::min(y_min, y.back());
      y_max = std::max(y_max, y.back());
    }
  }
}

void SampleImage::Reset(const SampleGrid& grid, double background_grey) {
  grey.assign(grid.x.size(), static_cast<float>(background_grey));
  inverse_depth.assign(grid.x.size(), 0.0F);
}

void PaintFloor(const SampleGrid& grid, const Pose& cam_from_world, double grey,
                SampleImage* image) {
  // On the plane normal . p = distance (camera frame), 1 / depth = normal . [x y 1] / distance.
  const Eigen::Vector3d normal = cam_from_world.rotation() * Eigen::Vector3d::UnitZ();
  const double distance = normal.dot(cam_from_world.translation());
  if (!(std::abs(distance) > 1e-6)) return;
  const Eigen::Vector3f row = (normal / distance).cast<float>();
  const auto floor_grey = static_cast<float>(grey);
  for (size_t i = 0; i < grid.x.size(); ++i) {
    const float w = row.x() * grid.x[i] + row.y() * grid.y[i] + row.z();
    const bool hit = w > 0;  // false for NaN
    image->inverse_depth[i] = hit ? w : 0.0F;
    image->grey[i] = hit ? floor_grey : image->grey[i];
  }
}

void PaintPatch(const SampleGrid& grid, const Pose& cam_from_world, const Patch& patch,
                const PaintGreys& greys, SampleImage* image) {
  const auto corners = CornersInCam(cam_from_world, patch);
  if (IsOutOfView(grid, corners)) return;
  const auto plane = MakePlane(grid, cam_from_world, patch);
  if (!plane) return;
  const SampleBox box = FindBox(grid, corners);
  const PatchShader shader(patch, plane->front, greys);
  const Eigen::Matrix3f& m = plane->plane_from_ray;
  const Eigen::Vector3f reach = plane->step_x.cwiseAbs() + plane->step_y.cwiseAbs();
  const float reach_u = reach.x() + reach.z(), reach_v = reach.y() + reach.z();
  for (int row = box.y0; row < box.y1; ++row) {
    const size_t start = static_cast<size_t>(row) * static_cast<size_t>(grid.width);
    for (size_t i = start + box.x0; i < start + box.x1; ++i) {
      const float x = grid.x[i], y = grid.y[i];
      const Eigen::Vector3f abw(m(0, 0) * x + m(0, 1) * y + m(0, 2),
                                m(1, 0) * x + m(1, 1) * y + m(1, 2),
                                m(2, 0) * x + m(2, 1) * y + m(2, 2));
      if (!(std::abs(abw.x()) < abw.z() + reach_u) || !(std::abs(abw.y()) < abw.z() + reach_v) ||
          !(abw.z() > (1 - kSamePlane) * image->inverse_depth[i]) || !(abw.z() > 0)) {
        continue;
      }
      const Footprint footprint = MakeFootprint(*plane, abw);
      const float cover = shader.Cover(footprint);
      if (cover <= 0) continue;
      image->grey[i] += cover * (shader.Grey(footprint) - image->grey[i]);
      if (cover >= 0.5F) image->inverse_depth[i] = abw.z();
    }
  }
}

}  // namespace tagtwist::internal

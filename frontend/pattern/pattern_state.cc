#include "frontend/pattern/pattern_state.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "frontend/pattern/pattern_view.h"

namespace tagtwist::internal {
namespace {

constexpr double kLeastBlurPx2 = 1.0 / 12;  // a pixel's own square
constexpr double kMostBlurPx2 = 9;

// The square's corners p1..p4 in tag coordinates.
constexpr std::array<std::array<double, 2>, 4> kSquare = {{{-1, 1}, {1, 1}, {1, -1}, {-1, -1}}};

}  // namespace

std::optional<Eigen::Matrix3d> TagFromPixel(const std::array<Eigen::Vector2d, 4>& corners) {
  // The square (0..1)^2 to a quad (Heckbert 1989), corners in the order (0,0) (1,0) (1,1) (0,1).
  const Eigen::Vector2d &p0 = corners[3], &p1 = corners[2], &p2 = corners[1], &p3 = corners[0];
  const auto cross = [](const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
    return a.x() * b.y() - a.y() * b.x();
  };
  for (size_t i = 0; i < 4; ++i) {
    const Eigen::Vector2d &a = corners[i], &b = corners[(i + 1) % 4], &c = corners[(i + 2) % 4];
    if (!(cross(b - a, c - b) < -1e-3)) return std::nullopt;  // not convex, or mirrored
  }
  const Eigen::Vector2d a = p1 - p2, b = p3 - p2, sum = p0 - p1 + p2 - p3;
  const double g = cross(sum, b) / cross(a, b), h = cross(a, sum) / cross(a, b);
  Eigen::Matrix3d pixel_from_unit, unit_from_tag;
  pixel_from_unit << p1 - p0 + g * p1, p3 - p0 + h * p3, p0, g, h, 1;
  unit_from_tag << 0.5, 0, 0.5, 0, 0.5, 0.5, 0, 0, 1;
  const Eigen::Matrix3d pixel_from_tag = pixel_from_unit * unit_from_tag;
  Eigen::Matrix3d out = pixel_from_tag.inverse();
  out *= pixel_from_tag(2, 2);  // positive third row inside of the tag
  if (!out.allFinite()) return std::nullopt;
  return out;
}

std::array<Eigen::Vector2d, 4> PatternCorners(const PatternState& state,
                                              Eigen::Matrix<double, 8, 8>* d_corners) {
  const Eigen::Matrix3d pixel_from_tag = state.tag_from_pixel.inverse();
  std::array<Eigen::Vector2d, 4> out;
  for (size_t i = 0; i < 4; ++i) {
    const double u = kSquare[i][0], v = kSquare[i][1];
    const Eigen::Vector3d q = pixel_from_tag * Eigen::Vector3d(u, v, 1);
    out[i] = q.hnormalized();
    if (d_corners == nullptr) continue;
    const Eigen::Matrix2d d_pixel_d_tag =
        (pixel_from_tag.topLeftCorner<2, 2>() - out[i] * pixel_from_tag.block<1, 2>(2, 0)) / q.z();
    Eigen::Matrix<double, 2, 8> d_tag;
    d_tag << u, v, 1, 0, 0, 0, -u * u, -u * v, 0, 0, 0, u, v, 1, -u * v, -v * v;
    // The tag coordinates of a pixel grow by d_tag, so the pixel of fixed coordinates goes back.
    d_corners->middleRows<2>(2 * static_cast<int>(i)) = -d_pixel_d_tag * d_tag;
  }
  return out;
}

double PredictGrey(const PatternModel& model, const PatternState& state, const NormalTable& normal,
                   const Eigen::Vector2d& pixel, PatternRow* row) {
  const double h = model.square_half();
  const auto view = ViewPattern(state.tag_from_pixel, h, state.blur_px2, pixel.x(), pixel.y());
  const PatternSample<double> sample =
      model.At(h * view.u, h * view.v, {view.uu, view.uv, view.vv}, normal);
  const Eigen::Vector2d place = (pixel - state.origin) / state.radius_px;
  const PatternLight<double> light{place.x(), place.y(),
                                   1 + state.light[0] * place.x() + state.light[1] * place.y() +
                                       state.light[2] * place.squaredNorm()};
  if (row != nullptr) {
    PatternDerivatives(view, sample, light, h, state.black, state.gain,
                       [&](size_t k) -> double& { return (*row)[k]; });
  }
  return light.illumination * (state.black + state.gain * sample.value);
}

PatternState Move(const PatternState& state, const PatternVector& step) {
  PatternState out = state;
  Eigen::Matrix3d change;
  change << 1 + step[0], step[1], step[2], step[3], 1 + step[4], step[5], step[6], step[7], 1;
  out.tag_from_pixel = change * state.tag_from_pixel;
  out.blur_px2 += step.segment<3>(8);
  double &xx = out.blur_px2[0], &xy = out.blur_px2[1], &yy = out.blur_px2[2];
  xx = std::clamp(xx, kLeastBlurPx2, kMostBlurPx2);
  yy = std::clamp(yy, kLeastBlurPx2, kMostBlurPx2);
  const double most = std::sqrt((xx - 0.9 * kLeastBlurPx2) * (yy - 0.9 * kLeastBlurPx2));
  xy = std::clamp(xy, -most, most);
  out.black += step[11];
  out.gain += step[12];
  out.light += step.segment<3>(13);
  return out;
}

}  // namespace tagtwist::internal

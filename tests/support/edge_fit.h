#pragma once
#include <Eigen/Core>
#include <array>
#include <cmath>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "frontend/types/camera.h"
#include "frontend/types/tag_map.h"

namespace tagtwist::internal {

/// Where the straight line between two points of W crosses a pixel row (axis 1) or column (axis 0),
/// by bisection: the other pixel coordinate. Nothing where it does not.
inline std::optional<double> CrossLine(const Camera& camera, const Pose& cam_from_world,
                                       const Eigen::Vector3d& a, const Eigen::Vector3d& b, int axis,
                                       double line) {
  const auto pixel_at = [&](double s) {
    Eigen::Vector2d pixel(NAN, NAN);
    camera.Project(cam_from_world * Eigen::Vector3d((1 - s) * a + s * b), &pixel);
    return pixel;
  };
  double low = 0.15, high = 0.85;  // away from the corners
  const bool rising = pixel_at(high)[axis] > pixel_at(low)[axis];
  if (!(std::min(pixel_at(low)[axis], pixel_at(high)[axis]) < line) ||
      !(std::max(pixel_at(low)[axis], pixel_at(high)[axis]) > line)) {
    return std::nullopt;
  }
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    ((pixel_at(middle)[axis] < line) == rising ? low : high) = middle;
  }
  return pixel_at(low)[1 - axis];
}

/// Mean of (rendered - projected) position across the side p[i] p[i+1] of a tag's black square
/// [px]: in every row (or column) that crosses it the edge lies where a step of the same total
/// intensity within +-reach pixels would.
inline double EdgeBias(const cv::Mat& image, const Camera& camera, const Pose& cam_from_world,
                       const std::array<Eigen::Vector3d, 4>& corners, size_t side, int reach = 4) {
  const Eigen::Vector3d &a = corners[side], &b = corners[(side + 1) % 4];
  Eigen::Vector2d pa, pb;
  camera.Project(cam_from_world * a, &pa);
  camera.Project(cam_from_world * b, &pb);
  const int axis = std::abs(pa.y() - pb.y()) > std::abs(pa.x() - pb.x()) ? 1 : 0;
  double sum = 0;
  int count = 0;
  for (int line = 0; line < (axis == 1 ? image.rows : image.cols); ++line) {
    const auto truth = CrossLine(camera, cam_from_world, a, b, axis, line);
    const int most = axis == 1 ? image.cols : image.rows;
    if (!truth || *truth < reach + 1 || *truth > most - reach - 2) continue;
    const int first = static_cast<int>(std::lround(*truth)) - reach;
    const auto grey = [&](int i) {
      return static_cast<double>(axis == 1 ? image.at<uint8_t>(line, i)
                                           : image.at<uint8_t>(i, line));
    };
    const double begin = grey(first), end = grey(first + 2 * reach);
    double share = 0;
    for (int i = 0; i <= 2 * reach; ++i) share += (grey(first + i) - end) / (begin - end);
    sum += first - 0.5 + share - *truth;
    ++count;
  }
  return count < 10 ? NAN : sum / count;
}

}  // namespace tagtwist::internal

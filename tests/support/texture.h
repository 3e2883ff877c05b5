#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <map>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <random>
#include <vector>

#include "frontend/types/measurements.h"

namespace tagtwist::internal {

// Smooth random texture, the same at any size.
inline cv::Mat Texture(int width, int height, unsigned seed = 7) {
  std::mt19937_64 engine(seed);
  cv::Mat noise(height, width, CV_8UC1);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) noise.at<uchar>(y, x) = static_cast<uchar>(engine() & 255U);
  }
  cv::Mat smooth;
  cv::GaussianBlur(noise, smooth, {0, 0}, 2.0);
  cv::normalize(smooth, smooth, 0, 255, cv::NORM_MINMAX);
  return smooth;
}

// The part of `world` that a camera sees under an affine motion: image(p) = world(A p + b).
inline cv::Mat See(const cv::Mat& world, const Eigen::Matrix2d& a, const Eigen::Vector2d& b) {
  const cv::Matx23d world_from_image(a(0, 0), a(0, 1), b.x(), a(1, 0), a(1, 1), b.y());
  cv::Mat image;
  cv::warpAffine(world, image, world_from_image, {376, 240},
                 cv::INTER_CUBIC | cv::WARP_INVERSE_MAP);
  return image;
}

inline cv::Mat Shifted(const cv::Mat& world, double x, double y) {
  return See(world, Eigen::Matrix2d::Identity(), {x, y});
}

inline std::map<int64_t, Eigen::Vector2d> ById(const std::vector<TrackObservation>& tracks) {
  std::map<int64_t, Eigen::Vector2d> out;
  for (const auto& track : tracks) out[track.track_id] = track.pixel;
  return out;
}

}  // namespace tagtwist::internal

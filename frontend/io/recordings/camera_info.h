#pragma once
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "frontend/base/limits.h"
#include "frontend/base/result.h"

namespace tagtwist::internal {

/// ROS' sensor_msgs/CameraInfo, of either version.
struct RosCameraInfo {
  uint32_t width = 0, height = 0;
  std::string distortion_model;
  std::vector<double> d;
  std::array<double, 9> k = {};
  uint32_t binning_x = 0, binning_y = 0;
  uint32_t roi_x = 0, roi_y = 0, roi_width = 0, roi_height = 0;
};

/// The message as a topic prints it.
std::string CameraInfoText(const RosCameraInfo& info);

/// A ROS bag of either version, told by its first bytes or by what is in the folder. A pipe is
/// none.
bool IsRosBag(const std::string& path);

/// CameraInfoText of the first message on `topic`, or on the only topic that has such (empty).
Result<std::string> ReadBagCameraInfo(const std::string& path, const std::string& topic,
                                      const Limits& limits);

/// Of a ROS 1 bag (an error in a build that reads none), and of a ROS 2 bag.
Result<RosCameraInfo> ReadRos1CameraInfo(const std::string& path, const std::string& topic,
                                         const Limits& limits);
Result<RosCameraInfo> ReadRos2CameraInfo(const std::string& path, const std::string& topic,
                                         const Limits& limits);

}  // namespace tagtwist::internal

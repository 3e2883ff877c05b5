#pragma once
#include <rosbag/message_instance.h>

#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>

#include "frontend/base/limits.h"
#include "frontend/base/result.h"
#include "frontend/io/recordings/bag_topics.h"
#include "frontend/io/recordings/camera_info.h"
#include "frontend/types/body_state.h"

namespace tagtwist::internal {

/// What of a type's messages is read, by the type's name.
bool IsRos1Image(const std::string& type);  // Image, CompressedImage
bool IsRos1Imu(const std::string& type);
bool IsRos1CameraInfo(const std::string& type);
/// PoseStamped, PoseWithCovarianceStamped, TransformStamped, Odometry.
bool IsRos1Pose(const std::string& type);
bool IsRos1Transforms(const std::string& type);  // TFMessage, tf's and tf2's

/// The header's stamp of an image [ns]; nullopt where the message is none.
std::optional<int64_t> Ros1ImageStamp(const rosbag::MessageInstance& message);
/// An image that does not decode comes out empty, with its `problem`. An error: the whole
/// recording cannot be worked with.
Result<cv::Mat> ReadRos1Image(const rosbag::MessageInstance& message, const Limits& limits,
                              std::string* problem);
std::optional<RosCameraInfo> ReadRos1CameraInfoMessage(const rosbag::MessageInstance& message);
/// nullopt where the message holds none, or numbers that are not finite. The stamp is the header's.
std::optional<ImuSample> ReadRos1Imu(const rosbag::MessageInstance& message);
/// Likewise; a twist, which Odometry tells in the body, comes out as v_world and omega_body.
std::optional<TruthSample> ReadRos1Pose(const rosbag::MessageInstance& message);
/// Those without a pose are left out. Throws what ROS throws at bytes that are too few.
std::vector<FrameTransform> ReadRos1Transforms(const rosbag::MessageInstance& message);

}  // namespace tagtwist::internal

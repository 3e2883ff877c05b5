#pragma once
#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <vector>

#include "frontend/base/limits.h"
#include "frontend/base/result.h"
#include "frontend/io/recordings/bag_topics.h"
#include "frontend/io/recordings/camera_info.h"
#include "frontend/types/body_state.h"
#include "frontend/types/measurements.h"

namespace tagtwist::internal {

/// Messages of ROS 2 out of CDR (through eProsima's Fast CDR). All refuse, with a reason without
/// any name, bytes that are too few for what they say they hold.
using Cdr = std::vector<uint8_t>;

/// The stamp of the header that such a message begins with [ns].
std::optional<int64_t> HeaderStamp(const Cdr& data);

bool IsRos2Image(const std::string& type);  // Image, CompressedImage
bool IsRos2Imu(const std::string& type);
bool IsRos2CameraInfo(const std::string& type);
/// PoseStamped, PoseWithCovarianceStamped, TransformStamped, Odometry.
bool IsRos2Pose(const std::string& type);
bool IsRos2Transforms(const std::string& type);  // TFMessage
/// AprilTagDetectionArray of apriltag_msgs or isaac_ros_apriltag_interfaces.
bool IsRos2Tags(const std::string& type);

Result<cv::Mat> ReadRos2Image(const std::string& type, const Cdr& data, const Limits& limits = {});
Result<RosCameraInfo> ReadRos2CameraInfoMessage(const Cdr& data);
/// The stamp is the header's.
Result<ImuSample> ReadRos2Imu(const Cdr& data);
/// Likewise; a twist, which Odometry tells in the body, comes out as v_world and omega_body.
Result<TruthSample> ReadRos2Pose(const std::string& type, const Cdr& data);
/// Of a TFMessage each child's name with its pose in its parent. Those without a pose are left out.
Result<std::vector<FrameTransform>> ReadRos2Transforms(const Cdr& data);
/// Corners p1..p4 (bottom left first), pixel centres at integers.
Result<std::vector<TagDetection>> ReadRos2Tags(const std::string& type, const Cdr& data);

}  // namespace tagtwist::internal

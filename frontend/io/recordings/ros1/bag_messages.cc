#include "frontend/io/recordings/ros1/bag_messages.h"

#include <geometry_msgs/PoseStamped.h>
#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <geometry_msgs/TransformStamped.h>
#include <nav_msgs/Odometry.h>
#include <ros/serialization.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/CompressedImage.h>
#include <sensor_msgs/Image.h>
#include <sensor_msgs/Imu.h>

#include <algorithm>
#include <string_view>
#include <type_traits>
#include <vector>

#include "frontend/io/images/image_file.h"
#include "frontend/io/images/raw_image.h"
#include "frontend/io/recordings/ros1/bag_check.h"
#include "frontend/io/trajectories/truth_parts.h"

namespace tagtwist::internal {
namespace {

template <typename... Messages>
bool IsOneOf(const std::string& type) {
  return ((type == ros::message_traits::DataType<Messages>::value()) || ...);
}

template <typename Message>
int64_t StampOf(const Message& message) {
  return static_cast<int64_t>(message.header.stamp.toNSec());
}

template <typename Vector>
Eigen::Vector3d ToVector(const Vector& v) {
  return {v.x, v.y, v.z};
}

template <typename Position, typename Rotation>
std::optional<TruthSample> ToTruth(int64_t t_ns, const Position& p, const Rotation& q) {
  const auto pose = PoseFromNumbers({p.x, p.y, p.z, q.x, q.y, q.z, q.w});
  if (!pose) return std::nullopt;
  return TruthSample{t_ns, *pose, {}};
}

std::vector<uint8_t> BytesOf(const rosbag::MessageInstance& instance) {
  std::vector<uint8_t> bytes(instance.size());
  ros::serialization::OStream written(bytes.data(), static_cast<uint32_t>(bytes.size()));
  instance.write(written);
  return bytes;
}

// None where the message is of another type, or announces more bytes than it has: a chunk may be
// compressed, and a connection be told twice, each time with another type.
template <typename Image>
boost::shared_ptr<Image> SoundImage(const rosbag::MessageInstance& instance) {
  constexpr bool kCompressed = std::is_same_v<Image, sensor_msgs::CompressedImage>;
  if (!instance.isType<Image>()) return nullptr;
  const std::vector<uint8_t> bytes = BytesOf(instance);
  const std::string_view message(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  return IsSoundImage(message, kCompressed) ? instance.instantiate<Image>() : nullptr;
}

}  // namespace

bool IsRos1Image(const std::string& type) {
  return IsOneOf<sensor_msgs::Image, sensor_msgs::CompressedImage>(type);
}
bool IsRos1Imu(const std::string& type) { return IsOneOf<sensor_msgs::Imu>(type); }
bool IsRos1CameraInfo(const std::string& type) { return IsOneOf<sensor_msgs::CameraInfo>(type); }
bool IsRos1Pose(const std::string& type) {
  return IsOneOf<geometry_msgs::PoseStamped, geometry_msgs::PoseWithCovarianceStamped,
                 geometry_msgs::TransformStamped, nav_msgs::Odometry>(type);
}
bool IsRos1Transforms(const std::string& type) {
  return type == "tf2_msgs/TFMessage" || type == "tf/tfMessage";
}

std::optional<int64_t> Ros1ImageStamp(const rosbag::MessageInstance& instance) {
  if (const auto raw = SoundImage<sensor_msgs::Image>(instance)) return StampOf(*raw);
  const auto file = SoundImage<sensor_msgs::CompressedImage>(instance);
  return file ? std::optional<int64_t>(StampOf(*file)) : std::nullopt;
}

std::optional<RosCameraInfo> ReadRos1CameraInfoMessage(const rosbag::MessageInstance& instance) {
  const auto message = instance.instantiate<sensor_msgs::CameraInfo>();
  if (!message) return std::nullopt;
  RosCameraInfo out;
  out.width = message->width;
  out.height = message->height;
  out.distortion_model = message->distortion_model;
  out.d = message->D;
  std::copy(message->K.begin(), message->K.end(), out.k.begin());
  out.binning_x = message->binning_x;
  out.binning_y = message->binning_y;
  out.roi_x = message->roi.x_offset;
  out.roi_y = message->roi.y_offset;
  out.roi_width = message->roi.width;
  out.roi_height = message->roi.height;
  return out;
}

std::optional<TruthSample> ReadRos1Pose(const rosbag::MessageInstance& instance) {
  if (const auto pose = instance.instantiate<geometry_msgs::PoseStamped>()) {
    return ToTruth(StampOf(*pose), pose->pose.position, pose->pose.orientation);
  }
  if (const auto transform = instance.instantiate<geometry_msgs::TransformStamped>()) {
    const auto& parts = transform->transform;
    return ToTruth(StampOf(*transform), parts.translation, parts.rotation);
  }
  if (const auto pose = instance.instantiate<geometry_msgs::PoseWithCovarianceStamped>()) {
    return ToTruth(StampOf(*pose), pose->pose.pose.position, pose->pose.pose.orientation);
  }
  const auto odometry = instance.instantiate<nav_msgs::Odometry>();
  if (!odometry) return std::nullopt;
  const auto& pose = odometry->pose.pose;
  auto out = ToTruth(StampOf(*odometry), pose.position, pose.orientation);
  if (!out) return out;
  // A twist is told in the frame of the child, the body.
  const auto& twist = odometry->twist.twist;
  const Eigen::Vector3d v_world = out->world_from_body.rotation() * ToVector(twist.linear);
  out->twist = Twist{v_world, ToVector(twist.angular)};
  return out;
}

std::optional<ImuSample> ReadRos1Imu(const rosbag::MessageInstance& instance) {
  const auto imu = instance.instantiate<sensor_msgs::Imu>();
  if (!imu) return std::nullopt;
  ImuSample out{StampOf(*imu), ToVector(imu->linear_acceleration), ToVector(imu->angular_velocity)};
  if (!out.accel_mps2.allFinite() || !out.gyro_radps.allFinite()) return std::nullopt;
  return out;
}

Result<cv::Mat> ReadRos1Image(const rosbag::MessageInstance& instance, const Limits& limits,
                              std::string* problem) {
  Result<cv::Mat> image = cv::Mat();
  if (const auto raw = SoundImage<sensor_msgs::Image>(instance)) {
    image = GrayFromRaw(
        {raw->encoding, raw->width, raw->height, raw->step, raw->is_bigendian != 0, &raw->data});
  } else if (const auto file = SoundImage<sensor_msgs::CompressedImage>(instance)) {
    image = DecodeGrayImage(std::string(file->data.begin(), file->data.end()), limits);
  }
  if (image) return image;
  if (image.error().message.rfind("encoding", 0) == 0) return image;
  *problem = image.error().message;
  return cv::Mat();
}

// Such a message is a list of TransformStamped and nothing else; ROS' own type of it would need a
// package that brings much besides.
std::vector<FrameTransform> ReadRos1Transforms(const rosbag::MessageInstance& instance) {
  std::vector<uint8_t> bytes = BytesOf(instance);
  ros::serialization::IStream stream(bytes.data(), static_cast<uint32_t>(bytes.size()));
  std::vector<FrameTransform> out;
  uint32_t count = 0;
  for (ros::serialization::deserialize(stream, count); count > 0; --count) {
    geometry_msgs::TransformStamped transform;
    ros::serialization::deserialize(stream, transform);
    const auto& parts = transform.transform;
    const auto pose = ToTruth(StampOf(transform), parts.translation, parts.rotation);
    if (pose) out.push_back({transform.child_frame_id, *pose});
  }
  return out;
}

}  // namespace tagtwist::internal

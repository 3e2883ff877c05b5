// Readers of images, and of the messages of ROS 2 that hold images, samples and poses.
#include "frontend/io/images/image_file.h"
#include "frontend/io/images/image_header.h"
#include "frontend/io/images/raw_image.h"
#include "frontend/io/recordings/ros2/ros2_messages.h"
#include "tests/fuzz/fuzz_bytes.h"
#include "tests/fuzz/fuzz_target.h"

namespace tagtwist::internal {
namespace {

bool PromiseGray(const Result<cv::Mat>& image) {
  if (!IsTaken(image)) return false;
  Promise(image->type() == CV_8UC1 && !image->empty(), "an image that is not 8-bit gray");
  return true;
}

}  // namespace

bool FuzzImage(const std::string& bytes) {
  Limits limits;
  limits.frame_pixels = 4'000'000;
  const auto image = DecodeGrayImage(bytes, limits);
  if (!PromiseGray(image)) return false;
  Promise(int64_t(image->total()) <= limits.frame_pixels, "more pixels than the bound");
  return true;
}

bool FuzzRawImage(const std::string& bytes) {
  // The last four are none that the reader knows.
  static const std::vector<std::string> encodings = {
      "mono8",       "mono16",       "bgr8",   "rgb8",        "bgra8",       "rgba8",
      "8UC1",        "16UC1",        "8UC3",   "bayer_rggb8", "bayer_bggr8", "bayer_gbrg8",
      "bayer_grbg8", "bayer_rggb16", "yuv422", "bgr16",       "32FC1",       ""};
  FuzzBytes in(bytes);
  RawImage raw;
  raw.encoding = encodings[in.Below(encodings.size())];
  raw.width = in.Take<uint32_t>() >> (in.Below(4) * 8);
  raw.height = in.Take<uint32_t>() >> (in.Below(4) * 8);
  raw.step = in.Take<uint32_t>() >> (in.Below(4) * 8);
  raw.is_bigendian = in.Below(2) == 1;
  const std::string rest = in.Rest();
  const std::vector<uint8_t> data(rest.begin(), rest.end());
  raw.data = &data;
  return PromiseGray(GrayFromRaw(raw));
}

bool FuzzMessage(const std::string& bytes) {
  static const std::vector<std::string> poses = {
      "geometry_msgs/msg/PoseStamped", "geometry_msgs/msg/PoseWithCovarianceStamped",
      "geometry_msgs/msg/TransformStamped", "nav_msgs/msg/Odometry"};
  if (bytes.empty()) return false;
  const Cdr data(bytes.begin() + 1, bytes.end());
  HeaderStamp(data);
  switch (static_cast<unsigned char>(bytes[0]) % 9) {
    case 0:
      return PromiseGray(ReadRos2Image("sensor_msgs/msg/Image", data));
    case 1:
      return PromiseGray(ReadRos2Image("sensor_msgs/msg/CompressedImage", data));
    case 2:
      return IsTaken(ReadRos2Imu(data));
    case 3:
      return IsTaken(ReadRos2Tags("apriltag_msgs/msg/AprilTagDetectionArray", data)) ||
             IsTaken(
                 ReadRos2Tags("isaac_ros_apriltag_interfaces/msg/AprilTagDetectionArray", data));
    case 8:
      return IsTaken(ReadRos2Transforms(data));
    default:
      return IsTaken(ReadRos2Pose(poses[static_cast<unsigned char>(bytes[0]) % 4], data));
  }
}

}  // namespace tagtwist::internal

#include "frontend/io/recordings/ros2/ros2_messages.h"

#include <fastcdr/Cdr.h>
#include <fastcdr/FastBuffer.h>
#include <fastcdr/exceptions/Exception.h>

#include <utility>

#include "frontend/io/images/image_file.h"
#include "frontend/io/images/raw_image.h"
#include "frontend/io/trajectories/truth_parts.h"

namespace tagtwist::internal {
namespace {

constexpr const char* kIsaacTags = "isaac_ros_apriltag_interfaces/msg/AprilTagDetectionArray";

using eprosima::fastcdr::Cdr;
using eprosima::fastcdr::FastBuffer;

// Fast CDR over bytes that nobody vouches for: lengths are held against what is there before
// anything is made of them. Throws Fast CDR's exceptions.
class Reader {
 public:
  explicit Reader(const tagtwist::internal::Cdr& data)
      : size_(data.size()),
        buffer_(const_cast<char*>(reinterpret_cast<const char*>(data.data())), data.size()),
        cdr_(buffer_, Cdr::DEFAULT_ENDIAN, Cdr::DDS_CDR) {
    cdr_.read_encapsulation();
  }

  template <typename Number>
  Number Take() {
    Number out = 0;
    cdr_.deserialize(out);
    return out;
  }
  uint32_t TakeLength() {
    const auto length = Take<uint32_t>();
    if (length > size_ - cdr_.getSerializedDataLength()) {
      throw eprosima::fastcdr::exception::NotEnoughMemoryException("too long");
    }
    return length;
  }
  std::string TakeText() {
    const std::vector<uint8_t> bytes = TakeBytes();
    std::string out(bytes.begin(), bytes.end());
    if (!out.empty() && out.back() == '\0') out.pop_back();
    return out;
  }
  std::vector<uint8_t> TakeBytes() {
    std::vector<uint8_t> out(TakeLength());
    if (!out.empty()) cdr_.deserializeArray(out.data(), out.size());
    return out;
  }
  void Skip(size_t doubles) {
    for (size_t i = 0; i < doubles; ++i) Take<double>();
  }
  Eigen::Vector3d TakeVector() {
    const double x = Take<double>(), y = Take<double>(), z = Take<double>();
    return {x, y, z};
  }
  std::vector<double> TakePose() {
    std::vector<double> out;
    for (int i = 0; i < 7; ++i) out.push_back(Take<double>());
    return out;
  }
  int64_t TakeStamp() {
    const auto seconds = Take<int32_t>();
    const auto nanoseconds = Take<uint32_t>();
    return int64_t{seconds} * 1'000'000'000 + nanoseconds;
  }
  // With its frame's name.
  int64_t TakeHeader() {
    const int64_t stamp_ns = TakeStamp();
    TakeText();
    return stamp_ns;
  }

 private:
  size_t size_;
  FastBuffer buffer_;
  Cdr cdr_;
};

// What `read` makes of the message, or that it is damaged.
template <typename Value, typename Read>
Result<Value> ReadMessage(const tagtwist::internal::Cdr& data, const Read& read) {
  try {
    Reader reader(data);
    return read(&reader);
  } catch (const eprosima::fastcdr::exception::Exception&) {
    return Error{"cannot decode"};
  }
}

Result<cv::Mat> TakeImage(Reader* reader, bool compressed, const Limits& limits) {
  reader->TakeHeader();
  if (compressed) {
    reader->TakeText();
    const std::vector<uint8_t> bytes = reader->TakeBytes();
    return DecodeGrayImage(std::string(bytes.begin(), bytes.end()), limits);
  }
  RawImage raw;
  raw.height = reader->Take<uint32_t>();
  raw.width = reader->Take<uint32_t>();
  raw.encoding = reader->TakeText();
  raw.is_bigendian = reader->Take<uint8_t>() != 0;
  raw.step = reader->Take<uint32_t>();
  const std::vector<uint8_t> bytes = reader->TakeBytes();
  raw.data = &bytes;
  return GrayFromRaw(raw);
}

Result<TruthSample> TakePose(Reader* reader, const std::string& type) {
  const int64_t t_ns = reader->TakeHeader();
  const bool odometry = type == "nav_msgs/msg/Odometry";
  if (odometry || type == "geometry_msgs/msg/TransformStamped") reader->TakeText();  // the child
  const auto pose = PoseFromNumbers(reader->TakePose());
  if (!pose) return pose.error();
  TruthSample out{t_ns, *pose, {}};
  if (!odometry) return out;
  reader->Skip(36);
  const Eigen::Vector3d v_body = reader->TakeVector(), omega_body = reader->TakeVector();
  out.twist = Twist{pose->rotation() * v_body, omega_body};
  return out;
}

// apriltag's own corners: bottom left first, against the clock as printed, and pixel centres at
// halves, which the ROS node passes on.
TagDetection TakeApriltag(Reader* reader) {
  TagDetection tag;
  reader->TakeText();  // family
  tag.id = reader->Take<int32_t>();
  reader->Take<int32_t>();  // bits mended
  reader->Take<float>();
  reader->Take<float>();
  reader->Skip(2);  // centre
  for (Eigen::Vector2d& corner : tag.corners) {
    const double u = reader->Take<double>(), v = reader->Take<double>();
    corner = {u - 0.5, v - 0.5};
  }
  reader->Skip(9);  // homography
  return tag;
}

// isaac_ros: points of three numbers, pixel centres at integers, and a pose. Its node turns the
// order of VPI's corners, which is apriltag's, round: top left first, with the clock as printed.
TagDetection TakeIsaacTag(Reader* reader) {
  TagDetection tag;
  reader->TakeText();  // family
  tag.id = reader->Take<int32_t>();
  reader->Skip(3);  // centre
  for (size_t corner = 4; corner-- > 0;) tag.corners[corner] = reader->TakeVector().head<2>();
  reader->TakeHeader();
  reader->Skip(7 + 36);  // pose and covariance
  return tag;
}

}  // namespace

std::optional<int64_t> HeaderStamp(const tagtwist::internal::Cdr& data) {
  const auto stamp = ReadMessage<int64_t>(
      data, [](Reader* reader) -> Result<int64_t> { return reader->TakeStamp(); });
  return stamp ? std::optional(*stamp) : std::nullopt;
}

bool IsRos2Image(const std::string& type) {
  return type == "sensor_msgs/msg/Image" || type == "sensor_msgs/msg/CompressedImage";
}
bool IsRos2Imu(const std::string& type) { return type == "sensor_msgs/msg/Imu"; }
bool IsRos2CameraInfo(const std::string& type) { return type == "sensor_msgs/msg/CameraInfo"; }
bool IsRos2Pose(const std::string& type) {
  return type == "geometry_msgs/msg/PoseStamped" ||
         type == "geometry_msgs/msg/PoseWithCovarianceStamped" ||
         type == "geometry_msgs/msg/TransformStamped" || type == "nav_msgs/msg/Odometry";
}
bool IsRos2Transforms(const std::string& type) { return type == "tf2_msgs/msg/TFMessage"; }
bool IsRos2Tags(const std::string& type) {
  return type == "apriltag_msgs/msg/AprilTagDetectionArray" || type == kIsaacTags;
}

Result<cv::Mat> ReadRos2Image(const std::string& type, const tagtwist::internal::Cdr& data,
                              const Limits& limits) {
  const bool compressed = type == "sensor_msgs/msg/CompressedImage";
  return ReadMessage<cv::Mat>(
      data, [&](Reader* reader) { return TakeImage(reader, compressed, limits); });
}

Result<RosCameraInfo> ReadRos2CameraInfoMessage(const tagtwist::internal::Cdr& data) {
  return ReadMessage<RosCameraInfo>(data, [](Reader* reader) -> Result<RosCameraInfo> {
    RosCameraInfo out;
    reader->TakeHeader();
    out.height = reader->Take<uint32_t>();
    out.width = reader->Take<uint32_t>();
    out.distortion_model = reader->TakeText();
    const uint32_t count = reader->TakeLength();
    for (uint32_t i = 0; i < count; ++i) out.d.push_back(reader->Take<double>());
    for (double& value : out.k) value = reader->Take<double>();
    reader->Skip(9 + 12);  // of the rectified image
    for (uint32_t* value : {&out.binning_x, &out.binning_y, &out.roi_x, &out.roi_y, &out.roi_height,
                            &out.roi_width}) {
      *value = reader->Take<uint32_t>();
    }
    return out;
  });
}

Result<ImuSample> ReadRos2Imu(const tagtwist::internal::Cdr& data) {
  return ReadMessage<ImuSample>(data, [](Reader* reader) -> Result<ImuSample> {
    ImuSample out;
    out.t_ns = reader->TakeHeader();
    reader->Skip(4 + 9);  // attitude and its covariance
    out.gyro_radps = reader->TakeVector();
    reader->Skip(9);
    out.accel_mps2 = reader->TakeVector();
    if (!out.gyro_radps.allFinite() || !out.accel_mps2.allFinite())
      return Error{"no finite number"};
    return out;
  });
}

Result<TruthSample> ReadRos2Pose(const std::string& type, const tagtwist::internal::Cdr& data) {
  return ReadMessage<TruthSample>(data, [&](Reader* reader) { return TakePose(reader, type); });
}

Result<std::vector<FrameTransform>> ReadRos2Transforms(const tagtwist::internal::Cdr& data) {
  using Transforms = std::vector<FrameTransform>;
  return ReadMessage<Transforms>(data, [](Reader* reader) -> Result<Transforms> {
    Transforms out;
    const uint32_t count = reader->TakeLength();
    for (uint32_t i = 0; i < count; ++i) {
      const int64_t t_ns = reader->TakeHeader();
      const std::string child = reader->TakeText();
      const auto pose = PoseFromNumbers(reader->TakePose());
      if (pose) out.push_back({child, {t_ns, *pose, {}}});
    }
    return out;
  });
}

Result<std::vector<TagDetection>> ReadRos2Tags(const std::string& type,
                                               const tagtwist::internal::Cdr& data) {
  using Tags = std::vector<TagDetection>;
  const bool isaac = type == kIsaacTags;
  return ReadMessage<Tags>(data, [&](Reader* reader) -> Result<Tags> {
    reader->TakeHeader();
    Tags out;
    const uint32_t count = reader->TakeLength();
    for (uint32_t i = 0; i < count; ++i) {
      out.push_back(isaac ? TakeIsaacTag(reader) : TakeApriltag(reader));
    }
    return out;
  });
}

}  // namespace tagtwist::internal

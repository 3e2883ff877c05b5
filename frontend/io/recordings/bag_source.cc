// ROS 1 bags, through ROS' own library. Where it is not installed bag_source_missing.cc stands for
// this file.
#include <console_bridge/console.h>
#include <geometry_msgs/PoseStamped.h>
#include <geometry_msgs/TransformStamped.h>
#include <nav_msgs/Odometry.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <sensor_msgs/CompressedImage.h>
#include <sensor_msgs/Image.h>
#include <sensor_msgs/Imu.h>

#include <algorithm>
#include <map>
#include <utility>

#include "frontend/io/images/image_file.h"
#include "frontend/io/images/raw_image.h"
#include "frontend/io/recordings/bag_check.h"
#include "frontend/io/recordings/data_source_kinds.h"
#include "frontend/io/tables/stamps.h"
#include "frontend/io/trajectories/truth_parts.h"

namespace tagtwist {
namespace {

using Topics = std::vector<std::string>;

int64_t ToNs(const ros::Time& time) { return static_cast<int64_t>(time.toNSec()); }

template <typename Message>
int64_t StampOf(const Message& message) {
  return ToNs(message.header.stamp);
}

// Stamps of the messages on a topic: their headers', or, where never set, the arrivals'.
class Stamps {
 public:
  void Add(int64_t header_ns, const rosbag::MessageInstance& instance) {
    headers_ns_.push_back(header_ns);
    arrivals_ns_.push_back(ToNs(instance.getTime()));
  }
  const std::vector<int64_t>& Get() const {
    const bool set =
        std::any_of(headers_ns_.begin(), headers_ns_.end(), [](int64_t t_ns) { return t_ns != 0; });
    return set ? headers_ns_ : arrivals_ns_;
  }

 private:
  std::vector<int64_t> headers_ns_, arrivals_ns_;
};

template <typename... Messages>
Topics TopicsOf(const rosbag::Bag& bag) {
  Topics out;
  rosbag::View all(bag);
  for (const rosbag::ConnectionInfo* connection : all.getConnections()) {
    const bool fits =
        ((connection->datatype == ros::message_traits::DataType<Messages>::value()) || ...);
    if (fits) out.push_back(connection->topic);
  }
  std::sort(out.begin(), out.end());
  out.erase(std::unique(out.begin(), out.end()), out.end());
  return out;
}

std::string Listed(const Topics& topics) {
  std::string out;
  for (const std::string& topic : topics) out += (out.empty() ? "" : ", ") + topic;
  return out;
}

Result<std::string> ChooseTopic(const rosbag::Bag& bag, const std::string& wanted) {
  const Topics topics = TopicsOf<sensor_msgs::Image, sensor_msgs::CompressedImage>(bag);
  if (topics.empty()) return Error{"no images in the bag"};
  if (wanted.empty()) {
    if (topics.size() == 1) return topics.front();
    return Error{"several topics have images: expected --topic, one of " + Listed(topics)};
  }
  if (std::find(topics.begin(), topics.end(), wanted) != topics.end()) return wanted;
  return Error{"no images on the topic " + wanted + ": expected one of " + Listed(topics)};
}

// The samples of the only topic with such messages, without those whose stamps do not grow.
template <typename Sample, typename... Messages, typename Convert>
std::vector<Sample> ReadOnly(const rosbag::Bag& bag, const Convert& convert) {
  std::vector<Sample> out;
  const Topics topics = TopicsOf<Messages...>(bag);
  if (topics.size() != 1) return out;
  rosbag::View view(bag, rosbag::TopicQuery(topics));
  std::vector<Sample> all;
  Stamps stamps;
  for (const rosbag::MessageInstance& instance : view) {
    const std::optional<Sample> sample = convert(instance);
    if (!sample) continue;
    stamps.Add(sample->t_ns, instance);
    all.push_back(*sample);
  }
  for (size_t i = 0; i < all.size(); ++i) {
    all[i].t_ns = stamps.Get()[i];
    if (out.empty() || all[i].t_ns > out.back().t_ns) out.push_back(all[i]);
  }
  return out;
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

std::optional<TruthSample> ReadTruth(const rosbag::MessageInstance& instance) {
  if (const auto pose = instance.instantiate<geometry_msgs::PoseStamped>()) {
    return ToTruth(StampOf(*pose), pose->pose.position, pose->pose.orientation);
  }
  if (const auto transform = instance.instantiate<geometry_msgs::TransformStamped>()) {
    const auto& parts = transform->transform;
    return ToTruth(StampOf(*transform), parts.translation, parts.rotation);
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

std::optional<ImuSample> ReadImu(const rosbag::MessageInstance& instance) {
  const auto imu = instance.instantiate<sensor_msgs::Imu>();
  if (!imu) return std::nullopt;
  ImuSample out{StampOf(*imu), ToVector(imu->linear_acceleration), ToVector(imu->angular_velocity)};
  if (!out.accel_mps2.allFinite() || !out.gyro_radps.allFinite()) return std::nullopt;
  return out;
}

// Error: the whole recording cannot be worked with.
Result<cv::Mat> ReadImage(const rosbag::MessageInstance& instance, std::string* problem) {
  Result<cv::Mat> image = cv::Mat();
  if (const auto raw = instance.instantiate<sensor_msgs::Image>()) {
    image = GrayFromRaw(
        {raw->encoding, raw->width, raw->height, raw->step, raw->is_bigendian != 0, &raw->data});
  } else if (const auto file = instance.instantiate<sensor_msgs::CompressedImage>()) {
    image = DecodeGrayImage(std::string(file->data.begin(), file->data.end()));
  }
  if (image) return image;
  if (image.error().message.rfind("encoding", 0) == 0) return image;
  *problem = image.error().message;
  return cv::Mat();
}

std::string OneLine(std::string text) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text;
}

Error Damaged(const std::string& path, const std::exception& fault) {
  return Error{path +
               ": a damaged bag, or one whose recording was not ended: " + OneLine(fault.what())};
}

class BagSource : public DataSource {
 public:
  BagSource(std::string path, bool read_images)
      : path_(std::move(path)), read_images_(read_images) {}

  // May throw.
  Status Open(const std::string& topic) {
    bag_.open(path_, rosbag::bagmode::Read);
    const auto chosen = ChooseTopic(bag_, topic);
    if (!chosen) return Error{path_ + ": " + chosen.error().message};
    topic_ = *chosen;
    view_.addQuery(bag_, rosbag::TopicQuery(topic_));
    if (const auto read = ReadStamps(); !read) return read;
    imu_ = ReadOnly<ImuSample, sensor_msgs::Imu>(bag_, ReadImu);
    truth_ = ReadOnly<TruthSample, geometry_msgs::PoseStamped, geometry_msgs::TransformStamped,
                      nav_msgs::Odometry>(bag_, ReadTruth);
    at_ = view_.begin();
    return Ok();
  }

  Result<std::optional<Frame>> Next() override {
    if (next_ == stamps_ns_.size()) return std::optional<Frame>();
    Frame frame;
    frame.t_ns = stamps_ns_[next_];
    frame.name = NameOf(next_++);
    try {
      if (read_images_) {
        auto image = ReadImage(*at_, &frame.image_problem);
        if (!image) return Error{frame.name + ": " + image.error().message};
        frame.image = std::move(*image);
      }
      ++at_;
    } catch (const std::exception& fault) {
      return Damaged(path_, fault);
    }
    if (!frame.image.empty()) {
      if (auto fault = size_guard_.Check(frame.image, frame.name)) return *fault;
    }
    return std::optional<Frame>(std::move(frame));
  }

  const std::vector<int64_t>& stamps_ns() const override { return stamps_ns_; }
  const std::vector<TruthSample>& ground_truth() const override { return truth_; }
  const std::vector<ImuSample>& imu() const override { return imu_; }

 private:
  std::string NameOf(size_t index) const {
    return path_ + ": " + topic_ + ", message " + std::to_string(index);
  }
  Status ReadStamps() {
    Stamps stamps;
    size_t index = 0;
    for (const rosbag::MessageInstance& instance : view_) {
      const auto t_ns = ImageStamp(instance);
      if (!t_ns) return Error{NameOf(index) + ": cannot decode"};
      stamps.Add(*t_ns, instance);
      ++index;
    }
    stamps_ns_ = stamps.Get();
    for (size_t i = 1; i < stamps_ns_.size(); ++i) {
      const auto fault = StampFault(stamps_ns_[i - 1], stamps_ns_[i]);
      if (fault) return Error{NameOf(i) + ": " + *fault};
    }
    return Ok();
  }
  static std::optional<int64_t> ImageStamp(const rosbag::MessageInstance& instance) {
    if (const auto raw = instance.instantiate<sensor_msgs::Image>()) {
      return StampOf(*raw);
    }
    const auto file = instance.instantiate<sensor_msgs::CompressedImage>();
    return file ? std::optional<int64_t>(StampOf(*file)) : std::nullopt;
  }

  std::string path_, topic_;
  bool read_images_;
  rosbag::Bag bag_;
  rosbag::View view_;
  rosbag::View::iterator at_;
  std::vector<int64_t> stamps_ns_;
  std::vector<TruthSample> truth_;
  std::vector<ImuSample> imu_;
  size_t next_ = 0;
  ImageSizeGuard size_guard_;
};

}  // namespace

Result<std::unique_ptr<DataSource>> OpenBagSource(const std::string& path,
                                                  const DataSourceOptions& options) {
  if (options.use_detections) return Error{path + ": a bag has no detections to use"};
  if (const auto sound = CheckBagRecords(path); !sound) return sound.error();
  console_bridge::noOutputHandler();  // rosbag would print besides
  try {
    auto source = std::make_unique<BagSource>(path, options.read_images);
    if (const auto opened = source->Open(options.topic); !opened) return opened.error();
    return std::unique_ptr<DataSource>(std::move(source));
  } catch (const std::exception& fault) {
    return Damaged(path, fault);
  }
}

}  // namespace tagtwist

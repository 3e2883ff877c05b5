// Bags, written by ROS' own library from a recording in a folder, and read back.
#include <geometry_msgs/PoseStamped.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nav_msgs/Odometry.h>
#include <rosbag/bag.h>
#include <sensor_msgs/CompressedImage.h>
#include <sensor_msgs/Image.h>
#include <sensor_msgs/Imu.h>

#include <filesystem>
#include <memory>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "frontend/io/recordings/data_source.h"
#include "tests/support/formats/ros1_transforms.h"
#include "tests/support/formats/ros2_flight.h"
#include "tests/support/program_test_util.h"
#include "tests/support/test_files.h"

namespace tagtwist::internal::bag_source_test {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

ros::Time ToRos(int64_t t_ns) { return ros::Time().fromNSec(static_cast<uint64_t>(t_ns)); }

template <typename To>
void Set(const Eigen::Vector3d& from, To* to) {
  to->x = from.x(), to->y = from.y(), to->z = from.z();
}

template <typename To>
void Set(const Eigen::Quaterniond& from, To* to) {
  to->x = from.x(), to->y = from.y(), to->z = from.z(), to->w = from.w();
}

std::vector<Frame> AllFrames(DataSource* source) {
  std::vector<Frame> out;
  for (auto frame = source->Next(); frame && *frame; frame = source->Next()) {
    out.push_back(std::move(**frame));
  }
  return out;
}

// A recording of six frames in a folder, and what a bag is written of.
class Bag : public testing::Test {
 protected:
  Bag() {
    MakeRecording(folder_.path(), "rec", DatasetFormat::kFolder, true);
    original_ = std::move(*OpenDataSource(folder_ / "rec", {}));
    frames_ = AllFrames(original_.get());
  }

  sensor_msgs::Image Raw(const Frame& frame) const {
    sensor_msgs::Image out;
    out.header.stamp = ToRos(frame.t_ns);
    out.encoding = "bgr8";
    out.width = static_cast<uint32_t>(frame.image.cols);
    out.height = static_cast<uint32_t>(frame.image.rows);
    out.step = 3 * out.width;
    cv::Mat colour;
    cv::cvtColor(frame.image, colour, cv::COLOR_GRAY2BGR);
    out.data.assign(colour.data, colour.data + out.step * out.height);
    return out;
  }
  sensor_msgs::CompressedImage Png(const Frame& frame) const {
    sensor_msgs::CompressedImage out;
    out.header.stamp = ToRos(frame.t_ns);
    out.format = "png";
    cv::imencode(".png", frame.image, out.data);
    return out;
  }
  // Messages arrive 5 ms after their stamps.
  template <typename Message>
  void Write(const std::string& topic, const Message& message) {
    bag_.write(topic, message.header.stamp + ros::Duration(0.005), message);
  }
  void WriteImu() {
    for (const ImuSample& sample : original_->imu()) {
      sensor_msgs::Imu imu;
      imu.header.stamp = ToRos(sample.t_ns);
      Set(sample.accel_mps2, &imu.linear_acceleration);
      Set(sample.gyro_radps, &imu.angular_velocity);
      Write("/imu", imu);
    }
  }
  void WriteOdometry() {
    for (const TruthSample& sample : original_->ground_truth()) {
      nav_msgs::Odometry odometry;
      odometry.header.stamp = ToRos(sample.t_ns);
      const Pose& pose = sample.world_from_body;
      Set(Eigen::Vector3d(pose.translation()), &odometry.pose.pose.position);
      Set(Eigen::Quaterniond(pose.rotation()), &odometry.pose.pose.orientation);
      Set(Eigen::Vector3d(pose.rotation().conjugate() * sample.twist->v_world),
          &odometry.twist.twist.linear);
      Set(sample.twist->omega_body, &odometry.twist.twist.angular);
      Write("/vicon", odometry);
    }
  }
  void WriteBag(rosbag::CompressionType compression = rosbag::compression::Uncompressed) {
    bag_.open(folder_ / "x.bag", rosbag::bagmode::Write);
    bag_.setCompression(compression);
    for (const Frame& frame : frames_) Write("/cam0/image_raw", Raw(frame));
    WriteImu();
    WriteOdometry();
    bag_.close();
  }

  // The one line in which a bag is refused, on whatever way.
  std::string Refusal(const DataSourceOptions& options = {}) {
    auto source = OpenDataSource(folder_ / "x.bag", options);
    if (!source) return source.error().message;
    for (;;) {
      auto frame = (*source)->Next();
      if (!frame) return frame.error().message;
      if (!*frame) return "";
    }
  }

  TempFolder folder_;
  std::unique_ptr<DataSource> original_;
  std::vector<Frame> frames_;
  rosbag::Bag bag_;
};

TEST_F(Bag, TheSameMessagesOfRos2GiveTheSameBytes) {
  WriteBag();
  WriteText(folder_ / "x.mcap", Mcap("lz4", Ros2FlightOf(frames_, *original_)));
  for (const std::string bag : {"x.bag", "x.mcap"}) {
    const ProgramRun run = RunProgram(
        folder_.path(), "tagtwist_estimate",
        {"--dataset", bag, "--tracks=false", "--write_covariance", "--output", bag + ".out"});
    ASSERT_EQ(run.status, 0) << run.err;
  }
  for (const char* file : {"states.csv", "covariance.csv", "optimised.tum", "closed_form.tum",
                           "ground_truth.tum", "ground_truth_states.csv"}) {
    const std::string of_ros1 = ReadText(folder_ / (std::string("x.bag.out/") + file));
    EXPECT_GT(of_ros1.size(), 300u) << file;
    EXPECT_EQ(of_ros1, ReadText(folder_ / (std::string("x.mcap.out/") + file))) << file;
  }
}

TEST_F(Bag, HoldsWhatWasWritten) {
  for (const auto compression : {rosbag::compression::Uncompressed, rosbag::compression::LZ4}) {
    WriteBag(compression);
    auto source = OpenDataSource(folder_ / "x.bag", {});
    ASSERT_TRUE(source) << source.error().message;
    EXPECT_EQ((*source)->stamps_ns(), original_->stamps_ns());
    const std::vector<Frame> frames = AllFrames(source->get());
    ASSERT_EQ(frames.size(), frames_.size());
    for (size_t i = 0; i < frames.size(); ++i) {
      EXPECT_EQ(frames[i].t_ns, frames_[i].t_ns);
      EXPECT_EQ(cv::countNonZero(frames[i].image != frames_[i].image), 0);
    }
    ASSERT_EQ((*source)->imu().size(), original_->imu().size());
    EXPECT_EQ((*source)->imu().back().gyro_radps, original_->imu().back().gyro_radps);
    EXPECT_EQ((*source)->imu().back().accel_mps2, original_->imu().back().accel_mps2);
    ASSERT_EQ((*source)->ground_truth().size(), original_->ground_truth().size());
    const TruthSample &read = (*source)->ground_truth().back(),
                      &truth = original_->ground_truth().back();
    EXPECT_EQ(read.t_ns, truth.t_ns);
    EXPECT_LT((read.world_from_body.params - truth.world_from_body.params).norm(), 1e-12);
    EXPECT_LT((read.twist->v_world - truth.twist->v_world).norm(), 1e-12);
    EXPECT_EQ(read.twist->omega_body, truth.twist->omega_body);
  }
}

TEST_F(Bag, IsEstimatedToTheSameTrajectory) {
  bag_.open(folder_ / "x.bag", rosbag::bagmode::Write);
  for (const Frame& frame : frames_) {
    Write("/left/compressed", Png(frame));
    Write("/right", Raw(frame));
  }
  bag_.close();
  const auto estimate = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.end(), {"--output", "out"});
    const ProgramRun run = RunProgram(folder_.path(), "tagtwist_estimate", arguments);
    EXPECT_EQ(run.status, 0) << run.err;
    return ReadText(folder_ / "out/optimised.tum");
  };
  const std::string own = estimate({"--dataset", "rec"});
  EXPECT_GT(own.size(), 100u);
  EXPECT_EQ(estimate({"--dataset", "x.bag", "--topic", "/left/compressed"}), own);
  EXPECT_EQ(estimate({"--dataset", "x.bag", "--topic", "/right"}), own);
  const ProgramRun run =
      RunProgram(folder_.path(), "tagtwist_estimate", {"--dataset", "x.bag", "--output", "no"});
  EXPECT_EQ(run.status, 1);
  EXPECT_EQ(run.err,
            "tagtwist_estimate: x.bag: several topics have images: expected --topic, one of "
            "/left/compressed, /right\n");
}

TEST_F(Bag, WithoutStampsTheArrivalsStandForThem) {
  bag_.open(folder_ / "x.bag", rosbag::bagmode::Write);
  for (const Frame& frame : frames_) {
    sensor_msgs::Image message = Raw(frame);
    message.header.stamp = ros::Time();
    bag_.write("/cam", ToRos(frame.t_ns + 1000), message);
  }
  bag_.close();
  const auto source = OpenDataSource(folder_ / "x.bag", {});
  ASSERT_TRUE(source) << source.error().message;
  EXPECT_EQ((*source)->stamps_ns().back(), frames_.back().t_ns + 1000);
}

TEST_F(Bag, IsRefusedInOneLine) {
  WriteBag();
  EXPECT_THAT(Refusal({false, true, {}, "/cam7"}),
              HasSubstr("x.bag: no images on the topic /cam7: expected one of /cam0/image_raw"));
  EXPECT_THAT(Refusal({true, true, {}, ""}), HasSubstr("a bag has no detections to use"));
  bag_.open(folder_ / "x.bag", rosbag::bagmode::Write);
  WriteImu();
  bag_.close();
  EXPECT_THAT(Refusal(), HasSubstr("x.bag: no images in the bag"));
  bag_.open(folder_ / "x.bag", rosbag::bagmode::Write);
  for (const size_t i : {2, 1, 0}) {
    bag_.write("/cam", ToRos(1000000000), Raw(frames_[i]));
  }
  bag_.close();
  EXPECT_THAT(
      Refusal(),
      HasSubstr("x.bag: /cam: stamp 0.020000000 s repeats or runs backwards, and so do others"));
  bag_.open(folder_ / "x.bag", rosbag::bagmode::Write);
  sensor_msgs::Image odd = Raw(frames_[0]);
  odd.encoding = "nv99";
  Write("/cam", odd);
  bag_.close();
  EXPECT_THAT(Refusal(), HasSubstr("x.bag: /cam, message 0: encoding: expected one of mono8"));
}

TEST_F(Bag, ABadImageIsToldAndTheOthersAreRead) {
  bag_.open(folder_ / "x.bag", rosbag::bagmode::Write);
  for (size_t i = 0; i < frames_.size(); ++i) {
    sensor_msgs::CompressedImage message = Png(frames_[i]);
    if (i == 3) message.data.resize(message.data.size() / 2);
    Write("/cam", message);
  }
  bag_.close();
  auto source = OpenDataSource(folder_ / "x.bag", {});
  ASSERT_TRUE(source) << source.error().message;
  const std::vector<Frame> frames = AllFrames(source->get());
  ASSERT_EQ(frames.size(), frames_.size());
  for (size_t i = 0; i < frames.size(); ++i) {
    EXPECT_EQ(frames[i].image.empty(), i == 3);
    EXPECT_EQ(frames[i].image_problem, i == 3 ? "truncated PNG" : "");
  }
}

// Cut short. Bytes that changed are not tried: ROS' library reads beyond its buffers then.
TEST_F(Bag, DamageIsRefusedInOneLine) {
  WriteBag();
  const std::string whole = ReadText(folder_ / "x.bag");
  for (const size_t bytes : {14, 100, 4117, 5000, 100000}) {
    WriteText(folder_ / "x.bag", whole.substr(0, std::min(bytes, whole.size() - 1)));
    const std::string refusal = Refusal();
    EXPECT_THAT(refusal, HasSubstr("x.bag: a damaged bag")) << bytes;
    EXPECT_EQ(refusal.find('\n'), std::string::npos);
  }
}

// Transforms are truth where one of their frames is asked for; else a note says how.
TEST_F(Bag, TransformsOfAFrameAreTruth) {
  bag_.open(folder_ / "x.bag", rosbag::bagmode::Write);
  for (const Frame& frame : frames_) Write("/cam0/image_raw", Raw(frame));
  for (const TruthSample& sample : original_->ground_truth()) {
    Ros1Transforms message{std::vector<geometry_msgs::TransformStamped>(2)};
    for (geometry_msgs::TransformStamped& transform : message.transforms) {
      transform.header.stamp = ToRos(sample.t_ns);
      transform.transform.rotation.w = 1;
    }
    message.transforms[0].child_frame_id = "map",
    message.transforms[1].child_frame_id = "base_link";
    Set(Eigen::Vector3d(sample.world_from_body.translation()),
        &message.transforms[1].transform.translation);
    bag_.write("/tf", ToRos(sample.t_ns) + ros::Duration(0.005), message);
  }
  bag_.close();
  const auto untold = OpenDataSource(folder_ / "x.bag", {});
  ASSERT_TRUE(untold && (*untold)->ground_truth().empty());
  EXPECT_THAT((*untold)->notes(), testing::ElementsAre(HasSubstr("--truth_topic /tf:CHILD")));
  DataSourceOptions options;
  options.truth_topic = "/tf:base_link";
  const auto source = OpenDataSource(folder_ / "x.bag", options);
  ASSERT_TRUE(source) << source.error().message;
  EXPECT_EQ((*source)->truth_origin(), "transforms of base_link on /tf");
  ASSERT_EQ((*source)->ground_truth().size(), original_->ground_truth().size());
  EXPECT_EQ((*source)->ground_truth()[3].world_from_body.translation(),
            original_->ground_truth()[3].world_from_body.translation());
  options.truth_topic = "/tf:base";
  EXPECT_THAT(Refusal(options),
              HasSubstr("no transform of base on /tf: expected one of base_link"));
  options.truth_topic = "/tf";
  EXPECT_THAT(Refusal(options), HasSubstr("--truth_topic /tf:CHILD takes those of a frame"));
}

}  // namespace
}  // namespace tagtwist::internal::bag_source_test

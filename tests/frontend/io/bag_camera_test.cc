// The calibration that a ROS bag has: camera_info.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rosbag/bag.h>
#include <sensor_msgs/CameraInfo.h>

#include "frontend/io/setup/camera_file.h"
#include "tests/support/formats/ros2_writers.h"
#include "tests/support/temp_folder.h"
#include "tests/support/test_files.h"

namespace tagtwist::internal::bag_camera_test {
namespace {

using ::testing::HasSubstr;

sensor_msgs::CameraInfo Info() {
  sensor_msgs::CameraInfo out;
  out.header.stamp = ros::Time(10.0);
  out.width = 640;
  out.height = 480;
  out.distortion_model = "plumb_bob";
  out.D = {-0.2, 0.05, 0.001, -0.002, 0.0};
  out.K = {400, 0, 320.5, 0, 401, 239.5, 0, 0, 1};
  out.binning_x = 2;
  out.binning_y = 2;
  return out;
}

Message InRos2(const std::string& topic) {
  const sensor_msgs::CameraInfo info = Info();
  Ros2Writer out;
  out.Header(10) << info.height << info.width << info.distortion_model
                 << static_cast<uint32_t>(info.D.size());
  for (const double value : info.D) out << value;
  for (const double value : info.K) out << value;
  out.Zeros(9 + 12);
  out << info.binning_x << info.binning_y << uint32_t{0} << uint32_t{0} << uint32_t{0}
      << uint32_t{0} << uint8_t{0};
  return {topic, "sensor_msgs/msg/CameraInfo", 10'000'000'000, out.Data()};
}

class BagCamera : public testing::Test {
 protected:
  void WriteRos1(const std::vector<std::string>& topics) const {
    rosbag::Bag bag(folder_ / "x.bag", rosbag::bagmode::Write);
    for (const std::string& topic : topics) bag.write(topic, ros::Time(10.0), Info());
  }
  const TempFolder folder_;
};

TEST_F(BagCamera, IsReadFromEitherVersion) {
  WriteRos1({"/cam"});
  WriteText(folder_ / "x.mcap", Mcap("zstd", {InRos2("/cam")}));
  for (const char* name : {"x.bag", "x.mcap"}) {
    const auto read = ReadCameraFile(folder_ / name, "");
    ASSERT_TRUE(read) << read.error().message;
    const Camera& camera = read->camera;
    EXPECT_EQ(camera.width, 320) << name;
    EXPECT_EQ(camera.height, 240) << name;
    EXPECT_EQ(camera.fx, 200) << name;
    EXPECT_EQ(camera.fy, 200.5) << name;
    EXPECT_EQ(camera.cx, 160) << name;
    EXPECT_EQ(camera.k1, -0.2) << name;
    EXPECT_EQ(camera.p2, -0.002) << name;
    EXPECT_EQ(read->notes.size(), 1u) << name;  // of the binning
  }
}

TEST_F(BagCamera, OneOfSeveralTopicsIsNamed) {
  WriteRos1({"/body", "/cam"});
  WriteText(folder_ / "x.mcap", Mcap("lz4", {InRos2("/body"), InRos2("/cam")}));
  for (const char* name : {"x.bag", "x.mcap"}) {
    const auto untold = ReadCameraFile(folder_ / name, "");
    ASSERT_FALSE(untold);
    EXPECT_THAT(
        untold.error().message,
        HasSubstr("several topics have camera_info: expected --camera, one of /body, /cam"));
    EXPECT_TRUE(ReadCameraFile(folder_ / name, "/cam")) << name;
    EXPECT_FALSE(ReadCameraFile(folder_ / name, "/bod")) << name;
  }
}

TEST_F(BagCamera, ABagWithoutOrADamagedMessageIsRefused) {
  WriteRos1({});
  Message cut = InRos2("/cam");
  cut.data.resize(cut.data.size() / 2);
  WriteText(folder_ / "x.mcap", Mcap("zstd", {cut}));
  EXPECT_FALSE(ReadCameraFile(folder_ / "x.bag", ""));
  const auto damaged = ReadCameraFile(folder_ / "x.mcap", "");
  ASSERT_FALSE(damaged);
  EXPECT_THAT(damaged.error().message, HasSubstr("no message on /cam decodes"));
}

}  // namespace
}  // namespace tagtwist::internal::bag_camera_test

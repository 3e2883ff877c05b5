#pragma once
#include <functional>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "frontend/io/recordings/data_source.h"
#include "tests/support/formats/ros2_writers.h"

namespace tagtwist::internal {

/// A recording as messages of ROS 2: images in three equal colours on /cam, odometry of its truth
/// on /body, the IMU on /imu. Messages arrive 5 ms after their stamps.
inline std::vector<Message> Ros2FlightOf(const std::vector<Frame>& frames,
                                         const DataSource& source) {
  std::vector<Message> out;
  const auto add = [&](const std::string& topic, const std::string& type, int64_t t_ns,
                       const std::function<void(Ros2Writer*)>& write) {
    Ros2Writer message;
    message << static_cast<int32_t>(t_ns / 1'000'000'000)
            << static_cast<uint32_t>(t_ns % 1'000'000'000) << std::string("frame");
    write(&message);
    out.push_back({topic, type, t_ns + 5'000'000, message.Data()});
  };
  const auto write = [](Ros2Writer* message, const auto& vector) {
    for (Eigen::Index i = 0; i < vector.size(); ++i) *message << vector[i];
  };
  for (const Frame& frame : frames) {
    add("/cam", "sensor_msgs/msg/Image", frame.t_ns, [&](Ros2Writer* message) {
      cv::Mat colour;
      cv::cvtColor(frame.image, colour, cv::COLOR_GRAY2BGR);
      *message << static_cast<uint32_t>(colour.rows) << static_cast<uint32_t>(colour.cols)
               << std::string("bgr8") << uint8_t{0} << static_cast<uint32_t>(3 * colour.cols)
               << std::vector<uint8_t>(colour.datastart, colour.dataend);
    });
  }
  for (const ImuSample& sample : source.imu()) {
    add("/imu", "sensor_msgs/msg/Imu", sample.t_ns, [&](Ros2Writer* message) {
      message->Zeros(13);
      write(message, sample.gyro_radps);
      message->Zeros(9);
      write(message, sample.accel_mps2);
      message->Zeros(9);
    });
  }
  for (const TruthSample& sample : source.ground_truth()) {
    const Pose& pose = sample.world_from_body;
    add("/body", "nav_msgs/msg/Odometry", sample.t_ns, [&](Ros2Writer* message) {
      *message << std::string("body");
      write(message, Eigen::Vector3d(pose.translation()));
      write(message, pose.rotation().coeffs());
      message->Zeros(36);
      write(message, Eigen::Vector3d(pose.rotation().conjugate() * sample.twist->v_world));
      write(message, sample.twist->omega_body);
      message->Zeros(36);
    });
  }
  return out;
}

}  // namespace tagtwist::internal

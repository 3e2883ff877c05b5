#pragma once
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "frontend/io/images/image_file.h"
#include "frontend/io/recordings/data_source.h"
#include "frontend/io/recordings/dataset_writer.h"
#include "frontend/types/so3.h"

namespace tagtwist::internal {

inline void WriteText(const std::string& path, const std::string& text) {
  std::ofstream(path, std::ios::binary) << text;
}

inline std::string ReadText(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

inline void WriteImage(const std::string& path, const cv::Mat& image) {
  const auto png = EncodePng(image);
  ASSERT_TRUE(png) << png.error().message;
  WriteText(path, *png);
}

/// A reproducible noisy image.
inline cv::Mat MakeImage(int index, int width = 40, int height = 30) {
  cv::Mat image(height, width, CV_8UC1);
  cv::RNG random(static_cast<uint64_t>(index) + 1);
  random.fill(image, cv::RNG::UNIFORM, 0, 256);
  return image;
}

inline TagDetection MakeTag(int id, double offset) {
  TagDetection tag;
  tag.id = id;
  tag.corners = {Eigen::Vector2d(1.0 / 3 + offset, 20), Eigen::Vector2d(10.1 + offset, 21),
                 Eigen::Vector2d(11 + offset, 1e-3), Eigen::Vector2d(-0.25 + offset, 2)};
  return tag;
}

/// A small recording: frame 1 has no tag, frame 2 one tag, the others three; 49 frames a second
/// with stamps of no round number; truth at 100 Hz; an IMU sample at each frame.
struct Recording {
  std::vector<FrameToWrite> frames;
  std::vector<TruthSample> truth;
  std::vector<ImuSample> imu;
};

inline Recording MakeRecording(int frames, bool with_images = true) {
  Recording out;
  for (int i = 0; i < frames; ++i) {
    FrameToWrite frame;
    frame.t_ns = 17'230'033 + 20'408'163LL * i;
    if (with_images) frame.image = MakeImage(i);
    const int tags = i == 1 ? 0 : i == 2 ? 1 : 3;
    for (int k = 0; k < tags; ++k) frame.detections.push_back(MakeTag(7 * k + i, 0.1 * i));
    out.frames.push_back(frame);
    out.imu.push_back({frame.t_ns, {0.1 * i, 1.0 / 3, 9.81}, {-0.2, 0.01 * i, 1e-9}});
  }
  for (int i = 0; i < 2 * frames; ++i) {
    TruthSample sample;
    sample.t_ns = 10'000'000LL * i + 3;
    const double angle = 0.05 * i;
    sample.world_from_body =
        MakePose(ExpSo3({0.3 * std::sin(angle), -0.2, angle}), {1.0 / 3, angle, -1.5});
    sample.twist = Twist{{0.1, -angle, 2.0 / 3}, {angle, 0.25, -1e-7}};
    out.truth.push_back(sample);
  }
  return out;
}

inline void WriteRecording(const Recording& recording, const std::string& path,
                           DatasetFormat format) {
  auto writer = CreateDatasetWriter(path, format);
  ASSERT_TRUE(writer) << writer.error().message;
  for (const FrameToWrite& frame : recording.frames) {
    const Status added = (*writer)->Add(frame);
    ASSERT_TRUE(added) << added.error().message;
  }
  const Status finished = (*writer)->Finish(recording.truth, recording.imu);
  ASSERT_TRUE(finished) << finished.error().message;
}

/// All frames of a source; a failure ends them and is told in `fault`.
inline std::vector<Frame> ReadAllFrames(DataSource* source, std::string* fault = nullptr) {
  std::vector<Frame> out;
  for (;;) {
    auto frame = source->Next();
    if (!frame) {
      if (fault != nullptr) *fault = frame.error().message;
      EXPECT_NE(fault, nullptr) << frame.error().message;
      return out;
    }
    if (!*frame) return out;
    out.push_back(std::move(**frame));
  }
}

/// The message of a refused opening; "opened" when it is not refused.
inline std::string OpenFault(const std::string& path, const DataSourceOptions& options = {}) {
  const auto source = OpenDataSource(path, options);
  return source ? "opened" : source.error().message;
}

}  // namespace tagtwist::internal

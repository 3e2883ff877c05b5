#pragma once
#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <vector>

#include "frontend/io/recordings/data_source.h"

namespace tagtwist::internal {

/// The kinds behind OpenDataSource.
Result<std::unique_ptr<DataSource>> OpenFolderSource(const std::string& folder,
                                                     const DataSourceOptions& options);
/// The folder beside a camera's that its detections are in: tags1 of cam1.
std::string EurocTags(const std::string& camera);
/// `folder` holds the camera's folder: cam0, cam1, ...
Result<std::unique_ptr<DataSource>> OpenEurocSource(const std::string& folder,
                                                    const std::string& camera,
                                                    const DataSourceOptions& options);
Result<std::unique_ptr<DataSource>> OpenMatSource(const std::string& path,
                                                  const DataSourceOptions& options);

/// Anything that OpenCV's FFmpeg reads. Stamps: presentation times, or the frame rate's.
Result<std::unique_ptr<DataSource>> OpenVideoSource(const std::string& path,
                                                    const DataSourceOptions& options);
/// A ROS 1 bag: sensor_msgs Image or CompressedImage on a topic; Imu, and as ground truth
/// PoseStamped, TransformStamped or Odometry, where one topic alone has them. An error in a build
/// without rosbag_storage.
Result<std::unique_ptr<DataSource>> OpenBagSource(const std::string& path,
                                                  const DataSourceOptions& options);
/// A ROS 2 bag: a folder with metadata.yaml, or one of its files (.db3, .mcap). Topics as of a ROS
/// 1 bag, and apriltag_msgs' AprilTagDetectionArray as detections.
bool IsRos2Bag(const std::string& path);
Result<std::unique_ptr<DataSource>> OpenRos2Source(const std::string& path,
                                                   const DataSourceOptions& options);
/// A folder of images with their stamps for names: 1403636579763555584.png, cam_12.345678.jpg.
bool HasNamedImages(const std::string& folder);
Result<std::unique_ptr<DataSource>> OpenNamedImagesSource(const std::string& folder,
                                                          const DataSourceOptions& options);

/// Remembers the first good image's size; all others must have it.
class ImageSizeGuard {
 public:
  /// "images/7.png: expected 376 x 240 px like images/0.png, got 320 x 240".
  std::optional<Error> Check(const cv::Mat& image, const std::string& name);

 private:
  cv::Size size_;
  std::string first_name_;
};

}  // namespace tagtwist::internal

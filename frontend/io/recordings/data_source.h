#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <vector>

#include "frontend/base/limits.h"
#include "frontend/base/result.h"
#include "frontend/types/body_state.h"
#include "frontend/types/camera.h"
#include "frontend/types/measurements.h"

namespace tagtwist {

/// One packet of a recording.
struct Frame {
  int64_t t_ns = 0;
  std::string name;           // for messages: the image's path, or "studentdata1.mat: data(17)"
  cv::Mat image;              // 8-bit gray; empty when not asked for, or bad
  std::string image_problem;  // why the image is empty though it was asked for: "cannot decode"
  std::vector<TagDetection> detections;  // the data set's own corners; only with use_detections
  std::vector<int> doubled_ids = {};     // FrameMeasurements::doubled_ids, as it tells them besides
  int camera = 0;                        // of the rig (Rig::cameras) that took it
  std::vector<Frame> others = {};        // of other cameras of the rig at the same time
};

struct DataSourceOptions {
  /// Corners come from the data set (detections.csv, or id and p0..p4 of the .mat), not from
  /// images.
  bool use_detections = false;
  /// With use_detections: images are still read where there are any (for the tracks).
  bool read_images = true;
  /// Ids of the map: another one in a detections.csv is an error, told with its line. Empty: any is
  /// taken.
  std::vector<int> known_tag_ids;
  /// Topic of the images in a ROS bag; empty: the only one that has any.
  std::string topic = {};
  /// Of the ground truth in a ROS bag; empty: the only one that has poses.
  std::string truth_topic = {};
  /// What its files may ask for at most.
  Limits limits = {};
};

/// A recording, streamed: frames come one at a time in order of time, images are read when asked
/// for and never kept. Ground truth and IMU are small and read at opening.
class DataSource {
 public:
  virtual ~DataSource() = default;
  /// The next frame, nullopt at the end, or an error that ends the recording.
  virtual Result<std::optional<Frame>> Next() = 0;
  /// Passes over the next frames, at less cost than Next() where the source can. The recording's
  /// end is none of its errors.
  virtual Status Skip(size_t frames);
  /// All frames' stamps, known at opening, strictly growing; empty where it is a camera.
  virtual const std::vector<int64_t>& stamps_ns() const = 0;
  virtual const std::vector<TruthSample>& ground_truth() const;  // empty when there is none
  virtual const std::vector<ImuSample>& imu() const;             // empty when there is none
  /// What was passed over, repaired or left out when it was opened: a line each, with the file's
  /// name. Whoever opens it must tell them.
  virtual const std::vector<std::string>& notes() const;
  /// Where the ground truth is from: a topic's or a file's name; empty when there is none, or where
  /// the recording's kind has but one place for it.
  virtual std::string truth_origin() const { return ""; }
  /// Stamps are rounded to whole steps of that, which no clock of the frames is known to keep [s];
  /// 0: none that anybody knows of.
  virtual double stamp_step_s() const { return 0; }
};

/// Opens a course .mat, a ROS 1 bag (where the build has rosbag_storage), a video, an EuRoC/ASL
/// folder (mav0/cam0/data.csv, or cam0/data.csv, below it), a plain folder (timestamps.csv) or one
/// of images with stamps for names, told apart by what is there. Errors name the file, the line
/// where there is one, and the fault.
Result<std::unique_ptr<DataSource>> OpenDataSource(const std::string& path,
                                                   const DataSourceOptions& options);

/// True for "camera:PLACE".
bool IsCamera(const std::string& dataset);
/// Frames of a camera as OpenCV sees it. PLACE: a number or a path in /dev by Video4Linux, whatever
/// else (a stream's URL) by FFmpeg. A device is asked for the size of `camera`. Stamps are
/// `now_ns`, taken when a frame is grabbed; nobody knows them before. Ends when no more come.
Result<std::unique_ptr<DataSource>> OpenCameraSource(const std::string& dataset,
                                                     const Camera& camera,
                                                     std::function<int64_t()> now_ns,
                                                     const Limits& limits = {});

}  // namespace tagtwist

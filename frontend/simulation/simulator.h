#pragma once
#include <cstdint>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <vector>

#include "frontend/base/result.h"
#include "frontend/simulation/renderer_options.h"
#include "frontend/simulation/spline_trajectory.h"
#include "frontend/types/measurements.h"
#include "frontend/types/rig.h"

namespace tagtwist {

struct SimulatorOptions {
  RendererOptions renderer;      // its scene's seed is replaced by the one below
  uint64_t random_seed = 1;      // of everything random
  bool images = true;            // render them
  double exposure_s = 0.002;     // motion blur; stamps are the middle of the exposure, >= 0
  double line_time_s = 0;        // rolling shutter: row v is taken line_time_s * v after the stamp;
                                 // of detections alone, 0 with images
  double corner_noise_px = 0.1;  // of the detections' corners, standard deviation, >= 0
  double min_tag_side_px = 8;    // detections have no shorter side, >= 0
  double hidden_fraction = 0;    // share of the visible tags that are not detected, 0 to 1
  double wrong_id_fraction = 0;  // share of the detections that carry another tag's id, 0 to 1
  double hide_tags_from_s = 0;  // between these stamps [s] papers are blank and nothing is detected
  double hide_tags_to_s = 0;
  double imu_rate_hz = 200;        // 0: no IMU
  double gyro_noise_radps = 0.01;  // of a sample, standard deviation, >= 0
  double accel_noise_mps2 = 0.1;   // of a sample, standard deviation, >= 0
  double gyro_bias_radps = 0;      // of an axis, constant, drawn with that standard deviation, >= 0
  double accel_bias_mps2 = 0;      // likewise
  std::optional<std::string> Problem() const;

  template <typename Self, typename Visitor>
  static void VisitFields(Self& self, Visitor&& visit) {
    visit("random_seed", self.random_seed);
    visit("images", self.images);
    visit("exposure_s", self.exposure_s);
    visit("line_time_s", self.line_time_s);
    visit("corner_noise_px", self.corner_noise_px);
    visit("min_tag_side_px", self.min_tag_side_px);
    visit("hidden_fraction", self.hidden_fraction);
    visit("wrong_id_fraction", self.wrong_id_fraction);
    visit("hide_tags_from_s", self.hide_tags_from_s);
    visit("hide_tags_to_s", self.hide_tags_to_s);
    visit("imu_rate_hz", self.imu_rate_hz);
    visit("gyro_noise_radps", self.gyro_noise_radps);
    visit("accel_noise_mps2", self.accel_noise_mps2);
    visit("gyro_bias_radps", self.gyro_bias_radps);
    visit("accel_bias_mps2", self.accel_bias_mps2);
  }
};

/// A frame as the camera would have taken it, and the truth of that moment.
struct SimulatedFrame {
  int64_t t_ns = 0;
  cv::Mat image;  // 8-bit gray; empty without SimulatorOptions::images
  BodyState truth;
  std::vector<TagDetection> detections;  // projected corners and noise, in the order of the map
};

/// A flight over the tags, or with cameras that stand in W one of the tags, frame by frame.
/// Immutable: MakeFrame may be called from several threads and in any order, and its bytes depend
/// on its arguments and the options alone.
class Simulator {
 public:
  /// The shutter is that of the options, not the set-up's.
  static Result<Simulator> Make(const SetUp& set_up, const SplineTrajectory& trajectory,
                                const SimulatorOptions& options);

  /// Frame number `index` (it picks the noise) at a stamp within the trajectory.
  SimulatedFrame MakeFrame(uint64_t index, int64_t t_ns) const;
  /// IMU samples between two stamps, both included where they fall on the raster. Gravity is
  /// 9.81 m/s^2 along -z of W; the IMU sits at the body's origin.
  std::vector<ImuSample> MakeImu(int64_t first_ns, int64_t last_ns) const;

  const SplineTrajectory& trajectory() const { return trajectory_; }
  /// Tags that the camera sees whole and from their front, with their true corners, each where the
  /// camera is when its row is taken.
  std::vector<TagDetection> FindVisibleTags(int64_t t_ns) const;

 private:
  struct Impl;
  Simulator(std::shared_ptr<const Impl> impl, const SetUp& set_up,
            const SplineTrajectory& trajectory, const SimulatorOptions& options);
  // World: the frame of the map, which is B where the camera stands in W.
  Pose WorldFromCam(int64_t t_ns) const;
  bool TagsAreHiddenAt(int64_t t_ns) const;
  std::vector<Pose> ExposurePoses(int64_t t_ns) const;
  void Disturb(uint64_t index, std::vector<TagDetection>* detections) const;

  std::shared_ptr<const Impl> impl_;
  Pose cam_from_body_;
  MountedOn mounted_on_;
  TagMap map_;
  SplineTrajectory trajectory_;
  SimulatorOptions options_;
};

struct StampOptions {
  double rate_hz = 49;  // > 0
  double jitter_s = 0;  // each stamp moves by up to this, either way; under 0.45 intervals
  uint64_t random_seed = 1;
  std::optional<std::string> Problem() const;
};

/// Stamps of frames at a rate within [first_ns, last_ns], strictly growing.
Result<std::vector<int64_t>> MakeStamps(int64_t first_ns, int64_t last_ns,
                                        const StampOptions& options);

}  // namespace tagtwist

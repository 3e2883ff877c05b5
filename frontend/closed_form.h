#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "frontend/flow/optical_flow.h"
#include "frontend/flow/twist_ransac.h"
#include "frontend/types/camera.h"
#include "frontend/types/measurements.h"
#include "frontend/types/tag_map.h"
#include "frontend/types/tag_planes.h"

namespace tagtwist {

/// Field names are the YAML keys of the section `closed_form`. With normalise_points off,
/// seed_scale and mean_dt on, the method is the seed's to the letter.
struct ClosedFormOptions {
  bool normalise_points = true;  // Hartley's normalisation before the DLT
  bool seed_scale = false;  // translation over |r1| (seed Eq. 5), else over the mean of |r1|, |r2|
  bool mean_dt = false;     // flow over the mean interval so far, else over the measured one
  double max_gap_s = 0.5;   // a longer interval gives no twist and restarts the low-pass, > 0
  double low_pass_alpha = 0.8;         // weight of the past (seed Eq. 12), in [0, 1)
  double ransac_threshold_px = 1.0;    // error of an inlier's flow over one interval [px], > 0
  double ransac_success = 0.99999999;  // probability of one sample free of outliers, in (0, 1)
  double ransac_inlier_ratio = 0.8;    // in (0, 1)
  int ransac_enough_inliers = 200;     // that many end the search, >= 3
  int ransac_seed = 1;                 // of the random draws

  std::optional<std::string> Problem() const;

  template <typename Self, typename Visitor>
  static void VisitFields(Self& self, Visitor&& visit) {
    visit("normalise_points", self.normalise_points);
    visit("seed_scale", self.seed_scale);
    visit("mean_dt", self.mean_dt);
    visit("max_gap_s", self.max_gap_s);
    visit("low_pass_alpha", self.low_pass_alpha);
    visit("ransac_threshold_px", self.ransac_threshold_px);
    visit("ransac_success", self.ransac_success);
    visit("ransac_inlier_ratio", self.ransac_inlier_ratio);
    visit("ransac_enough_inliers", self.ransac_enough_inliers);
    visit("ransac_seed", self.ransac_seed);
  }
};

/// The seed's method, frame after frame: pose by homography, twist by flow and RANSAC, low-pass.
/// The flow is that of all tracks, on tags too; where fewer than three tracks were followed (no
/// image), that of the corners of the tags seen in both frames. The twist needs the frame's pose.
class ClosedFormEstimator {
 public:
  ClosedFormEstimator(const Camera& camera, const Pose& cam_from_body, const TagMap& map,
                      const ClosedFormOptions& options);

  /// Closed form of the next frame. Stamps must grow. Tags are in the map (FilterTags); tracks are
  /// sorted by id.
  ClosedForm Update(int64_t t_ns, const std::vector<TagDetection>& tags,
                    const std::vector<TrackObservation>& tracks);

 private:
  std::vector<FlowPoint> Flow(const Pose& world_from_cam, double dt_s,
                              const std::vector<TagDetection>& tags,
                              const std::vector<TrackObservation>& tracks) const;
  void UpdateTwists(int64_t t_ns, const std::vector<FlowPoint>& flow, double dt_s,
                    ClosedForm* closed_form);

  Camera camera_;
  Pose cam_from_body_;
  TagMap map_;
  ClosedFormOptions options_;
  TagPlanes planes_;

  std::optional<int64_t> last_t_ns_;
  std::vector<TagDetection> last_tags_;
  std::vector<TrackObservation> last_tracks_;
  double sum_dt_s_ = 0;  // of the intervals without a gap
  int n_dt_ = 0;
  std::optional<Twist> low_pass_;
  int64_t low_pass_t_ns_ = 0;
};

}  // namespace tagtwist

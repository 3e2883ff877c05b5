#pragma once
#include <optional>
#include <string>

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

}  // namespace tagtwist

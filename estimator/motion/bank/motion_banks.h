#pragma once
#include <cstdint>
#include <optional>
#include <vector>

#include "estimator/graph/noise_model.h"
#include "estimator/motion/bank/motion_bank.h"
#include "estimator/motion/bank/tags_alone.h"

namespace tagtwist::internal {

/// Some of a motion's parts.
struct MotionParts {
  bool linear = false, angular = false;
};

/// Logarithms of likelihoods, of each part of a motion.
struct PartLikelihoods {
  double linear = 0, angular = 0;
};

/// How lively a body moves from frame to frame: a MotionBank for its position in W and one for its
/// attitude, fed with the poses that the tags of each frame say by themselves.
class MotionBanks {
 public:
  struct Densities {
    double linear = 1, angular = 1;
  };
  struct Weights {
    std::vector<double> linear, angular;
  };
  /// The classes just before a frame is measured.
  struct Prediction {
    std::vector<MotionBank::Class> linear, angular;
    Pose reference;
    double dt_s = 0;  // since the frame before
  };

  MotionBanks() : MotionBanks(MotionPrior(), MotionPrior()) {}
  /// Of whatever density.
  MotionBanks(const MotionPrior& linear, const MotionPrior& angular);
  MotionBanks(const MotionBankOptions& linear, const MotionBankOptions& angular);

  /// Goes on to the next frame. Stamps must grow, or, of a bank that comes from the future, fall.
  void Predict(int64_t t_ns);
  /// What the frame's tags say.
  void Measure(const PoseMeasurement& pose);
  /// Whether anything was measured.
  bool is_measured() const { return n_measured_ > 0; }
  /// Over the interval that ends with the last frame.
  Densities densities() const { return {linear_.Density(), angular_.Density()}; }
  /// Of the classes after the last frame.
  Weights weights() const { return {linear_.weights(), angular_.weights()}; }
  /// After Predict.
  Prediction prediction() const;
  /// The densities over the interval that ends with a frame, of what was predicted for it from the
  /// past, this being a bank from the future that has measured it.
  Densities DensitiesAfter(const Prediction& past) const;
  /// Of the last frame, those before it given; of the first one none.
  PartLikelihoods log_likelihoods() const;
  /// What is known of the classes besides.
  void SetWeights(const Weights& weights);
  /// Of the other part nothing is followed from now on, and nothing it says counts.
  void FollowOnly(const MotionParts& parts) { follows_ = parts; }
  const MotionParts& follows() const { return follows_; }
  /// MotionPrior::shake_s from now on.
  void SetShakes(double linear_s, double angular_s);
  /// A bank of one class: its density from now on.
  void SetDensities(const Densities& densities) {
    linear_.SetLeastDensity(densities.linear);
    angular_.SetLeastDensity(densities.angular);
  }
  /// What the variances of the last state lack in a filter with the mean densities: large while it
  /// is open how lively the motion is.
  StateVector ExcessVariances() const;

 private:
  void PredictBy(double dt_s);

  MotionBank linear_, angular_;  // the latter about reference_, in the body's frame
  Pose reference_;
  int64_t last_ns_ = 0;
  double dt_s_ = 0;  // to it
  int n_measured_ = 0;
  MotionParts follows_ = {true, true};
};

/// Over position and attitude under one density each.
MotionBanks UnderOneDensity(const MotionPrior& linear, const MotionPrior& angular);

}  // namespace tagtwist::internal

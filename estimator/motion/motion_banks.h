#pragma once
#include <cstdint>
#include <optional>
#include <vector>

#include "estimator/graph/noise_model.h"
#include "estimator/motion/motion_bank.h"
#include "estimator/motion/tags_alone.h"

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

/// MotionBanks over consecutive frames, kept so that later ones tell of earlier ones; beside it the
/// same under the one density that the noise model has, so that it shows which of the two the
/// frames follow. Frames count whose tags agree, and, with keeps_past, two in a row of the map's
/// only tag.
class MotionHistory {
 public:
  MotionHistory() : MotionHistory(NoiseModel()) {}
  /// With keeps_past, what is known of each frame from its past stays with it, some kilobytes,
  /// until it is dropped; without, no frame may be dropped.
  explicit MotionHistory(const NoiseModel& noise, bool keeps_past = true);

  /// The next frame, whose state is near its tags' pose. One whose tags do not fix the pose says
  /// nothing. `noise` may have changed since the last one.
  void Add(const EstimatorSetup& setup, const NoiseModel& noise, const GraphFrame& frame);
  struct Shares {
    double linear = 1, angular = 1;
  };

  /// The first frame, if there is one, is told of no more.
  void DropFirst() {
    if (!frames_.empty()) frames_.erase(frames_.begin());
  }

  const MotionBanks& banks() const { return banks_; }
  /// Whether the latest frames, about a hundred, are likelier beyond doubt under the bank than
  /// under the noise model's density, and than under a tenth of it: that is taken rather too high
  /// where tags barely resolve the motion, which is no reason to believe in rest.
  bool LinearVaries() const;
  bool AngularVaries() const;
  bool Varies() const { return LinearVaries() || AngularVaries(); }
  /// Probabilities that the bank is right, against the likelier of the two.
  Shares ShareOfBank() const;
  /// The classes just before the last frame was measured; nullptr where its tags were passed over,
  /// or nothing was before it.
  const MotionBanks::Prediction* LastPrediction() const;
  /// Log-likelihoods of the frames under a bank that knows nothing yet.
  PartLikelihoods Likelihoods(MotionBanks bank) const;
  /// The densities over the intervals that end with each frame, from the past and the future; only
  /// the `wanted` parts' are of use.
  std::vector<MotionBanks::Densities> FromBothSides(const MotionParts& wanted) const;

 private:
  static constexpr double kClearly = 5;  // beyond doubt
  struct Frame {
    int64_t t_ns = 0;
    std::optional<PoseMeasurement> pose;
    bool breaks = false;  // MotionScale
    MotionBanks::Prediction past;
  };
  void TakeShakes(const NoiseModel& noise);
  void Compare(const MotionBanks::Densities& densities, const Frame& frame);

  // One density, and what the bank has over it, fading.
  struct Rival {
    double share = 1;  // of the noise model's
    MotionBanks single;
    PartLikelihoods advantage = {};
  };

  // Banks that have these weights and know nothing of where the body is.
  MotionBanks Anew(const MotionBanks& from) const;
  std::vector<MotionBanks::Prediction> PastOf(size_t first, size_t end, MotionBanks* banks) const;
  void TellBackwards(size_t k, const MotionBanks::Prediction& past, MotionBanks* backwards,
                     std::vector<MotionBanks::Densities>* out) const;

  bool GoesOn(const EstimatorSetup& setup, const GraphFrame& frame);

  bool keeps_past_ = true;
  bool shown_before_ = false;  // the map's only tag, by the frame before
  MotionBanks banks_, fresh_;
  std::vector<Rival> rivals_;
  std::vector<Frame> frames_;
};

}  // namespace tagtwist::internal

#pragma once
#include <cstdint>
#include <optional>
#include <vector>

#include "estimator/graph/graph_builder.h"
#include "estimator/graph/noise_model.h"
#include "estimator/motion/bank/following_banks.h"
#include "estimator/motion/bank/tags_alone.h"

namespace tagtwist::internal {

/// MotionBanks over consecutive frames, kept so that later ones tell of earlier ones; beside it the
/// same under the one density that the noise model has, so that it shows which of the two the
/// frames follow. Frames count whose tags agree and, with keeps_past, those of a tag that is alone
/// for some frames in a row: of a tag that goes on what is shown is motion, whichever of its
/// possible poses it has, and even if it is a twin of the one in the map.
class MotionHistory {
 public:
  MotionHistory() : MotionHistory(NoiseModel()) {}
  /// With keeps_past, what is known of each frame from its past stays with it, some kilobytes,
  /// until it is dropped; without, no frame may be dropped.
  explicit MotionHistory(const NoiseModel& noise, bool keeps_past = true);

  /// The next frame, whose state is near its tags' pose. One whose tags neither agree on a pose nor
  /// are of a followed tag says nothing. `noise` may have changed since the last one.
  void Add(const EstimatorSetup& setup, const NoiseModel& noise, const GraphFrame& frame);
  struct Shares {
    double linear = 1, angular = 1;
  };

  /// The first frame, if there is one, is told of no more.
  void DropFirst() {
    if (!frames_.empty()) frames_.erase(frames_.begin());
  }

  const MotionBanks& banks() const { return now_.banks; }
  /// Whether frames come and go, so that what is known of each from its past is kept.
  bool IsOfWindow() const { return keeps_past_; }
  /// Whether a lone tag is followed.
  bool FollowsTag() const { return !now_.IsOf(std::nullopt) && now_.banks.is_measured(); }
  /// Whether these are all of a tag that has been followed from frame to frame.
  bool Follows(const std::vector<TagDetection>& tags) const {
    const auto lone = LoneTag(tags);
    return lone && now_.Follows(*lone);
  }
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
    std::optional<int> tag;  // that alone shows it
    bool breaks = false;     // MotionScale
    MotionBanks::Prediction past;
  };
  void TakeShakes(const NoiseModel& noise);
  void TakeWhatIsShown(const EstimatorSetup& setup, double corner_sigma_px, const GraphFrame& frame,
                       Frame* out);
  void Compare(const NoiseModel& noise, const Frame& frame);

  // One density, and what the bank has over it, fading.
  struct Rival {
    double share = 1;  // of the noise model's
    FollowingBanks single;
    PartLikelihoods advantage = {};
  };

  std::vector<MotionBanks::Prediction> PastOf(size_t first, size_t end,
                                              FollowingBanks* following) const;
  void TellBackwards(size_t k, const MotionBanks::Prediction& past, FollowingBanks* backwards,
                     std::vector<MotionBanks::Densities>* out) const;

  // Of two frames and more.
  double SpanS() const;
  double MeanStepS() const;

  bool keeps_past_ = true;
  std::optional<int> lone_before_;  // of the frame before, and how many have shown the same
  int in_a_row_ = 0;
  FollowingBanks now_;
  MotionBanks fresh_;
  std::vector<Rival> rivals_;
  std::vector<Frame> frames_;
};

}  // namespace tagtwist::internal

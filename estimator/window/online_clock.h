#pragma once
#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "estimator/graph/graph_builder.h"
#include "estimator/graph/noise_model.h"
#include "estimator/motion/bank/motion_banks.h"
#include "estimator/result/estimate.h"

namespace tagtwist::internal {

/// When frames were taken whose stamps scatter around a steady clock, for a window. The clock is
/// fitted to the latest stamps as they come (FitSteadyClock); its ticks are taken for the frames'
/// times once what their tags say by themselves is likelier beyond doubt at the ticks than at the
/// stamps, under a bank of densities of motion, and until the stamps are likelier again; where most
/// stamps are at the ticks and the others late, once it is likelier at all. While stamps are steady
/// by themselves it costs nothing.
class OnlineClock {
 public:
  explicit OnlineClock(const EstimatorSetup& setup);

  /// The time of the next frame; both stamps and times grow.
  int64_t TimeOf(int64_t stamp_ns);
  /// What the frame's tags say, from a pose near theirs on. True where times are to be taken in
  /// another way from the next frame on.
  bool Judge(double corner_sigma_px, const std::vector<TagDetection>& tags, const Pose& near);
  /// Names the frames by their stamps again: those that were given a time, in order. What is taken
  /// at its stamp has the stamps' own error in its covariance from then on.
  void NameByStamp(FrameEstimate* current, std::vector<FrameEstimate>* lagged);
  /// What it does, in a line; nullopt where it does nothing.
  std::optional<std::string> Warning() const;

 private:
  void NameOne(int64_t name_ns, FrameEstimate* frame) const;
  void Fit();
  void Forget();

  EstimatorSetup setup_;
  std::deque<int64_t> stamps_ns_;                          // the latest
  std::deque<std::pair<int64_t, int64_t>> time_and_name_;  // of frames that are still to be told
  std::optional<int64_t> tick_ns_;                         // of the newest, where there is a clock
  MotionBanks at_stamps_, at_ticks_;
  int64_t last_tick_ns_ = 0, last_time_ns_ = 0;
  double advantage_ = 0;  // of the ticks, in the logarithm of the likelihood, fading
  bool is_steady_ = false;
  bool is_evident_ = false;   // by the stamps alone
  bool is_followed_ = false;  // the tick of the frame before was asked for, too
  int since_fit_ = 0;
  int rests_ = 0;        // frames for which nobody asks, for the stamps hold beyond doubt
  size_t n_steady_ = 0;  // frames
  double period_s_ = 0, rms_s_ = 0;
};

}  // namespace tagtwist::internal

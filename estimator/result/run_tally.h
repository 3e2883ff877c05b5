#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "estimator/result/estimate.h"

namespace tagtwist::internal {

/// 3-D standard deviation of the entries of the error state from `first` on.
double Sigma3(const StateCovariance& covariance, int first);

/// Frames for which something holds, one after the other.
class StretchTally {
 public:
  void Add(double t_s, bool holds);
  size_t count() const { return count_; }
  /// When it holds, as "12.3 to 13.1 s": the longest three stretches in order of time, and how many
  /// more there are.
  std::string Text() const;

 private:
  struct Stretch {
    double from_s = 0, to_s = 0;
    size_t frames = 0;
  };
  void Close();

  size_t count_ = 0, stretches_ = 0;
  Stretch open_;                  // without frames: none is
  std::vector<Stretch> longest_;  // of those that are closed, the longest first
};

/// Intervals between frames; those much longer than the usual one are gaps.
class StepTally {
 public:
  static constexpr double kGap = 1.6;  // so many usual intervals

  void Add(double from_s, double step_s);
  struct Figures {
    double usual_s = 0;                        // the median, of the first ones where many came
    size_t gaps = 0;                           // intervals that are longer than kGap times that,
    double missing = 0;                        // and how many frames seem to be missing there
    double longest_s = 0, longest_from_s = 0;  // of all
    double mean_s = 0, mean_square_s2 = 0;     // of those that are no gap; about that mean
  };
  std::optional<Figures> Get() const;  // nullopt: there are none

 private:
  void Count(double step_s);
  void TakeUsual();

  std::vector<double> first_;  // until the usual one is known by them
  Figures figures_;
  size_t ordinary_ = 0;
  double off_ = 0, off_squares_ = 0;  // of the ordinary ones, from the usual one
};

/// How much a signal's twists change from one to the next: sums of the squares of second
/// differences over neighbours.
struct TwistChanges {
  double velocity = 0, rate = 0;
  size_t count = 0;
  std::optional<Twist> last, before_last;

  void Add(const std::optional<Twist>& twist);
};

/// Frames that see fewer tags than that.
struct FewTagsTally {
  int fewer_than = 1;
  StretchTally where;
  std::optional<double> worst_m;  // how badly position is known there, 3-D

  void Add(double t_s, const FrameEstimate& frame);
};

/// Frames none of whose tags is in the estimate, though they say, frame after frame along a way
/// that a body can take, that it is elsewhere by far: five and more in a row that both are known
/// of.
struct UnheardTags {
  StretchTally where;

  void Add(double t_s, const FrameEstimate& frame);

 private:
  std::optional<Pose> last_;  // of the frame before, where it is one of them
  double last_s_ = 0;
  size_t in_a_row_ = 0;
};

/// A trajectory among the frames.
struct SeriesTally {
  size_t frames = 0;
  TwistChanges changes;
};

/// What the frames of an estimate are, counted one by one as they come: memory does not grow with
/// them.
struct FrameTally {
  size_t frames = 0, with_state = 0, with_tags = 0;
  size_t before_first_tag = 0;  // and without a state
  std::array<size_t, 5> by_status = {};
  int64_t first_ns = 0, last_ns = 0;
  StretchTally without_state, ambiguous, open_turns, hurried;
  std::array<FewTagsTally, 2> few_tags = {{{1, {}, {}}, {2, {}, {}}}};
  UnheardTags unheard;
  double worst_ambiguous_m = 0;  // how badly position is known there, 3-D
  StepTally steps;
  /// Of neighbours that both have a state: |change|^2 of v_world and omega_body, and time [s].
  double velocity_changes = 0, rate_changes = 0, changes_s = 0;
  SeriesTally estimated;
  std::array<SeriesTally, 3> closed_form;  // plain, RANSAC, low-pass

  void Add(const FrameEstimate& frame);
  size_t count(FrameStatus status) const { return by_status[static_cast<size_t>(status)]; }

 private:
  void AddNeighbours(const FrameEstimate& frame, double t_s);

  std::optional<BodyState> last_state_;
};

/// Of all frames, and of the same at the window's lag.
struct RunTally {
  FrameTally frames, lagged;
};

/// Of all frames of an estimate: `all`, where it has but some of them (RunFacts).
RunTally TallyOf(const Estimate& estimate, const RunTally* all = nullptr);

}  // namespace tagtwist::internal

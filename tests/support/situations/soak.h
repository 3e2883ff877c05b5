#pragma once
#include <cstdint>
#include <deque>
#include <string>

#include "estimator/graph/graph_builder.h"
#include "estimator/window/window_output.h"
#include "tests/support/situations/phantoms.h"

namespace tagtwist::internal {

/// What begins to happen to a body over the course's mat, every hundred frames.
enum class SoakEvent {
  kRest,
  kStart,
  kGap,         // no tags, for 0.1 to 3 s
  kPhantoms,    // a burst of random quads with ids of the map
  kCutTags,     // corners bent inwards, as by a hand
  kClockStep,   // the stamps jump ahead
  kKidnapping,  // carried elsewhere between two frames
  kSpin,        // a whole turn
};
constexpr int kSoakEvents = 8;
std::string NameOf(SoakEvent event);

struct SoakFrame {
  FrameMeasurements measurement;
  BodyState truth;
  SoakEvent event = SoakEvent::kRest;  // the latest
};

/// A flight without end at 30 Hz, corners with 0.2 px of noise: a frame is made when it is asked
/// for, none is kept.
class SoakFlight {
 public:
  explicit SoakFlight(unsigned seed);
  const EstimatorSetup& setup() const { return setup_; }
  SoakFrame Next();

 private:
  // A quantity that goes from one value to another within some time, smoothly.
  struct Change {
    double from = 0, to = 0, begin_s = 0, length_s = 1;
    double At(double t) const;
    double Integral(double t) const;  // since begin_s
  };
  void Happen(double t);
  double PhaseAt(double t) const;
  Pose PoseAt(double t) const;
  BodyState StateAt(double t) const;
  std::vector<TagDetection> See(const Pose& world_from_body);

  EstimatorSetup setup_;
  Rng rng_;
  int64_t frame_ = 0;
  int64_t stepped_ns_ = 0;  // by the clock, in all
  SoakEvent event_ = SoakEvent::kStart;
  int left_ = 0;        // frames of a gap, or of spoilt tags
  Change speed_, yaw_;  // of the phase; [rad]
  double phase_ = 0;    // when speed_ began to change
  Eigen::Vector3d place_ = Eigen::Vector3d(0.9, 0.9, 1.1);
};

/// How an endless run goes.
struct SoakScore {
  size_t frames = 0, without = 0;  // judged; with two tags and no state
  size_t beyond = 0;               // beyond 5 sigma in attitude, position, velocity or rate
  size_t beyond_after[kSoakEvents] = {};
  double Share() const {
    return frames == 0 ? 0 : static_cast<double>(beyond) / static_cast<double>(frames);
  }
};

/// Judges states by the exact truth as they come, at their arrival and at the lag; keeps no more
/// than the frames whose lagged states are still to come.
class SoakJudge {
 public:
  void Add(const SoakFrame& frame, const WindowOutput& output);
  void AddLagged(const std::vector<FrameEstimate>& frames);
  const SoakScore& current() const { return current_; }
  const SoakScore& lagged() const { return lagged_; }

 private:
  std::deque<SoakFrame> pending_;
  SoakScore current_, lagged_;
};

}  // namespace tagtwist::internal

#include "tests/support/situations/soak.h"

#include <algorithm>
#include <cmath>

#include "tests/support/flights/exact_model.h"
#include "tests/support/flights/tag_scene.h"
#include "tests/support/situations/situations.h"

namespace tagtwist::internal {
namespace {

constexpr double kRateHz = 30, kWholeTurn = 6.283185307179586;
constexpr int kFramesOfAnEvent = 100;

void BendACorner(Rng* rng, TagDetection* tag) {
  const auto c = static_cast<size_t>(Draw(rng, 0, 3.999));
  const Eigen::Vector2d centre =
      0.25 * (tag->corners[0] + tag->corners[1] + tag->corners[2] + tag->corners[3]);
  const Eigen::Vector2d inwards = (centre - tag->corners[c]).normalized();
  tag->corners[c] += Draw(rng, 2, 12) * inwards;
}

void Judge(const SoakFrame& frame, const FrameEstimate& estimate, SoakScore* score) {
  if (estimate.status == FrameStatus::kNoFix) {
    if (frame.measurement.tags.size() > 1) ++score->without;
    return;
  }
  ++score->frames;
  if (!IsBeyondFiveSigma(frame.truth, estimate)) return;
  ++score->beyond;
  ++score->beyond_after[static_cast<size_t>(frame.event)];
}

}  // namespace

std::string NameOf(SoakEvent event) {
  const char* const names[] = {"rest",     "start",      "gap",        "phantoms",
                               "cut tags", "clock step", "kidnapping", "spin"};
  return names[static_cast<size_t>(event)];
}

// The polynomial of fifth degree whose first two derivatives vanish at both ends.
double SoakFlight::Change::At(double t) const {
  const double x = std::clamp((t - begin_s) / length_s, 0.0, 1.0);
  return from + (to - from) * x * x * x * (10 - 15 * x + 6 * x * x);
}

double SoakFlight::Change::Integral(double t) const {
  const double x = std::clamp((t - begin_s) / length_s, 0.0, 1.0);
  const double step = x * x * x * x * (2.5 - 3 * x + x * x);
  const double after = std::max(0.0, t - begin_s - length_s);
  return length_s * (from * x + (to - from) * step) + to * after;
}

SoakFlight::SoakFlight(unsigned seed) : setup_(CourseSetup()), rng_(seed) {}

void SoakFlight::Happen(double t) {
  event_ = static_cast<SoakEvent>(static_cast<int>(Draw(&rng_, 0, kSoakEvents - 1e-9)));
  const auto change_speed = [&](double to) {
    phase_ = PhaseAt(t);
    speed_ = {speed_.At(t), to, t, Draw(&rng_, 0.3, 1.5)};
  };
  left_ = 0;
  switch (event_) {
    case SoakEvent::kRest:
      change_speed(0);
      break;
    case SoakEvent::kStart:
      change_speed(Draw(&rng_, 0.5, 1.5));
      break;
    case SoakEvent::kGap:
      left_ = static_cast<int>(Draw(&rng_, 3, 90));
      break;
    case SoakEvent::kPhantoms:
    case SoakEvent::kCutTags:
      left_ = 20;
      break;
    case SoakEvent::kClockStep:
      stepped_ns_ += static_cast<int64_t>(Draw(&rng_, 0.05e9, 1e9));
      break;
    case SoakEvent::kKidnapping:
      place_ = {Draw(&rng_, 0.6, 1.2), Draw(&rng_, 0.6, 1.2), Draw(&rng_, 0.9, 1.3)};
      yaw_.from = yaw_.to = Draw(&rng_, 0, kWholeTurn);
      break;
    case SoakEvent::kSpin:
      yaw_ = {yaw_.to, yaw_.to + kWholeTurn, t, Draw(&rng_, 1.5, 3)};
      break;
  }
}

double SoakFlight::PhaseAt(double t) const { return phase_ + speed_.Integral(t); }

Pose SoakFlight::PoseAt(double t) const {
  const double phase = PhaseAt(t);
  const Eigen::Vector3d sway(0.15 * std::sin(1.7 * phase), 0.12 * std::sin(2.3 * phase + 1),
                             0.08 * std::sin(1.1 * phase));
  return Hover(place_ + sway, yaw_.At(t) + 0.3 * std::sin(0.9 * phase),
               {0.05 * std::sin(1.9 * phase), 0.06 * std::sin(1.3 * phase + 2), 0});
}

BodyState SoakFlight::StateAt(double t) const {
  return StateAlong([this](double at) { return PoseAt(at); }, t);
}

std::vector<TagDetection> SoakFlight::See(const Pose& world_from_body) {
  std::vector<TagDetection> tags =
      SeeTags(setup_.map, setup_.camera, setup_.cam_from_body * Inverse(world_from_body), 0.2,
              static_cast<unsigned>(rng_()));
  if (left_ <= 0) return tags;
  --left_;
  if (event_ == SoakEvent::kGap) return {};
  if (event_ == SoakEvent::kPhantoms) {
    tags.resize(std::min<size_t>(tags.size(), 4));
    if (Draw(&rng_, 0, 1) < 0.3) AddPhantom(setup_.map, &rng_, &tags);
  } else {
    tags.resize(std::min<size_t>(tags.size(), 6));
    for (size_t i = 0; i < std::min<size_t>(tags.size(), 2); ++i) BendACorner(&rng_, &tags[i]);
  }
  return tags;
}

SoakFrame SoakFlight::Next() {
  const double t = static_cast<double>(frame_) / kRateHz;
  if (frame_ > 0 && frame_ % kFramesOfAnEvent == 0) Happen(t);
  SoakFrame out;
  out.truth = StateAt(t);
  out.event = event_;
  out.measurement.t_ns =
      1'000'000'000 + stepped_ns_ + std::llround(1e9 * static_cast<double>(frame_) / kRateHz);
  out.measurement.tags = See(out.truth.world_from_body);
  ++frame_;
  return out;
}

void SoakJudge::Add(const SoakFrame& frame, const WindowOutput& output) {
  Judge(frame, output.current, &current_);
  pending_.push_back(frame);
  AddLagged(output.lagged);
}

void SoakJudge::AddLagged(const std::vector<FrameEstimate>& frames) {
  for (const FrameEstimate& frame : frames) {
    while (!pending_.empty() && pending_.front().measurement.t_ns < frame.t_ns) {
      pending_.pop_front();
    }
    if (pending_.empty() || pending_.front().measurement.t_ns != frame.t_ns) continue;
    Judge(pending_.front(), frame, &lagged_);
    pending_.pop_front();
  }
}

}  // namespace tagtwist::internal

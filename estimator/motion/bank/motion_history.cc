#include "estimator/motion/bank/motion_history.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace tagtwist::internal {
namespace {

// A jump may have been in the next interval as well: beside a livelier one each is as lively as the
// geometric mean of both.
std::vector<MotionBanks::Densities> WithNeighbours(const std::vector<MotionBanks::Densities>& in) {
  std::vector<MotionBanks::Densities> out = in;
  const auto raise = [&](size_t k, size_t beside) {
    out[k].linear = std::max(out[k].linear, std::sqrt(in[k].linear * in[beside].linear));
    out[k].angular = std::max(out[k].angular, std::sqrt(in[k].angular * in[beside].angular));
  };
  for (size_t k = 1; k < in.size(); ++k) {
    raise(k - 1, k);
    raise(k, k - 1);
  }
  return out;
}

// A body that turns as it moves may keep the tag where it was in view: what either shows, turning
// about the line of sight and moving along it included, the other may have, too, at that distance.
// Neither is known to be less than what frames of that span do not resolve: a density under which
// they are smoothed over longer, (R dt / q)^(1/6) for white noise on jerk.
MotionBanks::Densities MayBeOfTag(MotionBanks::Densities shown, const PoseMeasurement& tag,
                                  double dt_s, double span_s) {
  const double lever2_m2 = tag.world_from_body.translation().squaredNorm();
  shown.linear /= 2, shown.angular /= 2;
  shown.angular = std::max(shown.angular, tag.open_rad2 * dt_s / std::pow(span_s, 6));
  shown.linear = std::max(shown.linear, lever2_m2 * shown.angular);
  shown.angular = std::max(shown.angular, shown.linear / lever2_m2);
  return shown;
}

}  // namespace

MotionHistory::MotionHistory(const NoiseModel& noise, bool keeps_past)
    : keeps_past_(keeps_past),
      now_(MotionBanks(noise.linear, noise.angular)),
      fresh_(now_.banks),
      rivals_{{1, FollowingBanks(UnderOneDensity(noise.linear, noise.angular))},
              {0.1, FollowingBanks(UnderOneDensity(noise.linear, noise.angular))}} {}

void MotionHistory::TakeShakes(const NoiseModel& noise) {
  for (MotionBanks* banks :
       {&now_.banks, &fresh_, &rivals_[0].single.banks, &rivals_[1].single.banks}) {
    banks->SetShakes(noise.linear.shake_s, noise.angular.shake_s);
  }
}

void MotionHistory::Compare(const NoiseModel& noise, const Frame& frame) {
  static constexpr double kFade = 1 - 1.0 / 100, kMost = 40;
  const PartLikelihoods bank = now_.banks.log_likelihoods();
  const auto part = [](double advantage, double by) {
    return std::clamp(kFade * advantage + by, -kClearly, kMost);
  };
  MotionBanks::Densities densities{noise.linear.psd, noise.angular.psd};
  if (frame.tag) {  // it shows the sum of both
    const double lever2_m2 = frame.pose->world_from_body.translation().squaredNorm();
    densities = {densities.linear + lever2_m2 * densities.angular,
                 densities.angular + densities.linear / lever2_m2};
  }
  for (Rival& rival : rivals_) {
    if (!rival.single.IsOf(frame.tag)) {
      rival.single.Follow(frame.tag, UnderOneDensity(noise.linear, noise.angular));
    }
    MotionBanks& single = rival.single.banks;
    single.SetDensities({rival.share * densities.linear, rival.share * densities.angular});
    single.Predict(frame.t_ns);
    single.Measure(*frame.pose);
    const PartLikelihoods of_single = single.log_likelihoods();
    rival.advantage = {part(rival.advantage.linear, bank.linear - of_single.linear),
                       part(rival.advantage.angular, bank.angular - of_single.angular)};
  }
}

bool MotionHistory::LinearVaries() const {
  return std::all_of(rivals_.begin(), rivals_.end(),
                     [](const Rival& rival) { return rival.advantage.linear > kClearly; });
}

bool MotionHistory::AngularVaries() const {
  return std::all_of(rivals_.begin(), rivals_.end(),
                     [](const Rival& rival) { return rival.advantage.angular > kClearly; });
}

MotionHistory::Shares MotionHistory::ShareOfBank() const {
  constexpr double kUnlikely = 1;  // before anything is seen, in the logarithm of the odds
  Shares out;
  for (const Rival& rival : rivals_) {
    out.linear = std::min(out.linear, 1 / (1 + std::exp(kUnlikely - rival.advantage.linear)));
    out.angular = std::min(out.angular, 1 / (1 + std::exp(kUnlikely - rival.advantage.angular)));
  }
  return out;
}

// What the frame's tags say of the motion: the pose that they agree upon, or where a lone tag lies
// that has been alone for some frames in a row. In batch, which tells turning from moving by longer
// (turn_or_move.h), a bank over such tags claims rest too surely before a push.
void MotionHistory::TakeWhatIsShown(const EstimatorSetup& setup, double corner_sigma_px,
                                    const GraphFrame& frame, Frame* out) {
  constexpr int kFramesInARow = 5;
  const Pose& start = frame.state.world_from_body;
  const std::optional<int> lone = LoneTag(frame.tags);
  auto shown = lone ? MotionShownByLoneTag(setup, corner_sigma_px, frame.tags, start)
                    : PoseOfTags(setup, corner_sigma_px, frame.tags, start);
  if (!lone && shown && !shown->is_consensus) shown.reset();
  in_a_row_ = shown && lone == lone_before_ ? in_a_row_ + 1 : shown ? 1 : 0;
  lone_before_ = lone;
  if (lone && !(keeps_past_ && (in_a_row_ >= kFramesInARow || now_.Follows(*lone)))) return;
  out->pose = shown;
  out->tag = lone;
}

void MotionHistory::Add(const EstimatorSetup& setup, const NoiseModel& noise,
                        const GraphFrame& frame) {
  Frame out;
  out.t_ns = frame.t_ns;
  out.breaks = frame.motion.breaks;
  TakeWhatIsShown(setup, noise.corner_sigma_px, frame, &out);
  TakeShakes(noise);
  if (out.breaks) now_.StartAnew(fresh_);
  if (out.pose) {
    now_.Follow(out.tag, fresh_);
    MotionBanks& banks = now_.banks;
    const bool is_first = !banks.is_measured();
    banks.Predict(frame.t_ns);
    if (keeps_past_ && !is_first) out.past = banks.prediction();
    banks.Measure(*out.pose);
    Compare(noise, out);
  }
  frames_.push_back(std::move(out));
}

double MotionHistory::SpanS() const {
  return ToSeconds(frames_.back().t_ns - frames_.front().t_ns);
}

double MotionHistory::MeanStepS() const {
  return SpanS() / static_cast<double>(frames_.size() - 1);
}

const MotionBanks::Prediction* MotionHistory::LastPrediction() const {
  if (frames_.empty() || frames_.back().past.linear.empty()) return nullptr;
  return &frames_.back().past;
}

PartLikelihoods MotionHistory::Likelihoods(MotionBanks bank) const {
  const MotionBanks fresh = bank;
  FollowingBanks following(std::move(bank));
  PartLikelihoods out;
  for (const Frame& frame : frames_) {
    if (frame.breaks) following = FollowingBanks(fresh);
    if (!frame.pose) continue;
    following.Follow(frame.tag, fresh);
    following.banks.Predict(frame.t_ns);
    following.banks.Measure(*frame.pose);
    out.linear += following.banks.log_likelihoods().linear;
    out.angular += following.banks.log_likelihoods().angular;
  }
  return out;
}

// One frame further back: its density, where `past` tells what is known of it from before.
void MotionHistory::TellBackwards(size_t k, const MotionBanks::Prediction& past,
                                  FollowingBanks* backwards,
                                  std::vector<MotionBanks::Densities>* out) const {
  const Frame& frame = frames_[k];
  const bool is_known = frame.pose && !past.linear.empty();
  if (frame.pose) {
    backwards->Follow(frame.tag, fresh_);
    backwards->banks.Predict(frame.t_ns);
    backwards->banks.Measure(*frame.pose);
  }
  if (is_known) {
    (*out)[k] = backwards->banks.DensitiesAfter(past);
    if (frame.tag) (*out)[k] = MayBeOfTag((*out)[k], *frame.pose, MeanStepS(), SpanS());
  } else if (k + 1 < frames_.size()) {
    (*out)[k] = (*out)[k + 1];
  } else if (frame.tag) {
    (*out)[k] = {0, 0};  // it has shown nothing yet
  }
  if (!frame.breaks) return;
  (*out)[k] = {0, 0};  // raises no neighbour's
  backwards->StartAnew(fresh_);
}

// What is known of the frames of a stretch from their past, `following` being just before it and,
// in the end, after it.
std::vector<MotionBanks::Prediction> MotionHistory::PastOf(size_t first, size_t end,
                                                           FollowingBanks* following) const {
  std::vector<MotionBanks::Prediction> out(end - first);
  for (size_t k = first; k < end; ++k) {
    const Frame& frame = frames_[k];
    if (frame.breaks) following->StartAnew(fresh_);
    if (!frame.pose) continue;
    following->Follow(frame.tag, fresh_);
    MotionBanks& banks = following->banks;
    const bool is_first = !banks.is_measured();
    banks.Predict(frame.t_ns);
    if (!is_first) out[k - first] = banks.prediction();
    banks.Measure(*frame.pose);
  }
  return out;
}

std::vector<MotionBanks::Densities> MotionHistory::FromBothSides(const MotionParts& wanted) const {
  std::vector<MotionBanks::Densities> out(frames_.size(), banks().densities());
  FollowingBanks backwards(fresh_);
  backwards.banks.FollowOnly(wanted);
  backwards.banks.SetWeights(banks().weights());  // the future goes on as the present is
  if (keeps_past_) {
    for (size_t k = frames_.size(); k-- > 0;) {
      TellBackwards(k, frames_[k].past, &backwards, &out);
    }
  } else {
    // All that is known from the past at each of many frames is a lot to hold: it is made again,
    // stretch by stretch.
    constexpr size_t kStretch = 64;
    std::vector<FollowingBanks> before;  // each stretch
    FollowingBanks following(fresh_);
    following.banks.FollowOnly(wanted);
    for (size_t first = 0; first < frames_.size(); first += kStretch) {
      before.push_back(following);
      PastOf(first, std::min(first + kStretch, frames_.size()), &following);
    }
    for (size_t i = before.size(); i-- > 0;) {
      const size_t first = i * kStretch;
      const auto past = PastOf(first, std::min(first + kStretch, frames_.size()), &before[i]);
      for (size_t j = past.size(); j-- > 0;) {
        TellBackwards(first + j, past[j], &backwards, &out);
      }
      before.pop_back();
    }
  }
  if (out.size() > 1) out[0] = out[1];
  return WithNeighbours(out);
}

}  // namespace tagtwist::internal

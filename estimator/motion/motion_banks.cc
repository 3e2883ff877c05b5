#include "estimator/motion/motion_banks.h"

#include <algorithm>
#include <cmath>

#include "estimator/motion/interval_classes.h"
#include "frontend/types/so3.h"

namespace tagtwist::internal {

MotionBanks::MotionBanks(const MotionPrior& linear, const MotionPrior& angular)
    : MotionBanks(LinearBankOptions(linear.on), AngularBankOptions(angular.on)) {
  SetShakes(linear.shake_s, angular.shake_s);
}

MotionBanks::MotionBanks(const MotionBankOptions& linear, const MotionBankOptions& angular)
    : linear_(linear), angular_(angular) {}

MotionBanks::Prediction MotionBanks::prediction() const {
  constexpr double kLeastWeight = 1e-5;
  return {linear_.Classes(kLeastWeight), angular_.Classes(kLeastWeight), reference_, dt_s_};
}

MotionBanks::Densities MotionBanks::DensitiesAfter(const Prediction& past) const {
  constexpr double kLeastWeight = 1e-4, kKeepS = 30;
  const double keep = std::exp(-past.dt_s / kKeepS);
  const auto of = [keep](const std::vector<MotionBank::Class>& before, const MotionBank& after,
                         const Eigen::Vector3d& origin) {
    return after.DensityOf(WeightsFromBothSides(before,
                                                InForwardTime(after.Classes(kLeastWeight), origin),
                                                after.options().on, keep, after.size()));
  };
  const Pose& then = past.reference;
  Densities out;
  if (follows_.linear) out.linear = of(past.linear, linear_, Eigen::Vector3d::Zero());
  if (follows_.angular) {
    out.angular =
        of(past.angular, angular_, LogSo3(then.rotation().conjugate() * reference_.rotation()));
  }
  return out;
}

// The reference turns as the mean does; what the classes know of the attitude turns with it.
void MotionBanks::PredictBy(double dt_s) {
  if (follows_.linear) linear_.Predict(dt_s);
  if (!follows_.angular) return;
  const MotionBank::State mean = angular_.Mean();
  const Eigen::Vector3d turn = mean.segment<3>(3) * dt_s + 0.5 * dt_s * dt_s * mean.segment<3>(6);
  angular_.TurnOrigin(ExpSo3(-turn).toRotationMatrix());
  angular_.Predict(dt_s);
  const Eigen::Vector3d moved = angular_.Mean().head<3>();
  angular_.MoveOrigin(moved);
  reference_ = MakePose(reference_.rotation() * ExpSo3(moved), reference_.translation());
}

void MotionBanks::Predict(int64_t t_ns) {
  dt_s_ = std::abs(ToSeconds(t_ns - last_ns_));
  if (is_measured()) PredictBy(dt_s_);
  last_ns_ = t_ns;
}

void MotionBanks::Measure(const PoseMeasurement& pose) {
  const Pose& measured = pose.world_from_body;
  if (!is_measured()) reference_ = measured;
  ++n_measured_;
  if (follows_.linear) linear_.Measure(measured.translation(), pose.position_covariance);
  if (!follows_.angular) return;
  angular_.Measure(LogSo3(reference_.rotation().conjugate() * measured.rotation()),
                   pose.attitude_covariance);
  const Eigen::Vector3d off = angular_.Mean().head<3>();
  angular_.MoveOrigin(off);
  reference_ = MakePose(reference_.rotation() * ExpSo3(off), measured.translation());
}

PartLikelihoods MotionBanks::log_likelihoods() const {
  if (n_measured_ < 2) return {};
  return {linear_.log_likelihood(), angular_.log_likelihood()};
}

void MotionBanks::SetWeights(const Weights& weights) {
  linear_.SetWeights(weights.linear);
  angular_.SetWeights(weights.angular);
}

void MotionBanks::SetShakes(double linear_s, double angular_s) {
  linear_.SetShake(linear_s);
  angular_.SetShake(angular_s);
}

StateVector MotionBanks::ExcessVariances() const {
  const Eigen::Vector2d linear = linear_.ExcessVariance(), angular = angular_.ExcessVariance();
  StateVector out;
  out.segment<3>(0).setConstant(angular(0));
  out.segment<3>(3).setConstant(linear(0));
  out.segment<3>(6).setConstant(linear(1));
  out.segment<3>(9).setConstant(angular(1));
  return out;
}

MotionBanks UnderOneDensity(const MotionPrior& linear, const MotionPrior& angular) {
  const auto one = [](MotionBankOptions options, const MotionPrior& prior) {
    options.classes = 1;
    options.shake_s = prior.shake_s;
    options.least_density = prior.psd;
    return options;
  };
  return {one(LinearBankOptions(linear.on), linear), one(AngularBankOptions(angular.on), angular)};
}

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

}  // namespace

MotionHistory::MotionHistory(const NoiseModel& noise, bool keeps_past)
    : keeps_past_(keeps_past),
      banks_(noise.linear, noise.angular),
      fresh_(banks_),
      rivals_{{1, UnderOneDensity(noise.linear, noise.angular)},
              {0.1, UnderOneDensity(noise.linear, noise.angular)}} {}

void MotionHistory::TakeShakes(const NoiseModel& noise) {
  for (MotionBanks* banks : {&banks_, &fresh_, &rivals_[0].single, &rivals_[1].single}) {
    banks->SetShakes(noise.linear.shake_s, noise.angular.shake_s);
  }
}

void MotionHistory::Compare(const MotionBanks::Densities& densities, const Frame& frame) {
  static constexpr double kFade = 1 - 1.0 / 100, kMost = 40;
  const PartLikelihoods bank = banks_.log_likelihoods();
  const auto part = [](double advantage, double by) {
    return std::clamp(kFade * advantage + by, -kClearly, kMost);
  };
  for (Rival& rival : rivals_) {
    rival.single.SetDensities({rival.share * densities.linear, rival.share * densities.angular});
    rival.single.Predict(frame.t_ns);
    rival.single.Measure(*frame.pose);
    const PartLikelihoods single = rival.single.log_likelihoods();
    rival.advantage = {part(rival.advantage.linear, bank.linear - single.linear),
                       part(rival.advantage.angular, bank.angular - single.angular)};
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

// Whether it shows the map's only tag, as the frame before did: nothing else tells of the motion
// there, and no other tag can be meant. In batch, where one tag ties turning to moving
// (turn_or_move.h), densities of their own for both claim too much.
bool MotionHistory::GoesOn(const EstimatorSetup& setup, const GraphFrame& frame) {
  const bool shows = frame.tags.size() == 1 && setup.map.tags().size() == 1;
  const bool goes_on = shows && shown_before_ && keeps_past_;
  shown_before_ = shows;
  return goes_on;
}

void MotionHistory::Add(const EstimatorSetup& setup, const NoiseModel& noise,
                        const GraphFrame& frame) {
  Frame out{frame.t_ns,
            PoseOfTags(setup, noise.corner_sigma_px, frame.tags, frame.state.world_from_body),
            frame.motion.breaks,
            {}};
  const bool goes_on = GoesOn(setup, frame);
  TakeShakes(noise);
  if (out.pose && !out.pose->is_consensus && !(goes_on && out.pose->fits)) out.pose.reset();
  if (out.breaks) banks_ = Anew(banks_);
  if (out.pose) {
    const bool is_first = !banks_.is_measured();
    banks_.Predict(frame.t_ns);
    if (keeps_past_ && !is_first) out.past = banks_.prediction();
    banks_.Measure(*out.pose);
    Compare({noise.linear.psd, noise.angular.psd}, out);
  }
  frames_.push_back(std::move(out));
}

const MotionBanks::Prediction* MotionHistory::LastPrediction() const {
  if (frames_.empty() || frames_.back().past.linear.empty()) return nullptr;
  return &frames_.back().past;
}

MotionBanks MotionHistory::Anew(const MotionBanks& from) const {
  MotionBanks out = fresh_;
  out.SetWeights(from.weights());
  out.FollowOnly(from.follows());
  return out;
}

PartLikelihoods MotionHistory::Likelihoods(MotionBanks bank) const {
  const MotionBanks start = bank;
  PartLikelihoods out;
  for (const Frame& frame : frames_) {
    if (frame.breaks) bank = start;
    if (!frame.pose) continue;
    bank.Predict(frame.t_ns);
    bank.Measure(*frame.pose);
    out.linear += bank.log_likelihoods().linear;
    out.angular += bank.log_likelihoods().angular;
  }
  return out;
}

// One frame further back: its density, where `past` tells what is known of it from before.
void MotionHistory::TellBackwards(size_t k, const MotionBanks::Prediction& past,
                                  MotionBanks* backwards,
                                  std::vector<MotionBanks::Densities>* out) const {
  if (frames_[k].pose) {
    backwards->Predict(frames_[k].t_ns);
    backwards->Measure(*frames_[k].pose);
    if (!past.linear.empty()) (*out)[k] = backwards->DensitiesAfter(past);
  } else if (k + 1 < frames_.size()) {
    (*out)[k] = (*out)[k + 1];
  }
  if (!frames_[k].breaks) return;
  (*out)[k] = {0, 0};  // raises no neighbour's
  *backwards = Anew(*backwards);
}

// What is known of the frames of a stretch from their past, `banks` being just before it and, in
// the end, after it.
std::vector<MotionBanks::Prediction> MotionHistory::PastOf(size_t first, size_t end,
                                                           MotionBanks* banks) const {
  std::vector<MotionBanks::Prediction> out(end - first);
  for (size_t k = first; k < end; ++k) {
    if (frames_[k].breaks) *banks = Anew(*banks);
    if (!frames_[k].pose) continue;
    const bool is_first = !banks->is_measured();
    banks->Predict(frames_[k].t_ns);
    if (!is_first) out[k - first] = banks->prediction();
    banks->Measure(*frames_[k].pose);
  }
  return out;
}

std::vector<MotionBanks::Densities> MotionHistory::FromBothSides(const MotionParts& wanted) const {
  std::vector<MotionBanks::Densities> out(frames_.size(), banks_.densities());
  MotionBanks backwards = fresh_;
  backwards.FollowOnly(wanted);
  backwards.SetWeights(banks_.weights());  // the future goes on as the present is
  if (keeps_past_) {
    for (size_t k = frames_.size(); k-- > 0;) {
      TellBackwards(k, frames_[k].past, &backwards, &out);
    }
  } else {
    // All that is known from the past at each of many frames is a lot to hold: it is made again,
    // stretch by stretch.
    constexpr size_t kStretch = 64;
    std::vector<MotionBanks> before;  // each stretch
    MotionBanks banks = fresh_;
    banks.FollowOnly(wanted);
    for (size_t first = 0; first < frames_.size(); first += kStretch) {
      before.push_back(banks);
      PastOf(first, std::min(first + kStretch, frames_.size()), &banks);
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

#include "estimator/solve/frame_chain.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <utility>

#include "estimator/graph/noise_model.h"
#include "estimator/solve/banded_solver.h"

namespace tagtwist {
namespace {

constexpr int kSize = BlockBandedMatrix::kSize;
using Residual8 = Eigen::Matrix<double, 8, 1>;
using Jacobian8 = Eigen::Matrix<double, 8, 6>;

// Whether any corner in the frames has a covariance that counts.
bool HasOwnCovariances(const EstimatorSetup& setup, const GraphInput& input) {
  if (setup.options.corner_sigma_px) return false;
  for (const GraphFrame& frame : input.frames) {
    for (const TagDetection& tag : frame.tags) {
      if (tag.covariance) return true;
    }
  }
  return false;
}

}  // namespace

bool FrameChain::Fits(const EstimatorSetup& setup, const GraphInput& input) {
  if (input.prior) return false;
  return input.segments.empty() || !setup.options.use_tracks;
}

FrameChain::FrameChain(const EstimatorSetup& setup, const GraphInput& input)
    : setup_(setup),
      input_(input),
      has_own_covariances_(HasOwnCovariances(setup, input)),
      forms_(input.frames.size()),
      huber_delta_(TagHuberDelta(setup)) {
  for (const GraphFrame& frame : input.frames) {
    states_.push_back(ToGraphState(frame.t_ns, frame.state, frame.acceleration));
  }
}

void FrameChain::MakeTags(double sigma_px) {
  tags_.clear();
  first_tag_ = {0};
  TagObservation observation;
  for (const GraphFrame& frame : input_.frames) {
    for (const TagDetection& tag : frame.tags) {
      observation.corners_in_world = setup_.map.CornersInWorld(tag.id);
      observation.pixels = tag.corners;
      observation.covariance = CornerCovariance(setup_, tag, sigma_px);
      tags_.emplace_back(observation, setup_);
    }
    first_tag_.push_back(tags_.size());
  }
}

FrameChain::TagRange FrameChain::TagsOf(size_t k) const {
  const auto at = [this](size_t i) {
    return tags_.begin() + static_cast<std::ptrdiff_t>(first_tag_[i]);
  };
  return {at(k), at(k + 1)};
}

void FrameChain::SetNoise(const NoiseModel& noise) {
  const bool is_first = !noise_;
  const bool other_sigma = is_first || noise.corner_sigma_px != noise_->corner_sigma_px;
  noise_ = noise;
  motions_.clear();
  for (size_t k = 0; k + 1 < states_.size(); ++k) {
    motions_.emplace_back(ToSeconds(states_[k + 1].t_ns - states_[k].t_ns), noise.linear,
                          noise.angular);
  }
  GraphInput first;
  first.frames = {input_.frames.front()};
  first.frames.front().tags.clear();
  first_ = BuildGraph(setup_, noise, first);
  if (!other_sigma) return;
  if (has_own_covariances_) {
    MakeTags(noise.corner_sigma_px);
  } else {
    unit_ = 1 / (noise.corner_sigma_px * noise.corner_sigma_px);
    if (is_first) MakeTags(1);
  }
  for (size_t k = 0; k < forms_.size(); ++k) {
    const double limit = huber_delta_ * huber_delta_ / unit_;
    const TagRange tags = TagsOf(k);
    const bool keeps = !is_first && !has_own_covariances_ && !forms_[k].is_robust &&
                       std::all_of(tags.begin(), tags.end(), [limit](const SeenTag& tag) {
                         return tag.squared_norm <= limit;
                       });
    if (!keeps)
      forms_[k].reference.params.setConstant(
          std::numeric_limits<double>::quiet_NaN());  // to be linearised
  }
}

FrameChain::Vector6 FrameChain::MovedFromReference(size_t k) const {
  return Difference(states_[k].pose, forms_[k].reference);
}

bool FrameChain::LinearizeTags(size_t k) {
  Form& form = forms_[k];
  form.reference = states_[k].pose;
  form.hessian.setZero();
  form.gradient.setZero();
  form.cost = 0;
  form.is_robust = false;
  const double delta = huber_delta_ / std::sqrt(unit_);
  Residual8 residual;
  Jacobian8 jacobian;
  for (size_t i = first_tag_[k]; i < first_tag_[k + 1]; ++i) {
    SeenTag& tag = tags_[i];
    if (!tag.residual.Linearize(form.reference.params.data(), &residual, &jacobian)) return false;
    tag.squared_norm = residual.squaredNorm();
    if (tag.squared_norm > delta * delta) {
      const double norm = std::sqrt(tag.squared_norm), weight = delta / norm;
      form.is_robust = true;
      form.cost += delta * norm - 0.5 * delta * delta;
      residual *= std::sqrt(weight);
      jacobian *= std::sqrt(weight);
    } else {
      form.cost += 0.5 * tag.squared_norm;
    }
    form.hessian += jacobian.transpose().lazyProduct(jacobian);
    form.gradient += jacobian.transpose().lazyProduct(residual);
  }
  return true;
}

bool FrameChain::LinearizeWhatMoved(double neglected) {
  std::atomic<bool> all_seen{true};
  setup_.for_ranges(forms_.size(), [&](size_t first, size_t last) {
    for (size_t k = first; k < last; ++k) {
      const Vector6 moved = MovedFromReference(k);
      const double sigmas = std::sqrt(unit_ * moved.dot(forms_[k].hessian * moved));
      const bool holds = moved.isZero(0) || moved.norm() * sigmas <= neglected;  // false where NaN
      if (!holds && !LinearizeTags(k)) all_seen = false;
    }
  });
  return all_seen;
}

void FrameChain::LinearizeMotion(size_t k, Eigen::Matrix<double, 18, 1>* residual,
                                 Eigen::Matrix<double, 18, 36>* jacobian) const {
  const GraphState &a = states_[k], &b = states_[k + 1];
  const double* const parameters[] = {a.pose.params.data(), a.rates.data(), b.pose.params.data(),
                                      b.rates.data()};
  motions_[k].Linearize(parameters, residual, jacobian);
}

double FrameChain::AddMotionFrom(size_t k, LinearSystem* out) const {
  Eigen::Matrix<double, 18, 1> residual;
  Eigen::Matrix<double, 18, 36> jacobian;
  LinearizeMotion(k, &residual, &jacobian);
  AddMotion(static_cast<int>(k), residual, jacobian, out);
  return 0.5 * residual.squaredNorm();
}

LinearSystem FrameChain::Assemble() const {
  const int size = static_cast<int>(states_.size());
  LinearSystem out{BlockBandedMatrix(size, std::min(size - 1, 1)),
                   Eigen::VectorXd::Zero(kSize * size), 0, true};
  // A range's last motion reaches into the next range's first state: it is added afterwards. No
  // state gets more than two terms until then, so that their order does not matter.
  std::vector<double> costs(motions_.size());
  std::vector<char> is_last(motions_.size());
  setup_.for_ranges(motions_.size(), [&](size_t first, size_t last) {
    for (size_t k = first; k + 1 < last; ++k) costs[k] = AddMotionFrom(k, &out);
    is_last[last - 1] = true;
  });
  for (size_t k = 0; k < motions_.size(); ++k) {
    out.cost += is_last[k] ? AddMotionFrom(k, &out) : costs[k];
  }
  for (int k = 0; k < size; ++k) {
    const auto i = static_cast<size_t>(k);
    const Form& form = forms_[i];
    const Vector6 moved = MovedFromReference(i), added = form.hessian * moved;
    out.hessian.At(k, k).topLeftCorner<6, 6>() += unit_ * form.hessian;
    out.gradient.segment<6>(kSize * k) += unit_ * (form.gradient + added);
    out.cost += unit_ * (form.cost + moved.dot(form.gradient + 0.5 * added));
  }
  Graph first = first_;
  first.states = {states_.front()};
  const LinearSystem prior = Linearize(first);
  out.hessian.At(0, 0) += prior.hessian.At(0, 0);
  out.gradient.head<kSize>() += prior.gradient;
  out.cost += prior.cost;
  return out;
}

double FrameChain::LogDetInformation() const {
  double sum = 0;
  for (const SeenTag& tag : tags_) sum += tag.residual.LogDetInformation() + 8 * std::log(unit_);
  for (const MotionResidual& motion : motions_) sum += motion.LogDetInformation();
  return 0.5 * sum;
}

std::optional<Solution> FrameChain::Solve(const NoiseModel& noise, const SolveOptions& options,
                                          double neglected) {
  constexpr double kRounding = 1e-9;
  SetNoise(noise);
  if (!LinearizeWhatMoved(neglected)) return std::nullopt;
  double cost_before = std::numeric_limits<double>::max();
  for (int iteration = 1; iteration <= options.max_iterations; ++iteration) {
    LinearSystem system = Assemble();
    // What the forms neglect may show as a rise, too.
    if (!(system.cost <= (1 + kRounding) * cost_before + neglected)) return std::nullopt;
    BlockBandedCholesky cholesky(std::move(system.hessian));
    if (!cholesky.ok()) return std::nullopt;
    const Eigen::VectorXd step = cholesky.Solve(-system.gradient);
    const double expected = -0.5 * system.gradient.dot(step);
    for (size_t k = 0; k < states_.size(); ++k) {
      states_[k] = Retract(states_[k], step.segment<kSize>(kSize * static_cast<Eigen::Index>(k)));
    }
    cost_before = system.cost;
    if (expected <= options.function_tolerance * system.cost + kNoDecrease ||
        IsUp(options.time_up)) {
      Solution out;
      out.graph.states = states_;
      out.cost = system.cost - expected;
      out.log_likelihood = LogDetInformation() - out.cost - 0.5 * cholesky.LogDeterminant();
      out.covariance = std::move(cholesky).SelectedInverse();
      return out;
    }
    if (!LinearizeWhatMoved(neglected)) return std::nullopt;
  }
  return std::nullopt;
}

void FrameChain::AddTagStatistics(size_t k, const BlockBandedMatrix& covariance,
                                  double typical_scale, NoiseStatistics* out) const {
  const Matrix6 pose =
      covariance.At(static_cast<int>(k), static_cast<int>(k)).topLeftCorner<6, 6>();
  const TagRange tags = TagsOf(k);
  const double limit = MostOfInlierTag(typical_scale) / unit_;
  const bool simple = !has_own_covariances_ && !forms_[k].is_robust &&
                      std::all_of(tags.begin(), tags.end(), [limit](const SeenTag& tag) {
                        return tag.squared_norm <= limit;
                      });
  if (simple) {
    for (const SeenTag& tag : tags) out->corner += {tag.squared_norm, 8};
    out->corner.dof -= unit_ * pose.cwiseProduct(forms_[k].hessian).sum();
    return;
  }
  const double s2 = noise_->corner_sigma_px * noise_->corner_sigma_px;
  Residual8 residual;
  Jacobian8 jacobian;
  for (const SeenTag& tag : tags) {
    if (tag.squared_norm > limit) continue;
    tag.residual.Linearize(forms_[k].reference.params.data(), &residual, &jacobian);
    const Eigen::Matrix<double, 8, 8> whitener = std::sqrt(unit_) * tag.residual.whitener();
    out->corner +=
        TagStatistic(whitener, std::sqrt(unit_) * residual, std::sqrt(unit_) * jacobian, pose, s2);
  }
}

void FrameChain::AddMotionStatisticFrom(size_t k, const BlockBandedMatrix& covariance,
                                        NoiseStatistics* out) const {
  if (first_tag_[k] == first_tag_[k + 2]) return;
  LinearFactor linear;
  Eigen::Matrix<double, 18, 1> residual;
  Eigen::Matrix<double, 18, 36> jacobian;
  LinearizeMotion(k, &residual, &jacobian);
  linear.residual = residual;
  linear.jacobian = jacobian;
  AddMotionStatistic(linear, covariance, static_cast<int>(k), *noise_, out);
  out->motion_s += ToSeconds(states_[k + 1].t_ns - states_[k].t_ns);
  ++out->motions;
}

NoiseStatistics FrameChain::Statistics(const BlockBandedMatrix& covariance) {
  NoiseStatistics out;
  if (!LinearizeWhatMoved(0)) return out;
  std::vector<double> norms;
  for (const SeenTag& tag : tags_) norms.push_back(unit_ * tag.squared_norm);
  const double typical_scale = TypicalTagScale(std::move(norms));
  std::vector<NoiseStatistics> of_frame(states_.size());
  setup_.for_ranges(of_frame.size(), [&](size_t first, size_t last) {
    for (size_t k = first; k < last; ++k) {
      AddTagStatistics(k, covariance, typical_scale, &of_frame[k]);
      if (k + 1 < states_.size()) AddMotionStatisticFrom(k, covariance, &of_frame[k]);
    }
  });
  for (const NoiseStatistics& statistics : of_frame) out += statistics;
  return out;
}

}  // namespace tagtwist

#include "estimator/solve/window_system.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>

#include "estimator/graph/linear_system.h"
#include "estimator/graph/marginalisation.h"
#include "estimator/graph/noise_model.h"

namespace tagtwist {
namespace {

constexpr int kSize = BlockBandedMatrix::kSize;
using Vector18 = Eigen::Matrix<double, kSize, 1>;

// Tags: a move by d, in rad and metres, changes their Jacobian by about its size, and so the
// whitened residuals by that times what d itself changes them by: this much may be neglected. Pose
// and attitude trade against one another, so that far less than a sigma shows.
constexpr double kTagNeglected = 1e-3;
// Motion: what of the turn between two states changes is squared in what is neglected.
constexpr double kMotionTurnRad = 1e-4, kMotionTurnBothRad = 2e-3;

// A graph of those frames alone, without tracks or prior.
Graph GraphOf(const EstimatorSetup& setup, const NoiseModel& noise,
              std::vector<GraphFrame> frames) {
  GraphInput input;
  input.frames = std::move(frames);
  return BuildGraph(setup, noise, input);
}

}  // namespace

Vector18 WindowSystem::PriorForm::GradientAt(const GraphState& state, double* cost) const {
  const Vector18 d = Difference(state, reference), h = hessian * d;
  *cost += d.dot(gradient + 0.5 * h);
  return gradient + h;
}

WindowSystem::Vector6 WindowSystem::TagForm::GradientAt(const GraphState& state,
                                                        double* cost_sum) const {
  const Vector6 d = Difference(state.pose, reference), h = hessian * d;
  *cost_sum += cost + d.dot(gradient + 0.5 * h);
  return gradient + h;
}

std::pair<Vector18, Vector18> WindowSystem::MotionForm::GradientsAt(const GraphState& at_first,
                                                                    const GraphState& at_second,
                                                                    double* cost_sum) const {
  const Vector18 d0 = Difference(at_first, first), d1 = Difference(at_second, second);
  const Vector18 e0 = h00 * d0 + h10.transpose() * d1, e1 = h10 * d0 + h11 * d1;
  *cost_sum += cost + d0.dot(g0 + 0.5 * e0) + d1.dot(g1 + 0.5 * e1);
  return {g0 + e0, g1 + e1};
}

bool WindowSystem::Fits(const EstimatorSetup& setup, const GraphInput& input) {
  if (input.prior) {
    for (const BlockRef& block : input.prior->blocks) {
      if (block.index != 0) return false;
    }
  }
  if (!setup.options.use_tracks) return true;
  return std::none_of(
      input.segments.begin(), input.segments.end(), [&](const TrackSegment& segment) {
        return segment.pixels.size() > 1 && segment.first_frame >= input.first_frame;
      });
}

void WindowSystem::LinearizeTags(const EstimatorSetup& setup, const NoiseModel& noise,
                                 const GraphFrame& frame, TagForm* form) const {
  *form = TagForm();
  form->reference = frame.state.world_from_body;
  form->weights.assign(frame.tags.size(), 1);
  const Graph graph = GraphOf(setup, noise, {frame});
  LinearFactor linear;
  for (const Factor& factor : graph.factors) {
    if (factor.kind != FactorKind::kTag || !LinearizeFactor(graph, factor, &linear)) continue;
    form->hessian.noalias() += linear.jacobian.transpose() * linear.jacobian;
    form->gradient.noalias() += linear.jacobian.transpose() * linear.residual;
    form->cost += RobustCost(factor, linear);
    form->weights[static_cast<size_t>(factor.source)] = linear.weight;
  }
}

void WindowSystem::LinearizeMotion(const NoiseModel& noise, size_t k) {
  MotionForm form;
  form.first = states_[k - 1];
  form.second = states_[k];
  Graph graph;
  graph.states = {form.first, form.second};
  const Factor factor = MotionFactor(graph, 0, noise);
  LinearFactor linear;
  LinearizeFactor(graph, factor, &linear);
  const Eigen::Matrix<double, 18, 18> j0 = linear.jacobian.leftCols<18>(),
                                      j1 = linear.jacobian.rightCols<18>();
  form.h00.noalias() = j0.transpose() * j0;
  form.h10.noalias() = j1.transpose() * j0;
  form.h11.noalias() = j1.transpose() * j1;
  form.g0.noalias() = j0.transpose() * linear.residual;
  form.g1.noalias() = j1.transpose() * linear.residual;
  form.cost = RobustCost(factor, linear);
  frames_[k].motion = form;
}

void WindowSystem::LinearizePrior(const Factor& factor) {
  Graph graph;
  graph.states = {states_.front()};
  graph.factors = {factor};
  const LinearSystem system = tagtwist::Linearize(graph);
  prior_ = PriorForm{states_.front(), system.hessian.At(0, 0).selfadjointView<Eigen::Lower>(),
                     system.gradient};
}

void WindowSystem::Linearize(const EstimatorSetup& setup, const NoiseModel& noise,
                             const GraphInput& input) {
  const auto size = input.frames.size();
  states_.clear();
  for (const GraphFrame& frame : input.frames) {
    states_.push_back(ToGraphState(frame.t_ns, frame.state, frame.acceleration));
  }
  if (frames_.empty() || frames_.front().t_ns != input.frames.front().t_ns) {  // another window
    frames_.clear();
    prior_.reset();
  }
  if (!prior_) {
    GraphFrame first = input.frames.front();
    first.tags.clear();
    LinearizePrior(input.prior ? *input.prior : GraphOf(setup, noise, {first}).factors.front());
  }
  frames_.resize(std::min(frames_.size(), size));
  for (size_t k = 0; k < size; ++k) {
    const GraphFrame& frame = input.frames[k];
    const bool is_new = k == frames_.size();
    if (is_new) {
      frames_.emplace_back();
      frames_[k].t_ns = frame.t_ns;
    }
    if (k > 0) LinearizeMotion(noise, k);
    if (is_new || frames_[k].tags.weights.size() != frame.tags.size()) {
      LinearizeTags(setup, noise, frame, &frames_[k].tags);
    }
  }
}

bool WindowSystem::LinearizeWhatMoved(const EstimatorSetup& setup, const NoiseModel& noise,
                                      const GraphInput& input) {
  bool any = false;
  for (size_t k = 0; k < states_.size(); ++k) {
    TagForm& tags = frames_[k].tags;
    const Vector6 moved = Difference(states_[k].pose, tags.reference);
    if (moved.norm() * std::sqrt(moved.dot(tags.hessian * moved)) > kTagNeglected) {
      GraphFrame frame = input.frames[k];
      frame.state = ToBodyState(states_[k]);
      LinearizeTags(setup, noise, frame, &tags);
      any = true;
    }
    if (k == 0) continue;
    const MotionForm& motion = *frames_[k].motion;
    const Vector18 first = Difference(states_[k - 1], motion.first),
                   second = Difference(states_[k], motion.second);
    if ((second - first).head<3>().norm() > kMotionTurnRad ||
        second.head<3>().norm() > kMotionTurnBothRad) {
      LinearizeMotion(noise, k);
      any = true;
    }
  }
  return any;
}

// Normal equations at the states, from the forms.
BlockBandedMatrix WindowSystem::Assemble(Eigen::VectorXd* gradient, double* cost) const {
  const int size = static_cast<int>(states_.size());
  BlockBandedMatrix hessian(size, std::min(size - 1, 1));
  gradient->setZero(kSize * size);
  *cost = 0;
  hessian.At(0, 0) += prior_->hessian;
  gradient->head<kSize>() += prior_->GradientAt(states_.front(), cost);
  for (int k = 0; k < size; ++k) {
    const FrameForms& forms = frames_[static_cast<size_t>(k)];
    const GraphState& state = states_[static_cast<size_t>(k)];
    hessian.At(k, k).topLeftCorner<6, 6>() += forms.tags.hessian;
    gradient->segment<6>(kSize * k) += forms.tags.GradientAt(state, cost);
    if (k == 0) continue;
    const MotionForm& motion = *forms.motion;
    hessian.At(k - 1, k - 1) += motion.h00;
    hessian.At(k, k - 1) += motion.h10;
    hessian.At(k, k) += motion.h11;
    const auto [g0, g1] = motion.GradientsAt(states_[static_cast<size_t>(k - 1)], state, cost);
    gradient->segment<kSize>(kSize * (k - 1)) += g0;
    gradient->segment<kSize>(kSize * k) += g1;
  }
  return hessian;
}

Result<Solution> WindowSystem::Solve(const EstimatorSetup& setup, const NoiseModel& noise,
                                     const SolveOptions& options, const GraphInput& input) {
  Linearize(setup, noise, input);
  Solution out;
  Eigen::VectorXd gradient;
  for (int iteration = 0; iteration < options.max_iterations; ++iteration) {
    const BlockBandedCholesky cholesky(Assemble(&gradient, &out.cost));
    if (!cholesky.ok()) return Error{"the normal equations are not positive definite"};
    const Eigen::VectorXd step = cholesky.Solve(-gradient);
    out.cost += 0.5 * gradient.dot(step);
    for (size_t k = 0; k < states_.size(); ++k) {
      states_[k] = Retract(states_[k], step.segment<kSize>(kSize * static_cast<int>(k)));
    }
    const bool moved = LinearizeWhatMoved(setup, noise, input);
    const bool may_go_on = iteration + 1 < options.max_iterations && !IsUp(options.time_up);
    if (moved && may_go_on) continue;
    out.covariance = cholesky.SelectedInverse();
    break;
  }
  out.graph.states = states_;
  return out;
}

std::vector<int> WindowSystem::TagsBelow(int k, double least) const {
  std::vector<int> out;
  const std::vector<double>& weights = frames_[static_cast<size_t>(k)].tags.weights;
  for (size_t i = 0; i < weights.size(); ++i) {
    if (weights[i] < least) out.push_back(static_cast<int>(i));
  }
  return out;
}

void WindowSystem::MarginalizeFirst() {
  const MotionForm& motion = *frames_[1].motion;
  const TagForm& tags = frames_[0].tags;
  double settled = 0;  // a constant
  auto [g0, g1] = motion.GradientsAt(states_[0], states_[1], &settled);
  g0 += prior_->GradientAt(states_[0], &settled);
  g0.head<6>() += tags.GradientAt(states_[0], &settled);
  Block h00 = prior_->hessian + motion.h00;
  h00.topLeftCorner<6, 6>() += tags.hessian;
  const Eigen::LLT<Block> leaving(h00);
  const Block gain = leaving.solve(motion.h10.transpose());
  PriorForm prior{states_[1], motion.h11, g1};
  prior.hessian.noalias() -= motion.h10 * gain;
  prior.hessian = (0.5 * (prior.hessian + prior.hessian.transpose())).eval();
  prior.gradient.noalias() -= gain.transpose() * g0;
  prior_ = prior;
  states_.erase(states_.begin());
  frames_.pop_front();
  frames_.front().motion.reset();
}

std::optional<Factor> WindowSystem::Prior() const {
  if (!prior_) return std::nullopt;
  return GaussianPrior(prior_->reference, prior_->hessian, prior_->gradient);
}

}  // namespace tagtwist

#include "estimator/solve/noise_statistics.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "estimator/solve/quadratic_chain.h"
#include "residuals/motion_residual.h"
#include "residuals/tag_reprojection_residual.h"

namespace tagtwist::internal {
namespace {

// Median of chi-square with 8 degrees of freedom, and its 0.9999 quantile.
constexpr double kMedianChi2Of8 = 7.344, kInlierChi2Of8 = 31.83;
// 0.99 quantile with 2 degrees of freedom, and the mean below it against the whole mean.
constexpr double kInlierChi2Of2 = 9.21, kInlierMeanOf2 = 0.9535;

double Median(std::vector<double>* values) {
  const auto middle = values->begin() + static_cast<std::ptrdiff_t>(values->size() / 2);
  std::nth_element(values->begin(), middle, values->end());
  return *middle;
}

// Squared norm of a factor without its robust weight.
double SquaredNorm(const LinearFactor& linear) {
  return linear.residual.squaredNorm() / linear.weight;
}

bool InRange(const Factor& factor, const StateRange& range) {
  const int state = factor.blocks.front().index;
  return state >= range.first && state < range.last;
}

// What each state sees.
struct Seen {
  int tags = 0, tracks = 0;
  bool any() const { return tags + tracks > 0; }
};

std::vector<Seen> SeenByStates(const Graph& graph) {
  std::vector<Seen> out(graph.states.size());
  for (const Factor& factor : graph.factors) {
    const auto state = static_cast<size_t>(factor.blocks.front().index);
    if (factor.kind == FactorKind::kTag) ++out[state].tags;
    if (factor.kind == FactorKind::kTrack) ++out[state].tracks;
  }
  return out;
}

std::vector<double> SquaredNormsOfTags(const Graph& graph) {
  std::vector<double> norms;
  Eigen::Matrix<double, 8, 1> residual;
  for (const Factor& factor : graph.factors) {
    if (factor.kind != FactorKind::kTag) continue;
    const auto& cost = static_cast<const TagReprojectionResidual&>(*factor.cost);
    const double* pose = graph.Parameters(factor.blocks.front());
    if (!cost.Linearize(pose, &residual, nullptr)) continue;
    norms.push_back(factor.information * residual.squaredNorm());
  }
  return norms;
}

// The diagonal of J P J' of a part of a motion factor between states k and k + 1, summed over the
// axes of each derivative.
Eigen::Array3d MotionLeverage(const LinearFactor& linear, const BlockBandedMatrix& p, int k,
                              const MotionResidual::Part& part) {
  Eigen::Matrix<double, 18, 18> joint;  // covariance of what enters
  Eigen::Matrix<double, 9, 18> jacobian;
  const auto& before = p.At(k, k);
  const auto& cross = p.At(k + 1, k);
  const auto& after = p.At(k + 1, k + 1);
  for (int i = 0; i < 3; ++i) {
    const int row = part.columns[static_cast<size_t>(i)];
    jacobian.middleCols<3>(3 * i) = linear.jacobian.block<9, 3>(part.first_row, row);
    jacobian.middleCols<3>(9 + 3 * i) =
        linear.jacobian.block<9, 3>(part.first_row, BlockBandedMatrix::kSize + row);
    for (int j = 0; j < 3; ++j) {
      const int column = part.columns[static_cast<size_t>(j)];
      joint.block<3, 3>(3 * i, 3 * j) = before.block<3, 3>(row, column);
      joint.block<3, 3>(9 + 3 * i, 3 * j) = cross.block<3, 3>(row, column);
      joint.block<3, 3>(3 * j, 9 + 3 * i) = cross.block<3, 3>(row, column).transpose();
      joint.block<3, 3>(9 + 3 * i, 9 + 3 * j) = after.block<3, 3>(row, column);
    }
  }
  const Eigen::Matrix<double, 9, 18> product = jacobian.lazyProduct(joint);
  const Eigen::Matrix<double, 9, 1> rows = product.cwiseProduct(jacobian).rowwise().sum();
  return {rows.head<3>().sum(), rows.segment<3>(3).sum(), rows.tail<3>().sum()};
}

// Adds the statistics of the nine rows of one part: of two sources of noise with the covariances
// A_i, sum A_i = I, each has r'A_i r and tr(A_i (I - J P J')), and A is diagonal. Under white noise
// on acceleration the last three hold the idle acceleration and say nothing.
void AddPart(const LinearFactor& linear, const BlockBandedMatrix& covariance,
             const MotionStep& step, const MotionPrior& prior, const MotionResidual::Part& part,
             VarianceStatistic* out, ShakeStatistic* shake) {
  const Eigen::Array3d leverage = MotionLeverage(linear, covariance, step.state, part),
                       share = ShareOfShake(prior, step.dt_s);
  for (int i = 0; i < (prior.on == WhiteNoiseOn::kJerk ? 3 : 2); ++i) {
    const VarianceStatistic row{linear.residual.segment<3>(part.first_row + 3 * i).squaredNorm(),
                                3 - leverage(i)};
    *out += {row.sum * prior.psd, row.dof};
    if (step.tells_shake) *shake += {row * share(i), row * (1 - share(i))};
  }
}

using Residual8 = Eigen::Matrix<double, 8, 1>;
using Jacobian8 = Eigen::Matrix<double, 8, 6>;
using Matrix8 = Eigen::Matrix<double, 8, 8>;

const TagReprojectionResidual& TagOf(const Factor& factor) {
  return static_cast<const TagReprojectionResidual&>(*factor.cost);
}

// The squared norms of a state's tags, and -1 for what is no tag.
std::vector<double> SquaredNormsOfTags(const QuadraticChain& chain, int state) {
  const PoseForm& form = chain.form(state);
  const double scale = form.Scale(chain.graph());
  std::vector<double> out;
  for (size_t i = 0; i < form.factors.size(); ++i) {
    const bool is_tag = chain.graph().factors[form.factors[i]].kind == FactorKind::kTag;
    out.push_back(is_tag ? scale * form.squared_norms[i] : -1);
  }
  return out;
}

// Whether a form tells its tags' statistic as it is: all are tags in pixels, none is far off.
bool IsPlain(const QuadraticChain& chain, const PoseForm& form, const std::vector<double>& norms,
             double limit) {
  if (form.is_robust || form.information == 0) return false;
  for (size_t i = 0; i < norms.size(); ++i) {
    if (norms[i] < 0 || norms[i] > limit) return false;
    if (!TagOf(chain.graph().factors[form.factors[i]]).is_in_pixels()) return false;
  }
  return true;
}

VarianceStatistic TagsStatistic(const QuadraticChain& chain, int state,
                                const BlockBandedMatrix& covariance, double limit, double s2) {
  const PoseForm& form = chain.form(state);
  const Eigen::Matrix<double, 6, 6> pose = covariance.At(state, state).topLeftCorner<6, 6>();
  const std::vector<double> norms = SquaredNormsOfTags(chain, state);
  VarianceStatistic out;
  if (IsPlain(chain, form, norms, limit)) {
    for (const double norm : norms) out += {s2 * norm, 8};
    out.dof -= form.Scale(chain.graph()) * pose.cwiseProduct(form.form.hessian).sum();
    return out;
  }
  Residual8 residual;
  Jacobian8 jacobian;
  for (size_t i = 0; i < norms.size(); ++i) {
    if (norms[i] < 0 || norms[i] > limit) continue;
    const Factor& factor = chain.graph().factors[form.factors[i]];
    const double unit = std::sqrt(factor.information);
    if (!TagOf(factor).Linearize(form.form.reference.params.data(), &residual, &jacobian)) continue;
    out += TagStatistic(Matrix8(unit * TagOf(factor).whitener()), unit * residual, unit * jacobian,
                        pose, s2);
  }
  return out;
}

std::ptrdiff_t TagsOf(const QuadraticChain& chain, int state) {
  const auto& factors = chain.form(state).factors;
  return std::count_if(factors.begin(), factors.end(),
                       [&](size_t f) { return chain.graph().factors[f].kind == FactorKind::kTag; });
}

// Of the motion from a state on; far from any tag it says nothing of itself.
void AddMotionFrom(const QuadraticChain& chain, int state, const BlockBandedMatrix& covariance,
                   const NoiseModel& noise, LinearFactor* scratch, NoiseStatistics* out) {
  const int f = chain.StepFrom(state);
  if (f < 0) return;
  const Graph& graph = chain.graph();
  const Factor& factor = graph.factors[static_cast<size_t>(f)];
  if (factor.kind != FactorKind::kMotion) return;
  const std::ptrdiff_t before = TagsOf(chain, state), after = TagsOf(chain, state + 1);
  if (before == 0 && after == 0) return;
  if (!LinearizeFactor(graph, factor, scratch)) return;
  const auto k = static_cast<size_t>(state);
  const double dt_s = ToSeconds(graph.states[k + 1].t_ns - graph.states[k].t_ns);
  AddMotionStatistic(*scratch, covariance, {state, dt_s, before > 1}, noise, out);
}

}  // namespace

double TypicalTagScale(std::vector<double> squared_norms) {
  return squared_norms.empty() ? 1.0 : Median(&squared_norms) / kMedianChi2Of8;
}

double MostOfInlierTag(double typical_scale) { return kInlierChi2Of8 * typical_scale; }

// The tag's covariance is C + s^2 I, C its own. The score of the likelihood by s^2 is zero where
// s^2 = s^2 (e' R^-2 e) / tr(R^-1 - R^-1 J P J' R^-1), R = C + s^2 I: with C = 0 MacKay's fixed
// point, and with s^2 far below C a statistic of next to no degrees of freedom.
VarianceStatistic TagStatistic(const Eigen::Matrix<double, 8, 8>& whitener,
                               const Eigen::Matrix<double, 8, 1>& residual,
                               const Eigen::Matrix<double, 8, 6>& jacobian,
                               const Eigen::Matrix<double, 6, 6>& pose_covariance, double s2) {
  const Eigen::Matrix<double, 8, 8> scaled = std::sqrt(s2) * whitener.transpose();
  const Eigen::Matrix<double, 8, 6> scaled_jacobian = scaled.lazyProduct(jacobian);
  const double leverage =
      scaled_jacobian.lazyProduct(pose_covariance).cwiseProduct(scaled_jacobian).sum();
  return {s2 * scaled.lazyProduct(residual).squaredNorm(),
          std::max(0.0, scaled.squaredNorm() - leverage)};
}

void AddMotionStatistic(const LinearFactor& linear, const BlockBandedMatrix& covariance,
                        const MotionStep& step, const NoiseModel& noise, NoiseStatistics* out) {
  AddPart(linear, covariance, step, noise.angular, MotionResidual::kAngular, &out->angular,
          &out->angular_shake);
  AddPart(linear, covariance, step, noise.linear, MotionResidual::kLinear, &out->linear,
          &out->linear_shake);
  out->motion_s += step.dt_s;
  ++out->motions;
}

NoiseStatistics ComputeNoiseStatistics(const Graph& graph, const BlockBandedMatrix& covariance,
                                       const NoiseModel& noise, const StateRange& range) {
  NoiseStatistics out;
  const double typical_scale = TypicalTagScale(SquaredNormsOfTags(graph));
  const std::vector<Seen> seen = SeenByStates(graph);
  LinearFactor linear;
  std::vector<int> views(graph.points.size(), 0);
  std::vector<double> sums(graph.points.size(), 0);
  for (const Factor& factor : graph.factors) {
    if (!InRange(factor, range) || !LinearizeFactor(graph, factor, &linear)) continue;
    const int k = factor.blocks.front().index;
    if (factor.kind == FactorKind::kMotion) {
      // Far from any measurement the prior says nothing of itself, and 9 - tr(J P J') is the
      // difference of equals.
      const auto i = static_cast<size_t>(k);
      if (!seen[i].any() && !seen[i + 1].any()) continue;
      const double dt_s = ToSeconds(graph.states[i + 1].t_ns - graph.states[i].t_ns);
      const bool tells_shake = seen[i].tags > 1;
      AddMotionStatistic(linear, covariance, {k, dt_s, tells_shake}, noise, &out);
    } else if (factor.kind == FactorKind::kTag) {
      if (SquaredNorm(linear) > MostOfInlierTag(typical_scale)) continue;
      const double plain = 1 / std::sqrt(linear.weight);
      out.corner += TagStatistic(
          std::sqrt(factor.information) *
              static_cast<const TagReprojectionResidual&>(*factor.cost).whitener(),
          plain * linear.residual, plain * linear.jacobian,
          covariance.At(k, k).topLeftCorner<6, 6>(), noise.corner_sigma_px * noise.corner_sigma_px);
    } else if (factor.kind == FactorKind::kTrack && SquaredNorm(linear) < kInlierChi2Of2) {
      const auto point = static_cast<size_t>(factor.blocks.back().index);
      ++views[point];
      sums[point] += SquaredNorm(linear);
    }
  }
  // The point takes two degrees of freedom; the poses, shared by many points, next to none.
  for (size_t i = 0; i < views.size(); ++i) {
    if (views[i] < 2) continue;
    out.track += {sums[i] * noise.track_sigma_px * noise.track_sigma_px,
                  kInlierMeanOf2 * (2.0 * views[i] - 2.0)};
  }
  return out;
}

NoiseStatistics ComputeNoiseStatistics(const QuadraticChain& chain,
                                       const BlockBandedMatrix& covariance, const NoiseModel& noise,
                                       const ForRanges& for_ranges) {
  const size_t size = chain.graph().states.size();
  std::vector<double> norms;
  for (size_t k = 0; k < size; ++k) {
    for (const double norm : SquaredNormsOfTags(chain, static_cast<int>(k))) {
      if (norm >= 0) norms.push_back(norm);
    }
  }
  const double limit = MostOfInlierTag(TypicalTagScale(std::move(norms)));
  const double s2 = noise.corner_sigma_px * noise.corner_sigma_px;
  std::vector<NoiseStatistics> of_state(size);
  for_ranges(size, [&](size_t first, size_t last) {
    LinearFactor scratch;
    for (size_t k = first; k < last; ++k) {
      const int state = static_cast<int>(k);
      of_state[k].corner = TagsStatistic(chain, state, covariance, limit, s2);
      AddMotionFrom(chain, state, covariance, noise, &scratch, &of_state[k]);
    }
  });
  NoiseStatistics out;
  for (const NoiseStatistics& statistics : of_state) out += statistics;
  return out;
}

}  // namespace tagtwist::internal

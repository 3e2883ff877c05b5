#include "estimator/solve/chain_statistics.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "estimator/graph/linear_system.h"
#include "residuals/tag_reprojection_residual.h"

namespace tagtwist::internal {
namespace {

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

bool SeesTag(const QuadraticChain& chain, int state) {
  const auto& factors = chain.form(state).factors;
  return std::any_of(factors.begin(), factors.end(),
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
  if (!SeesTag(chain, state) && !SeesTag(chain, state + 1)) return;
  if (!LinearizeFactor(graph, factor, scratch)) return;
  AddMotionStatistic(*scratch, covariance, state, noise, out);
  const auto k = static_cast<size_t>(state);
  out->motion_s += ToSeconds(graph.states[k + 1].t_ns - graph.states[k].t_ns);
  ++out->motions;
}

}  // namespace

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

#include "estimator/solve/quadratic_chain.h"

#include <algorithm>
#include <string>
#include <utility>

#include "estimator/graph/marginalisation.h"
#include "frontend/base/check.h"

namespace tagtwist::internal {
namespace {

// States that a factor touches, the first and the last.
std::pair<int, int> SpanOf(const Factor& factor) {
  const auto by_index = [](const BlockRef& a, const BlockRef& b) { return a.index < b.index; };
  const auto [low, high] =
      std::minmax_element(factor.blocks.begin(), factor.blocks.end(), by_index);
  return {low->index, high->index};
}

void Erase(const std::vector<size_t>& indices, std::vector<Factor>* factors) {
  std::vector<char> leaves(factors->size());
  for (const size_t f : indices) leaves[f] = true;
  size_t kept = 0;
  for (size_t f = 0; f < leaves.size(); ++f) {
    if (leaves[f]) continue;
    if (kept != f) (*factors)[kept] = std::move((*factors)[f]);
    ++kept;
  }
  factors->resize(kept);
}

}  // namespace

QuadraticChain::QuadraticChain(Graph graph, ForRanges for_ranges, PriorTangent tangent)
    : graph_(std::move(graph)),
      for_ranges_(std::move(for_ranges)),
      forms_(graph_.states.size()),
      tangent_(tangent) {
  TAGTWIST_CHECK(Fits(graph_), "a chain has no points");
  Index();
}

// Which factor is what; forms that then have other factors are to be linearised.
void QuadraticChain::Index() {
  for (PoseForm& form : forms_) form.factors.clear();
  steps_.assign(graph_.states.size(), -1);
  others_.clear();
  bandwidth_ = Bandwidth(graph_);
  for (size_t f = 0; f < graph_.factors.size(); ++f) {
    const auto [first, last] = SpanOf(graph_.factors[f]);
    const auto k = static_cast<size_t>(first);
    if (graph_.factors[f].IsOnOnePose()) {
      forms_[k].factors.push_back(f);
    } else if (last == first + 1 && steps_[k] < 0) {
      steps_[k] = static_cast<int>(f);
    } else {
      others_.push_back(f);
    }
  }
  for (PoseForm& form : forms_) {
    form.is_stale = form.is_stale || form.factors.size() != form.squared_norms.size();
  }
  if (prior_) bandwidth_ = std::max(bandwidth_, static_cast<int>(prior_->reference.size()) - 1);
}

void QuadraticChain::ChangeFactors(const std::function<void(const Graph&, Factor*)>& change) {
  for (PoseForm& form : forms_) {
    for (size_t i = 0; i < form.factors.size(); ++i) {
      Factor& factor = graph_.factors[form.factors[i]];
      const auto* const cost = factor.cost.get();
      const double information = factor.information;
      change(graph_, &factor);
      const bool other_information = factor.information != information;
      const double of_first = graph_.factors[form.factors.front()].information;
      if (form.information > 0 && factor.information != of_first) form.is_stale = true;
      if (factor.cost.get() != cost ||
          (other_information && (form.is_robust || form.information == 0))) {
        form.is_stale = true;
      }
    }
    // A factor that was within its Huber threshold may now be beyond it.
    const double scale = form.Scale(graph_);
    for (size_t i = 0; i < form.squared_norms.size() && !form.is_stale; ++i) {
      const double delta = graph_.factors[form.factors[i]].huber_delta;
      if (delta > 0 && scale * form.squared_norms[i] > delta * delta) form.is_stale = true;
    }
  }
  for (const int f : steps_) {
    if (f >= 0) change(graph_, &graph_.factors[static_cast<size_t>(f)]);
  }
  for (const size_t f : others_) change(graph_, &graph_.factors[f]);
}

void QuadraticChain::ReplaceFactorsOfPose(int state, std::vector<Factor> factors) {
  PoseForm& form = forms_[static_cast<size_t>(state)];
  Erase(form.factors, &graph_.factors);
  form = {};  // of no factor, should none come
  AddFactors(std::move(factors));
}

void QuadraticChain::AddState(const GraphState& state) {
  TAGTWIST_CHECK(graph_.states.empty() || state.t_ns > graph_.states.back().t_ns,
                 "a chain's stamps grow, but " + std::to_string(state.t_ns) + " ns comes after " +
                     std::to_string(graph_.states.back().t_ns) + " ns");
  graph_.states.push_back(state);
  forms_.emplace_back();
  steps_.push_back(-1);
}

void QuadraticChain::AddFactors(std::vector<Factor> factors) {
  for (Factor& factor : factors) {
    if (factor.IsOnOnePose()) {
      forms_[static_cast<size_t>(factor.blocks.front().index)].is_stale = true;
    }
    graph_.factors.push_back(std::move(factor));
  }
  Index();
}

std::vector<size_t> QuadraticChain::FactorsOfFirst(int* last) const {
  std::vector<size_t> out;
  out.reserve(graph_.factors.size());
  *last = prior_ ? static_cast<int>(prior_->reference.size()) - 1 : 0;
  for (size_t f = 0; f < graph_.factors.size(); ++f) {
    const auto [from, to] = SpanOf(graph_.factors[f]);
    if (from > 0) continue;
    out.push_back(f);
    *last = std::max(*last, to);
  }
  return out;
}

LinearSystem QuadraticChain::Leaving() const {
  int last = 0;
  const std::vector<size_t> leaving = FactorsOfFirst(&last);
  LinearSystem out = ZeroSystem(last + 1, last);
  LinearFactor scratch;
  for (const size_t f : leaving) {
    if (!graph_.factors[f].IsOnOnePose()) Add(f, &scratch, &out);
  }
  AddForms(1, &out);
  return out;
}

Eigen::MatrixXd QuadraticChain::PriorByStep() const {
  const auto n = static_cast<Eigen::Index>(prior_->reference.size());
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(kBlockSize * n, kBlockSize * n);
  for (Eigen::Index k = 0; k < n; ++k) {
    const auto i = static_cast<size_t>(k);
    out.block<kBlockSize, kBlockSize>(kBlockSize * k, kBlockSize * k) =
        DifferenceInWorldByStep(graph_.states[i], prior_->reference[i], tangent_);
  }
  return out;
}

// From the states' own tangent, at the reference, which they are at.
void QuadraticChain::TurnPrior() {
  if (tangent_ == PriorTangent::kOwn) return;
  const Eigen::MatrixXd to_step = PriorByStep().partialPivLu().inverse();
  prior_->hessian = (to_step.transpose() * prior_->hessian * to_step).eval();
  prior_->hessian = (0.5 * (prior_->hessian + prior_->hessian.transpose())).eval();
  prior_->gradient = (to_step.transpose() * prior_->gradient).eval();
}

void QuadraticChain::SetPrior(const Block& information) {
  prior_.emplace();
  prior_->reference = {graph_.states.front()};
  prior_->hessian = information;
  prior_->gradient.setZero(kBlockSize);
  TurnPrior();
}

void QuadraticChain::ShiftPrior(const GraphStep& gradient) {
  if (!prior_) {
    prior_.emplace();
    prior_->reference = {graph_.states.front()};
    prior_->hessian.setZero(kBlockSize, kBlockSize);
    prior_->gradient.setZero(kBlockSize);
  }
  prior_->gradient.head<kBlockSize>() += gradient;
}

void QuadraticChain::MarginalizeFirst() {
  int last = 0;
  const std::vector<size_t> leaving = FactorsOfFirst(&last);
  const LinearSystem system = Leaving();
  if (last == 0) {
    prior_.reset();
  } else {
    const QuadraticForm<Eigen::Dynamic> rest = EliminateFirst(system);
    prior_.emplace();
    prior_->reference.assign(graph_.states.begin() + 1, graph_.states.begin() + 1 + last);
    prior_->hessian = rest.hessian;
    prior_->gradient = rest.gradient;
  }
  Erase(leaving, &graph_.factors);
  for (Factor& factor : graph_.factors) {
    for (BlockRef& block : factor.blocks) --block.index;
  }
  graph_.states.erase(graph_.states.begin());
  forms_.erase(forms_.begin());
  if (prior_) TurnPrior();
  Index();
}

std::optional<Factor> QuadraticChain::Prior() const {
  if (!prior_) return std::nullopt;
  if (tangent_ == PriorTangent::kOwn) {
    return GaussianPrior(prior_->reference, prior_->hessian, prior_->gradient);
  }
  // The same about the states that it was made at.
  Eigen::MatrixXd by_step = Eigen::MatrixXd::Zero(prior_->hessian.rows(), prior_->hessian.cols());
  for (size_t i = 0; i < prior_->reference.size(); ++i) {
    const auto at = static_cast<Eigen::Index>(kBlockSize * i);
    by_step.block<kBlockSize, kBlockSize>(at, at) =
        DifferenceInWorldByStep(prior_->reference[i], prior_->reference[i], tangent_);
  }
  return GaussianPrior(prior_->reference, by_step.transpose() * prior_->hessian * by_step,
                       by_step.transpose() * prior_->gradient);
}

}  // namespace tagtwist::internal

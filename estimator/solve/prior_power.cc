#include "estimator/solve/prior_power.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "estimator/graph/linear_system.h"
#include "frontend/base/statistics/quantile.h"

namespace tagtwist::internal {
namespace {

// Step of the logarithm of the density in the numeric derivatives.
constexpr double kStep = 0.4;

// Of the densities that the derivatives take, the last one the graph's own.
constexpr std::array<double, PriorPowerSums::kScales> kLogScales = {kStep, -kStep, 0};
constexpr int kStiff = 0, kLoose = 1, kMiddle = 2;

std::vector<bool> MotionFactors(const Graph& graph) {
  std::vector<bool> use;
  for (const Factor& factor : graph.factors) use.push_back(factor.kind == FactorKind::kMotion);
  return use;
}

NormalsPiece WholeOf(const Graph& graph) {
  return {Linearize(graph),
          Linearize(graph, MotionFactors(graph)),
          0,
          {0, static_cast<int>(graph.states.size())}};
}

// Goes through a graph without points in pieces, each linearised as it is asked for.
class NormalsInPieces {
 public:
  NormalsInPieces(const Graph& graph, int states_of_a_piece)
      : graph_(graph),
        n_states_(static_cast<int>(graph.states.size())),
        length_(states_of_a_piece),
        bandwidth_(Bandwidth(graph)),
        motion_bandwidth_(Bandwidth(graph, MotionFactors(graph))),
        from_(graph.states.size() + 1) {
    // Counted, so that each state's factors keep their order: sums are then those of the whole.
    for (const Factor& factor : graph.factors) ++from_[FirstState(factor) + 1];
    for (size_t k = 1; k < from_.size(); ++k) from_[k] += from_[k - 1];
    by_state_.resize(graph.factors.size());
    std::vector<size_t> next = from_;
    for (size_t f = 0; f < graph.factors.size(); ++f) {
      by_state_[next[FirstState(graph.factors[f])]++] = f;
    }
  }

  size_t size() const { return static_cast<size_t>((n_states_ + length_ - 1) / length_); }

  // In the memory of another.
  void Linearise(size_t number, NormalsPiece* out) {
    const int begin = static_cast<int>(number) * length_,
              end = std::min(n_states_, begin + length_);
    out->first = std::max(0, begin - bandwidth_);
    out->own = {begin - out->first, end - out->first};
    const int last_first = std::min(n_states_, end + bandwidth_);
    const int n = std::min(n_states_, last_first + bandwidth_) - out->first;
    out->total = ZeroSystem(n, bandwidth_, std::move(out->total.hessian));
    out->motion = ZeroSystem(n, motion_bandwidth_, std::move(out->motion.hessian));
    const auto at = [&](int state) { return from_[static_cast<size_t>(state)]; };
    factors_.assign(by_state_.begin() + static_cast<std::ptrdiff_t>(at(out->first)),
                    by_state_.begin() + static_cast<std::ptrdiff_t>(at(last_first)));
    std::sort(factors_.begin(), factors_.end());
    for (const size_t f : factors_) {
      const Factor& factor = graph_.factors[f];
      if (!LinearizeFactor(graph_, factor, &linear_)) continue;
      AddFactor(factor, linear_, &out->total, out->first);
      if (factor.kind != FactorKind::kMotion) continue;
      AddFactor(factor, linear_, &out->motion, out->first);
    }
  }

 private:
  static size_t FirstState(const Factor& factor) {
    int first = factor.blocks.front().index;
    for (const BlockRef& block : factor.blocks) first = std::min(first, block.index);
    return static_cast<size_t>(first);
  }

  const Graph& graph_;
  int n_states_, length_, bandwidth_, motion_bandwidth_;
  std::vector<size_t> by_state_, from_;  // factors by the first state that they touch; where each
                                         // state's begin
  std::vector<size_t> factors_;          // of a piece
  LinearFactor linear_;
};

// a x of a symmetric matrix.
Eigen::VectorXd Product(const BlockBandedMatrix& a, const Eigen::VectorXd& x) {
  Eigen::VectorXd out = Eigen::VectorXd::Zero(x.size());
  const auto part = [](auto& v, int k) { return v.template segment<kBlockSize>(kBlockSize * k); };
  for (int j = 0; j < a.size(); ++j) {
    for (int i = j; i <= std::min(a.size() - 1, j + a.bandwidth()); ++i) {
      part(out, i) += a.At(i, j) * part(x, j);
      if (i > j) part(out, j) += a.At(i, j).transpose() * part(x, i);
    }
  }
  return out;
}

// Share of the prior in the state's information, in [0, 1].
double PriorShare(const StateCovariance& of_prior, const StateCovariance& covariance) {
  return covariance.ldlt().solve(of_prior).trace() / static_cast<double>(covariance.rows());
}

// Of a vector over all states, those of the piece's normal equations, and the piece's own.
auto OfPiece(const NormalsPiece& piece, Eigen::VectorXd& all) {
  return all.segment(kBlockSize * piece.first, piece.total.gradient.size());
}
auto Own(const NormalsPiece& piece, Eigen::VectorXd& all) {
  return all.segment(kBlockSize * (piece.first + piece.own.begin),
                     kBlockSize * (piece.own.end - piece.own.begin));
}

}  // namespace

PowerStatistic& PowerStatistic::operator+=(const PowerStatistic& other) {
  found += other.found;
  noise_alone += other.noise_alone;
  under_prior += other.under_prior;
  return *this;
}

PowerStatistic PowerStatistic::operator*(double factor) const {
  return {factor * found, factor * noise_alone, factor * under_prior};
}

double PowerStatistic::RawPower() const {
  const double of_motion = under_prior - noise_alone;
  return of_motion > 0.1 ? (found - noise_alone) / of_motion : 1;  // else next to nothing is known
}

double PowerStatistic::Power() const {
  const double of_motion = under_prior - noise_alone;
  if (!(of_motion > 0.1)) return 1;
  // Both are traces of positive matrices, the latter the larger; else rounding made them, as of
  // states microseconds apart.
  constexpr double kRounding = 0.05;
  if (std::min(noise_alone, under_prior) < -kRounding * of_motion) return 1;
  // The estimate's variance is about 2 under_prior / of_motion^2; before the data it is near 1.
  const double precision = of_motion * of_motion / (2 * under_prior);
  return std::clamp(1 + (RawPower() - 1) * precision / (1 + precision), 0.05, 5.0);
}

PriorPowerSums::PriorPowerSums(size_t n_states)
    : inverses_{ScaledInverse(kLogScales[0]), ScaledInverse(kLogScales[1]),
                ScaledInverse(kLogScales[2])},
      step_(kBlockSize * static_cast<Eigen::Index>(n_states)) {
  result_.of_prior.assign(n_states, StateCovariance::Zero());
  result_.covariances.resize(n_states);
}

void PriorPowerSums::Factorise(const NormalsPiece& piece, size_t number, ScaledInverse* inverse) {
  inverse->Factorise(piece.total.hessian, piece.motion.hessian, piece.own, number, &matrix_);
}

// L^-1 of a right side that is whole in the piece's own states and those that they reach: its own
// states' entries.
Eigen::VectorXd PriorPowerSums::SolveOn(const NormalsPiece& piece, Eigen::VectorXd right) {
  const auto [begin, end] = piece.own;
  const int n_after = std::min(matrix_.bandwidth(), matrix_.size() - end);
  if (piece.first + begin > 0) right.segment(kBlockSize * begin, right_.size()) = right_;
  SolveForward(matrix_, begin, end, &right);
  right_ = right.segment(kBlockSize * end, kBlockSize * n_after);
  return right.segment(kBlockSize * begin, kBlockSize * (end - begin));
}

void PriorPowerSums::Forward(const NormalsPiece& piece, size_t number) {
  for (ScaledInverse& inverse : inverses_) {
    Factorise(piece, number, &inverse);
    if (&inverse == &inverses_[kMiddle]) Own(piece, step_) = SolveOn(piece, piece.total.gradient);
  }
}

void PriorPowerSums::Back(const NormalsPiece& piece, size_t number, int scale) {
  ScaledInverse& inverse = inverses_[static_cast<size_t>(scale)];
  Factorise(piece, number, &inverse);
  if (!inverse.ok()) return;
  if (scale == kMiddle) {
    const bool is_last = kBlockSize * (piece.first + piece.own.end) == step_.size();
    if (is_last) Own(piece, step_) = SolveOn(piece, piece.total.gradient);
    Eigen::VectorXd x = OfPiece(piece, step_);
    SolveBackward(matrix_, piece.own.begin, piece.own.end, &x);
    OfPiece(piece, step_) = x;
  }
  inverse.InvertBack(piece.motion.hessian, piece.own, &matrix_);
  for (int k = piece.own.begin; k < piece.own.end; ++k) {
    const auto of_state = matrix_.At(k, k).topLeftCorner<12, 12>();
    const auto state = static_cast<size_t>(piece.first + k);
    StateCovariance& of_prior = result_.of_prior[state];
    if (scale == kStiff) of_prior = of_state;
    if (scale == kLoose) of_prior = (of_state - of_prior) / (2 * kStep);
    if (scale == kMiddle) result_.covariances[state] = of_state;
  }
}

void PriorPowerSums::ForwardAgain(const NormalsPiece& piece, size_t number) {
  Factorise(piece, number, &inverses_[kMiddle]);
  const Eigen::VectorXd gradient =
      piece.motion.gradient - Product(piece.motion.hessian, OfPiece(piece, step_));
  result_.statistic.found += SolveOn(piece, gradient).squaredNorm();
}

PriorPower PriorPowerSums::Finish() && {
  for (const ScaledInverse& inverse : inverses_) {
    if (inverse.ok()) continue;
    return {{}, std::vector<StateCovariance>(result_.of_prior.size(), StateCovariance::Zero()), {}};
  }
  const double loose = std::exp(-kStep) * inverses_[kLoose].trace();
  const double stiff = std::exp(kStep) * inverses_[kStiff].trace();
  result_.statistic.under_prior = (stiff - loose) / (2 * kStep);
  const double slope = -(loose - 2 * inverses_[kMiddle].trace() + stiff) / (kStep * kStep);
  result_.statistic.noise_alone = (result_.statistic.under_prior + slope) / 2;
  return std::move(result_);
}

PriorPower FindPriorPower(const Graph& graph, int states_of_a_piece) {
  // Points tie states in any number of pieces.
  if (!graph.points.empty() || graph.states.size() < 2) {
    PriorPowerFinder finder(graph);
    while (!finder.done()) finder.Step();
    return finder.result();
  }
  NormalsInPieces pieces(graph, states_of_a_piece);
  PriorPowerSums sums(graph.states.size());
  NormalsPiece piece;
  for (size_t i = 0; i + 1 < pieces.size(); ++i) {
    pieces.Linearise(i, &piece);
    sums.Forward(piece, i);
  }
  for (size_t i = pieces.size(); i-- > 0;) {
    pieces.Linearise(i, &piece);
    for (int scale = 0; scale < PriorPowerSums::kScales; ++scale) sums.Back(piece, i, scale);
  }
  for (size_t i = 0; i < pieces.size(); ++i) {
    pieces.Linearise(i, &piece);
    sums.ForwardAgain(piece, i);
  }
  return std::move(sums).Finish();
}

PriorPowerFinder::PriorPowerFinder(const Graph& graph)
    : whole_(WholeOf(graph)), sums_(graph.states.size()) {
  if (graph.states.size() >= 2) return;
  result_.of_prior.assign(graph.states.size(), StateCovariance::Zero());
  step_ = kSteps;
}

void PriorPowerFinder::Step() {
  sums_.Back(whole_, 0, step_++);
  if (!done()) return;
  sums_.ForwardAgain(whole_, 0);
  result_ = std::move(sums_).Finish();
}

std::vector<StateCovariance> WithPriorPower(double power, PriorPower prior) {
  std::vector<StateCovariance> out = std::move(prior.covariances);
  if (power == 1 || out.empty()) return out;
  std::vector<double> shares;
  for (size_t i = 0; i < out.size(); ++i) {
    shares.push_back(PriorShare(prior.of_prior[i], out[i]));
  }
  const double typical = Quantile(shares, 0.5);
  for (size_t i = 0; i < out.size(); ++i) {
    const double of_measurements = std::clamp((1 - shares[i]) / (1 - typical), 0.0, 1.0);
    const double weight = power < 1 ? of_measurements * of_measurements : 1.0;
    const StateCovariance scaled = out[i] + weight * (power - 1) * prior.of_prior[i];
    // The prior's share of a covariance is a difference; what rounding made of it is none.
    if (scaled.llt().info() == Eigen::Success) out[i] = scaled;
  }
  return out;
}

}  // namespace tagtwist::internal

#include "estimator/linear/class_filters.h"

#include <array>
#include <cmath>

#include "estimator/linear/filter_steps.h"
#include "estimator/linear/lanes.h"

namespace tagtwist::internal {
namespace {

// All classes: side by side those of which there are as many, then one by one.
template <int kLanes, class Step>
TAGTWIST_INLINE void DoAll(const Step& step, size_t n, double* data) {
  constexpr size_t kSide = ClassFilters::kSide;
  size_t i = 0;
  for (; i + kSide <= n; i += kSide, data += kSide * ClassFilters::kEntries) {
    for (size_t lane = 0; lane < kSide; lane += kLanes) {
      step.template Do<kLanes>(i + lane, data + lane);
    }
  }
  for (; i < n; ++i) step.template Do<1>(i, data++);
}

template <class Step>
TAGTWIST_WIDE void DoAllWide(const Step& step, size_t n, double* data) {
  DoAll<4>(step, n, data);
}

template <class Step>
void ForAll(const Step& step, size_t n, double* data) {
  if (kIsWide) return DoAllWide(step, n, data);
  DoAll<2>(step, n, data);
}

}  // namespace

ClassFilters::ClassFilters(size_t n, const Filter& each)
    : n_(n), data_(kEntries * kSide * ((n + kSide - 1) / kSide)) {
  for (size_t i = 0; i < n; ++i) Set(i, each);
}

ClassFilters::Filter ClassFilters::Of(size_t i) const {
  Filter out = Filter::Zero();
  for (size_t e = 0; e < kOfFilter; ++e) out(static_cast<Eigen::Index>(e)) = First(i)[kSide * e];
  return out;
}

void ClassFilters::Set(size_t i, const Filter& filter) {
  for (size_t e = 0; e < kOfFilter; ++e) First(i)[kSide * e] = filter(static_cast<Eigen::Index>(e));
}

void ClassFilters::Predict(const Eigen::Matrix3d& f, const Eigen::Matrix3d& q,
                           const std::vector<double>& densities) {
  ForAll(filter_steps::PredictStep{f, q, densities.data()}, n_, data_.data());
}

void ClassFilters::Update(const Eigen::Vector3d& x, const Eigen::Matrix3d& covariance) {
  const filter_steps::Measured measured{x, covariance};
  ForAll(filter_steps::UpdateStep{measured}, n_, data_.data());
}

void ClassFilters::UpdateOne(size_t i, const Eigen::Vector3d& x,
                             const Eigen::Matrix3d& covariance) {
  const filter_steps::Measured measured{x, covariance};
  filter_steps::UpdateStep{measured}.Do<1>(i, First(i));
}

double ClassFilters::LogLikelihood(size_t i) const {
  const double* const first = First(i);
  return -0.5 * (first[kSide * kSquare] + std::log(first[kSide * kDeterminant]));
}

// Sums over all lower classes grow from one class to the next, so that the work is linear in the
// number of classes.
void ClassFilters::Mix(double keep, const std::vector<double>& gives, const State& centre,
                       std::vector<double>* weights) {
  constexpr double kLeast = 1e-30;  // where nothing is kept or given
  Move(-centre);
  ForAll(filter_steps::AddSquaresOfMeansStep{1}, n_, data_.data());
  std::array<double, kOfFilter> lower = {};
  double weight_of_lower = 0;
  for (size_t j = 0; j < n_; ++j) {
    double& weight = (*weights)[j];
    const double kept = keep * weight, give = gives[j];
    const double from_next = j + 1 < n_ ? gives[j + 1] : 0;
    weight = kept + weight_of_lower + from_next + kLeast;
    const double over = 1 / weight;
    double* const at = First(j);
    const double* const next = j + 1 < n_ ? First(j + 1) : at;
    for (size_t e = 0; e < kOfFilter; ++e) {
      const double before = at[kSide * e];
      at[kSide * e] = over * (kept * before + lower[e] + from_next * next[kSide * e]);
      lower[e] += give * before;
    }
    weight_of_lower += give;
  }
  ForAll(filter_steps::AddSquaresOfMeansStep{-1}, n_, data_.data());
  Move(centre);
}

void ClassFilters::Move(const State& by) {
  for (size_t i = 0; i < n_; ++i) {
    for (size_t e = 0; e < 9; ++e) First(i)[kSide * e] += by(static_cast<Eigen::Index>(e));
  }
}

void ClassFilters::Turn(const Eigen::Matrix3d& rotation) {
  ForAll(filter_steps::TurnStep{rotation}, n_, data_.data());
}

ClassFilters::State ClassFilters::Mean(const std::vector<double>& weights) const {
  State out = State::Zero();
  for (size_t i = 0; i < n_; ++i) {
    for (size_t e = 0; e < 9; ++e) {
      out(static_cast<Eigen::Index>(e)) += weights[i] * First(i)[kSide * e];
    }
  }
  return out;
}

}  // namespace tagtwist::internal

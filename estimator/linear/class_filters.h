#pragma once
#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "estimator/linear/filter_layout.h"

namespace tagtwist::internal {

/// Kalman filters over [x; dx/dt; d2x/dt2] (3 entries each), one for each class of motion: they
/// differ by their process noise alone, and each step is done for several side by side.
class ClassFilters : public FilterLayout {
 public:
  /// So many that are all the same.
  ClassFilters(size_t n, const Filter& each);
  Filter Of(size_t i) const;
  void Set(size_t i, const Filter& filter);

  /// F x and F P F' + density Q, F and Q those of an axis, for all three alike; F is upper
  /// triangular.
  void Predict(const Eigen::Matrix3d& f, const Eigen::Matrix3d& q,
               const std::vector<double>& densities);
  /// x is measured.
  void Update(const Eigen::Vector3d& x, const Eigen::Matrix3d& covariance);
  /// By that class alone.
  void UpdateOne(size_t i, const Eigen::Vector3d& x, const Eigen::Matrix3d& covariance);
  /// Of what was measured last, of that class's, but for a constant; not finite where no number
  /// holds any more what the class says.
  double LogLikelihood(size_t i) const;
  /// Each becomes the mixture of itself, by what it keeps of its weight, of all before it and of
  /// the one after it, by what they give, moments being taken about `centre`; `weights` become the
  /// sums of what was kept and given.
  void Mix(double keep, const std::vector<double>& gives, const State& centre,
           std::vector<double>* weights);
  /// Adds to the means.
  void Move(const State& by);
  /// x becomes rotation * x.
  void Turn(const Eigen::Matrix3d& rotation);
  /// The weighted mean of the means.
  State Mean(const std::vector<double>& weights) const;

 private:
  double* First(size_t i) { return data_.data() + kEntries * kSide * (i / kSide) + i % kSide; }
  const double* First(size_t i) const {
    return data_.data() + kEntries * kSide * (i / kSide) + i % kSide;
  }

  size_t n_ = 0;
  std::vector<double> data_;  // entry by entry of four classes, then those of the next four
};

}  // namespace tagtwist::internal

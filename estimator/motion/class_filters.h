#pragma once
#include <Eigen/Core>
#include <cstddef>
#include <vector>

namespace tagtwist::internal {

/// Kalman filters over [x; dx/dt; d2x/dt2] (3 entries each), one for each class of motion: they
/// differ by their process noise alone, and each step is done for several side by side.
class ClassFilters {
 public:
  using State = Eigen::Matrix<double, 9, 1>;
  /// Of one class: the mean, then the covariance's six blocks of the upper triangle, by columns
  /// (and one entry that is idle).
  using Filter = Eigen::Matrix<double, 64, 1>;
  /// First entries of the blocks.
  enum Block { kXx = 9, kXv = 18, kXa = 27, kVv = 36, kVa = 45, kAa = 54 };
  static constexpr Block kBlocks[3][3] = {{kXx, kXv, kXa}, {kXv, kVv, kVa}, {kXa, kVa, kAa}};

  static constexpr size_t kEntries = 63;

  /// So many that are all the same.
  ClassFilters(size_t n, const Filter& each);
  size_t size() const { return n_; }
  Filter Of(size_t i) const;
  void Set(size_t i, const Filter& filter);

  /// F x and F P F' + density Q, F and Q those of an axis, for all three alike; F is upper
  /// triangular.
  void Predict(const Eigen::Matrix3d& f, const Eigen::Matrix3d& q,
               const std::vector<double>& densities);
  /// x is measured. Gives each class's logarithm of the likelihood, but for a constant; of one that
  /// no number holds any more what is not finite.
  void Update(const Eigen::Vector3d& x, const Eigen::Matrix3d& covariance,
              std::vector<double>* logs);
  /// The same of that class alone.
  double UpdateOne(size_t i, const Eigen::Vector3d& x, const Eigen::Matrix3d& covariance);
  /// Each becomes what it keeps of itself, what each of all before it gives, and what the one after
  /// it gives, over the whole: moments about `centre`.
  void Mix(const std::vector<double>& keeps, const std::vector<double>& gives,
           const std::vector<double>& wholes, const State& centre);
  /// Adds to the means.
  void Move(const State& by);
  /// x becomes rotation * x.
  void Turn(const Eigen::Matrix3d& rotation);
  /// The weighted mean of the means.
  State Mean(const std::vector<double>& weights) const;

 private:
  static constexpr size_t kSide = 4;
  double* First(size_t i) { return data_.data() + kEntries * kSide * (i / kSide) + i % kSide; }
  const double* First(size_t i) const {
    return data_.data() + kEntries * kSide * (i / kSide) + i % kSide;
  }

  size_t n_ = 0;
  std::vector<double> data_;  // entry by entry of four classes, then those of the next four
};

}  // namespace tagtwist::internal

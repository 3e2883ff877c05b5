#pragma once
#include <Eigen/Core>
#include <optional>
#include <vector>

#include "estimator/linear/class_filters.h"
#include "residuals/motion_prior.h"

namespace tagtwist::internal {

/// What a MotionBank supposes of a motion.
struct MotionBankOptions {
  WhiteNoiseOn on = WhiteNoiseOn::kJerk;
  double shake_s = 0;           // MotionPrior::shake_s
  double least_density = 1e-8;  // of the calmest class, in units of MotionPrior::psd
  double ratio = 10;            // from a class to the next
  int classes = 17;
  double switch_s = 2;  // mean time that a motion keeps its class, as far as the bank is to expect
  double first_rate_sigma = 100;  // standard deviations before the first measurement
  double first_acceleration_sigma = 50;
};
/// For the position [m] and for the attitude [rad] of a body: from rest to a racing drone.
MotionBankOptions LinearBankOptions(WhiteNoiseOn on);
MotionBankOptions AngularBankOptions(WhiteNoiseOn on);

/// A motion in three dimensions whose density of white noise varies in time, as a bank of densities
/// between which it may switch: interacting multiple models (Blom and Bar-Shalom 1988), a Kalman
/// filter a class over [x; dx/dt; d2x/dt2] (3 entries each). A class may switch UP to any other at
/// once, for motion starts suddenly, but DOWN one at a time; both are rare. The filters follow what
/// measurements of x say; what is asked of the bank is the density.
class MotionBank {
 public:
  using State = ClassFilters::State;
  using Covariance = Eigen::Matrix<double, 9, 9>;
  using Filter = ClassFilters::Filter;

  explicit MotionBank(const MotionBankOptions& options = {});

  /// The motion goes on for dt_s > 0; switching included.
  void Predict(double dt_s);
  /// x is measured, with that covariance (positive definite).
  void Measure(const Eigen::Vector3d& x, const Eigen::Matrix3d& covariance);

  /// The calmest class's density from now on; the others' go with it.
  void SetLeastDensity(double density);

  /// MotionPrior::shake_s of all classes from now on.
  void SetShake(double shake_s) { options_.shake_s = shake_s; }

  /// What is known of the classes besides; as many, with sum 1.
  void SetWeights(const std::vector<double>& weights) { weights_ = weights; }

  /// Of each class after the last call; they sum to 1.
  const std::vector<double>& weights() const { return weights_; }
  /// The geometric mean of the classes' densities by these weights.
  double DensityOf(const std::vector<double>& weights) const;
  double Density() const { return DensityOf(weights_); }
  /// Logarithm of the likelihood of the last measurement, the mixture before it given.
  double log_likelihood() const { return log_likelihood_; }

  /// What a class says.
  struct Class {
    size_t index = 0;
    double density = 0, weight = 0;
    Filter filter;
  };
  /// Those that have at least that weight.
  std::vector<Class> Classes(double least_weight) const;
  static Covariance CovarianceOf(const Filter& filter);
  /// As of time that runs the other way, and x measured from -origin.
  static void TurnTime(const Eigen::Vector3d& origin, Filter* filter);
  size_t size() const { return weights_.size(); }
  const MotionBankOptions& options() const { return options_; }

  /// The mixture's.
  State Mean() const { return filters_.Mean(weights_); }
  Covariance MixtureCovariance() const;
  /// By how much the mixture's variances of x and of dx/dt (the mean of the axes) exceed those of a
  /// filter with the mean density: >= 0, large while it is open which class holds.
  Eigen::Vector2d ExcessVariance() const;

  /// x is from now on measured from another origin: x becomes x - origin.
  void MoveOrigin(const Eigen::Vector3d& origin);
  /// The same along other axes: x becomes rotation * x.
  void TurnOrigin(const Eigen::Matrix3d& rotation) { filters_.Turn(rotation); }

 private:
  void Mix(double dt_s);

  MotionBankOptions options_;
  std::vector<double> densities_, weights_;
  ClassFilters filters_;
  double log_likelihood_ = 0;
};

}  // namespace tagtwist::internal

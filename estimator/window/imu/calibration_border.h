#pragma once
#include <Eigen/Core>
#include <vector>

#include "estimator/graph/graph_builder.h"
#include "estimator/imu/imu_border.h"
#include "estimator/imu/imu_factors.h"
#include "estimator/solve/quadratic_chain.h"
#include "estimator/solve/world_tangent.h"

namespace tagtwist::internal {

/// What is known of an IMU's calibration together with a chain's first state: a Gaussian.
struct CalibratedState {
  ImuCalibration calibration;  // the mean,
  ImuStepCovariance covariance = ImuStepCovariance::Zero();
  Block given_calibration = Block::Zero();  // the state's covariance where it were exact
  /// What the state moves by for each column of the lower triangular root of that covariance.
  Eigen::Matrix<double, kBlockSize, kImuEntries> by_calibration =
      Eigen::Matrix<double, kBlockSize, kImuEntries>::Zero();
};

/// An IMU's calibration, estimated with the states of a chain of frames that come and go: nine
/// parameters that do not change beside the chain's normal equations. The chain is solved under the
/// calibration as it is; then the calibration moves by what all that was measured says of it, and
/// the chain's factors and prior with it, to first order. So a state's covariance has what is open
/// of the calibration, and both grow sharper together.
///   states x, calibration u:  [H G; G' A] [dx; du] = -[g; c],  du = -(A - G'H^-1 G)^-1 (c - G'H^-1
///   g).
class CalibrationBorder {
 public:
  /// That of the chain's prior.
  static constexpr PriorTangent kTangent = PriorTangent::kWorld;

  CalibrationBorder() = default;
  /// Of a chain whose first state is that one.
  CalibrationBorder(const CalibratedState& known, const GraphState& first);

  /// As it is.
  ImuCalibration calibration() const;
  ImuStepCovariance covariance() const;
  /// Another chain begins, whose first state is known apart from the calibration.
  void Restart();

  /// After the chain is solved: the calibration moves, and the chain's factors are made to follow.
  /// Adds to the covariances of all states what is open of it, and to `states` what it has moved
  /// them by. False where nothing is to be had of the normal equations; then all is as before.
  bool Update(QuadraticChain* chain, BlockBandedMatrix* covariance,
              std::vector<GraphFrame>* states);
  /// Before the chain's first state leaves.
  void MarginalizeFirst(const QuadraticChain& chain);

 private:
  using Entries = Eigen::Matrix<double, kImuEntries, 1>;
  using Columns = Eigen::Matrix<double, Eigen::Dynamic, kImuEntries>;
  using OfState = Eigen::Matrix<double, kBlockSize, kImuEntries>;
  static OfState OfTangent(const GraphState& state, const OfState& by_step);
  OfState CrossAt(const GraphState& first) const;
  // What a factor says of it, at the states as they are.
  struct OfFactor {
    const ceres::CostFunction* cost = nullptr;
    int first = 0;       // state
    Eigen::MatrixXd by;  // rows x 9
    Eigen::VectorXd residual;
    Eigen::MatrixXd by_states;  // of the blocks, from that state's on, side by side
  };
  // Those of a chain but for tags'.
  std::vector<OfFactor> Linearize(const QuadraticChain& chain) const;
  Entries PriorGradient(const GraphState& first) const;
  void Follow(const std::vector<OfFactor>& factors, const Entries& moved, QuadraticChain* chain);

  ImuCalibration reference_;
  ImuStepCovariance root_ = ImuStepCovariance::Zero();  // a step of u is root_ * u of the reference
  Entries u_ = Entries::Zero();
  ImuStepCovariance covariance_ = ImuStepCovariance::Identity();  // of u
  // Of what has left: in the chain's first state, about that reference, and in u about u_there_.
  GraphState first_;
  bool is_tied_ = false;             // to that state
  OfState cross_ = OfState::Zero();  // in kTangent
  ImuStepCovariance own_ = ImuStepCovariance::Identity();
  Entries gradient_ = Entries::Zero(), u_there_ = Entries::Zero();
};

}  // namespace tagtwist::internal

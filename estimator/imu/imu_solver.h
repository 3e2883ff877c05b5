#pragma once
#include <cstddef>
#include <optional>
#include <vector>

#include "estimator/graph/graph_builder.h"
#include "estimator/graph/noise_model.h"
#include "estimator/imu/imu_border.h"
#include "estimator/imu/imu_factors.h"
#include "estimator/imu/imu_solution.h"
#include "estimator/solve/smoother.h"
#include "frontend/base/result.h"

namespace tagtwist::internal {

/// SolveWithImu in pieces, so that no frame of a window has to wait for all of it: a piece is one
/// solution of the states, or one step of the calibration.
class ImuSolver {
 public:
  ImuSolver(const EstimatorSetup& setup, const NoiseModel& noise, const ImuRecord& imu,
            std::vector<GraphFrame> frames, const std::optional<ImuModel>& known,
            bool by_likelihood);

  /// The next piece; true: all is done.
  Result<bool> Advance();
  ImuSolution Finish() &&;

 private:
  // States and calibration in turns, under the noise as it is; or one density by steps of a factor
  // either way while the likelihood grows; or the states alone.
  struct Task {
    int most_rounds = 0;
    double ImuNoiseScale::*part = nullptr;
    double factor = 0;
  };
  Status Start();
  void Begin();
  Result<bool> AdvanceRounds();
  Result<bool> AdvanceClimb();
  Status SolveStates();
  double LogEvidence() const;
  ImuResult Found() const;

  EstimatorSetup setup_;
  NoiseModel noise_;
  ImuRecord imu_;
  std::optional<ImuModel> known_;
  GraphInput input_;
  ImuModel model_;
  ImuCalibration reference_;
  ImuNoiseScale scatter_;  // of the samples
  Solution solution_;
  int intervals_ = 0;
  std::optional<ImuBorder> border_;
  bool has_started_ = false;
  std::vector<Task> tasks_;
  size_t task_ = 0;
  int round_ = 0;  // of the task; or step one way
  bool is_border_next_ = false, is_settled_ = false, goes_down_ = false;
  double evidence_ = 0;  // the best yet of the noise
};

}  // namespace tagtwist::internal

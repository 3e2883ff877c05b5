#pragma once
#include <Eigen/Core>
#include <optional>
#include <vector>

#include "estimator/batch/open_accounts.h"
#include "estimator/imu/imu_solve.h"
#include "estimator/result/estimate.h"
#include "frontend/types/measurements.h"

namespace tagtwist::internal {

/// What a batch has solved by tags alone, and then with an IMU.
struct SolvedByTags {
  std::vector<int>* state_of_frame;  // as of StatesOfFrames
  std::vector<OpenAccounts>* open;
  GraphInput* input;
  Solution* solution;
};

/// Puts the IMU, where there is one, into the solution: then the frames that it covers have states,
/// whether they see anything or not, and `out` has the noise and the IMU's calibration. `stamped`:
/// all frames at their times. Tags are revised once by what the IMU makes of the motion. Where it
/// does not do all stays as it is, and a warning tells why. What is given back belongs to the
/// states' covariances (AddSharedErrors).
std::vector<Eigen::VectorXd> TakeImu(const EstimatorSetup& setup,
                                     const std::optional<ImuRecord>& imu,
                                     const std::vector<FrameMeasurements>& measured,
                                     const std::vector<GraphFrame>& stamped,
                                     const SolvedByTags& solved, Estimate* out);

/// Of each frame of `out`, which has the IMU, the state that is surer (SurerStates); between the
/// frames the trajectory that most of them are of.
void TakeSurer(Estimate by_tags, Estimate* out);

}  // namespace tagtwist::internal

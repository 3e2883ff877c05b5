#include "estimator/imu/imu_solve.h"

#include <optional>
#include <utility>

#include "estimator/imu/imu_solver.h"

namespace tagtwist::internal {

Result<ImuSolution> SolveWithImu(const EstimatorSetup& setup, const NoiseModel& noise,
                                 const ImuRecord& imu, std::vector<GraphFrame> frames,
                                 const ImuModel* known, bool by_likelihood) {
  ImuSolver solver(setup, noise, imu, std::move(frames),
                   known != nullptr ? std::optional(*known) : std::nullopt, by_likelihood);
  while (true) {
    const auto done = solver.Advance();
    if (!done) return done.error();
    if (*done) return std::move(solver).Finish();
  }
}

}  // namespace tagtwist::internal

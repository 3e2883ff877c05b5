#include "estimator/calibration/noise.h"

#include <cmath>

#include "estimator/calibration/costs.h"
#include "frontend/base/statistics/robust.h"

namespace tagtwist::internal {
namespace {

// Correlation of successive errors, from their sums.
class Succession {
 public:
  void Add(const Eigen::Vector3d& error) {
    squares_ += error.squaredNorm();
    products_ += error.dot(last_);
    last_ = error;
  }
  double Correlation() const { return squares_ > 0 ? products_ / squares_ : 0; }

 private:
  Eigen::Vector3d last_ = Eigen::Vector3d::Zero();
  double squares_ = 0, products_ = 0;
};

}  // namespace

NoiseSums SumNoise(const CalibrationProblem& problem, const CalibrationState& state,
                   const std::vector<CalibrationFrame>& frames, const CalibrationNoise& noise,
                   const CalibrationNormals& normals, const Eigen::MatrixXd& covariance) {
  NoiseSums out;
  double all = 0;
  Succession rotation, position;
  const CalibrationLayout layout = LayoutOf(state);
  TagCalibrationResidual at;
  for (size_t i = 0; i < frames.size(); ++i) {
    const EliminatedFrame& eliminated = normals.frames[i];
    for (const CalibrationView& view : frames[i].views()) {
      if (!LinearizeView(state, frames[i], view, &at, false)) {
        continue;
      }
      const double squared = at.residual.squaredNorm();
      out.corner += Huber(squared, HuberDelta(problem.robust_scale, 8)).weight * squared;
      all += 8;
    }
    all -= 6;
    if (!frames[i].has_truth) continue;
    const auto truth = LinearizeTruth(problem, state, frames[i], noise);
    if (!truth) continue;
    const double weight =
        Huber(truth->residual.squaredNorm(), HuberDelta(problem.robust_scale, 6)).weight;
    rotation.Add(std::sqrt(weight) * truth->residual.head<3>());
    position.Add(std::sqrt(weight) * truth->residual.tail<3>());
    ++out.truth_frames;
    out.truth_rotation += weight * truth->residual.head<3>().squaredNorm();
    out.truth_position += weight * truth->residual.tail<3>().squaredNorm();
    // Of the whitened residual's prediction: by the pose alone, and by the shared parameters, which
    // move the pose, too.
    Eigen::Matrix<double, 6, 1> taken =
        (truth->by_cam * eliminated.covariance * truth->by_cam.transpose()).diagonal();
    if (!eliminated.columns.empty()) {
      Eigen::Matrix<double, 6, Eigen::Dynamic> by_shared = -truth->by_cam * eliminated.by_shared;
      by_shared.middleCols<kTruthColumns>(layout.mount()) += truth->by_shared;
      const Eigen::MatrixXd shared = covariance(eliminated.columns, eliminated.columns);
      taken += (by_shared * shared * by_shared.transpose()).diagonal();
    }
    const Eigen::Matrix<double, 6, 1> redundancy =
        Eigen::Matrix<double, 6, 1>::Ones() - weight * taken;
    out.truth_rotation_redundancy += redundancy.head<3>().sum();
    out.truth_position_redundancy += redundancy.tail<3>().sum();
    all += 6;
  }
  for (Eigen::Index i = 0; i < problem.prior_sigmas.size(); ++i) {
    const double sigma = problem.prior_sigmas(i);
    if (sigma > 0) all -= 1 - covariance(i, i) / (sigma * sigma);
  }
  out.truth_position_correlation = position.Correlation();
  out.truth_rotation_correlation = rotation.Correlation();
  out.corner_redundancy = all - out.truth_position_redundancy - out.truth_rotation_redundancy;
  return out;
}

}  // namespace tagtwist::internal

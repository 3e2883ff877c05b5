#include "estimator/motion/open_motion.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace tagtwist::internal {
namespace {

// First entries of x, dx/dt and d2x/dt2 in a state's tangent.
constexpr std::array<int, 3> kLinearEntries = {3, 6, 12}, kAngularEntries = {0, 9, 15};

using Classes = std::vector<MotionBank::Class>;

// What a frame shows of motion beyond what its prediction has: along axes that are independent of
// one another, the information of x, and the score.
struct Innovation {
  Eigen::Matrix3d axes;
  Eigen::Vector3d information, score;
};

// With n as the further motion over the interval, per axis [x; dx/dt; d2x/dt2] ~ N(0, more * unit),
// unit that of a density of 1: the sums over livelier classes of what their n would have, the
// frame given. Covariance and square of the mean are process * unit + M of unit's first column's
// square, M along the axes.
struct Further {
  double process = 0;
  Eigen::Matrix3d of_x = Eigen::Matrix3d::Zero();
};

double Information(double variance, double information) {
  constexpr double kLeast = 0.05;  // less variance than was assumed, but for rounding never none
  return std::max(1 + variance * information, kLeast);
}

// Weights of the classes after the frame.
std::vector<double> WeightsAfter(const Classes& before, const Innovation& frame, double x_variance,
                                 double density) {
  std::vector<double> out;
  double most = -std::numeric_limits<double>::infinity(), sum = 0;
  for (const MotionBank::Class& c : before) {
    const double more = (c.density - density) * x_variance;
    double log = std::log(c.weight);
    for (int i = 0; i < 3; ++i) {
      const double grown = Information(more, frame.information(i));
      log += 0.5 * (more * std::pow(frame.score(i), 2) / grown - std::log(grown));
    }
    out.push_back(log);
    most = std::max(most, log);
  }
  for (double& w : out) sum += w = std::exp(w - most);
  for (double& w : out) w /= sum;
  return out;
}

Further FurtherMotion(const Classes& before, const Innovation& frame, double x_variance,
                      double density) {
  const std::vector<double> weights = WeightsAfter(before, frame, x_variance, density);
  Further out;
  for (size_t k = 0; k < before.size(); ++k) {
    const double more = before[k].density - density;
    if (!(more > 0)) continue;
    const Eigen::Array3d grown = 1 + more * x_variance * frame.information.array();
    const Eigen::Vector3d mean = more * frame.score.array() / grown;
    Eigen::Matrix3d of_x = mean * mean.transpose();
    of_x.diagonal().array() -= more * more * frame.information.array() / grown;
    out.process += weights[k] * more;
    out.of_x += weights[k] * of_x;
  }
  out.of_x = (frame.axes * out.of_x * frame.axes.transpose()).eval();
  return out;
}

// `gain` is what of the further motion reaches the state past the tags.
StateCovariance OfPart(const Classes& before, const MotionPrior& prior, double dt_s,
                       const std::array<int, 3>& entries, const PoseInformation& innovation,
                       const Eigen::Matrix<double, 12, 18>& gain) {
  const int x = entries[0];
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(
      innovation.information.block<3, 3>(x, x));
  const Innovation frame{eigen.eigenvectors(), eigen.eigenvalues().cwiseMax(0.0),
                         eigen.eigenvectors().transpose() * innovation.score.segment<3>(x)};
  Eigen::Matrix3d unit = ProcessCovariance(WithDensity(prior, 1.0), dt_s);
  if (prior.on == WhiteNoiseOn::kAcceleration) unit(2, 2) = 0;  // the idle acceleration
  const Further further = FurtherMotion(before, frame, unit(0, 0), prior.psd);
  StateCovariance out = StateCovariance::Zero();
  for (size_t i = 0; i < 3; ++i) {
    for (size_t j = 0; j < 3; ++j) {
      const auto a = static_cast<Eigen::Index>(i), b = static_cast<Eigen::Index>(j);
      Eigen::Matrix3d block = unit(a, 0) * unit(b, 0) * further.of_x;
      block.diagonal().array() += further.process * unit(a, b);
      out += gain.middleCols<3>(entries[i]) * block * gain.middleCols<3>(entries[j]).transpose();
    }
  }
  return 0.5 * (out + out.transpose());
}

}  // namespace

// What the tags say beyond the prediction has the covariance S, the prediction's and theirs. With
// I = L L' their information, and P the pose's covariance after them, S^-1 = L (1 - L' P L) L', and
// S^-1 times it is their score at the state. Of what moves the prediction L^-T (1 - L' P L) L'
// reaches the pose. Where the tags tell nearly all, rounding would leave nothing of the difference,
// and any motion would seem possible.
StateCovariance OpenMotion(const MotionBanks::Prediction& before, const ArrivedState& state) {
  constexpr double kLeastShare = 1e-3;  // of the prediction in what is known
  const PoseCovariance& information = state.tags.information;
  const Eigen::LLT<PoseCovariance> llt(information);
  const PoseCovariance root = llt.matrixL();
  const Eigen::SelfAdjointEigenSolver<PoseCovariance> of_prediction(
      PoseCovariance::Identity() -
      root.transpose() * state.covariance.topLeftCorner<6, 6>() * root);
  StateCovariance out = StateCovariance::Zero();
  if (llt.info() != Eigen::Success || of_prediction.info() != Eigen::Success) return out;
  const PoseCovariance share =
      of_prediction.eigenvectors() *
      of_prediction.eigenvalues().cwiseMax(kLeastShare).cwiseMin(1.0).asDiagonal() *
      of_prediction.eigenvectors().transpose();
  const PoseInformation innovation{root * share * root.transpose(), state.tags.score};
  Eigen::Matrix<double, 12, 18> gain = Eigen::Matrix<double, 12, 18>::Identity();
  gain.topLeftCorner<6, 6>() = llt.matrixU().solve(PoseCovariance(share * root.transpose()));
  gain.bottomLeftCorner<6, 6>() = -state.covariance.block<6, 6>(6, 0) * information;
  const auto add = [&](const Classes& classes, const std::optional<MotionPrior>& prior,
                       const std::array<int, 3>& entries) {
    if (prior) out += OfPart(classes, *prior, before.dt_s, entries, innovation, gain);
  };
  add(before.linear, state.linear, kLinearEntries);
  add(before.angular, state.angular, kAngularEntries);
  return out;
}

}  // namespace tagtwist::internal

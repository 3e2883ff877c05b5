#include "estimator/motion/open_motion.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <array>
#include <cmath>
#include <random>
#include <vector>

namespace tagtwist::internal::open_motion_test {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;

constexpr double kDtS = 0.04;

// What a filter of one density predicts, and what the tags of the frame say.
struct Frame {
  Block predicted = Block::Identity();
  Matrix6 tags = Matrix6::Identity();    // covariance of what they measure
  PoseStep measured = PoseStep::Zero();  // beyond the prediction
};

Frame DrawFrame(double pose_sigma, double tag_sigma) {
  std::mt19937 rng(7);
  std::normal_distribution<double> normal;
  const auto random = [&](int n) {
    return Eigen::MatrixXd(Eigen::MatrixXd::NullaryExpr(n, n, [&] { return normal(rng); }));
  };
  Frame out;
  Eigen::Matrix<double, kBlockSize, 1> sigma;
  sigma << Eigen::Matrix<double, 6, 1>::Constant(pose_sigma),
      Eigen::Matrix<double, 6, 1>::Constant(0.05), Eigen::Matrix<double, 6, 1>::Constant(0.5);
  const Eigen::MatrixXd a = sigma.asDiagonal() * random(kBlockSize), b = tag_sigma * random(6);
  out.predicted = a * a.transpose();
  out.tags = b * b.transpose();
  for (int i = 0; i < 6; ++i) out.measured(i) = 2 * pose_sigma * normal(rng);
  return out;
}

// A state after the frame, where the interval had `more` than the filter's density of noise in the
// entries that begin there, and the logarithm of how likely the frame then was.
struct Updated {
  Eigen::Matrix<double, 12, 1> mean;
  StateCovariance covariance;
  Block whole;
  double log_likelihood = 0;
};

Updated Update(const Frame& frame, double more, const std::array<int, 3>& entries) {
  const Eigen::Matrix3d noise = ProcessCovariance({WhiteNoiseOn::kJerk, 1.0}, kDtS);
  Block predicted = frame.predicted;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      predicted.block<3, 3>(entries[static_cast<size_t>(i)], entries[static_cast<size_t>(j)])
          .diagonal()
          .array() += more * noise(i, j);
    }
  }
  const Matrix6 s = predicted.topLeftCorner<6, 6>() + frame.tags, inverse = s.inverse();
  const Eigen::Matrix<double, kBlockSize, 6> gain = predicted.leftCols<6>() * inverse;
  Updated out;
  out.whole = predicted - gain * s * gain.transpose();
  out.covariance = out.whole.topLeftCorner<12, 12>();
  out.mean = gain.topRows<12>() * frame.measured;
  out.log_likelihood =
      -0.5 * (frame.measured.dot(inverse * frame.measured) + std::log(s.determinant()));
  return out;
}

ArrivedState Arrive(const Frame& frame) {
  const Updated at = Update(frame, 0, {3, 6, 12});
  ArrivedState out;
  out.covariance = at.whole;
  out.tags.information = frame.tags.inverse();
  out.tags.score = out.tags.information * (frame.measured - at.mean.head<6>());
  return out;
}

std::vector<MotionBank::Class> ClassesOf(const std::vector<double>& densities,
                                         const std::vector<double>& weights) {
  std::vector<MotionBank::Class> out;
  for (size_t i = 0; i < densities.size(); ++i) {
    out.push_back({i, densities[i], weights[i], MotionBank::Filter::Zero()});
  }
  return out;
}

// Filters of each density, mixed by how likely they make the frame, about the state of the one.
void ExpectMixture(bool is_linear) {
  const std::array<int, 3> entries =
      is_linear ? std::array<int, 3>{3, 6, 12} : std::array<int, 3>{0, 9, 15};
  constexpr double kDensity = 10;
  const std::vector<double> densities = {kDensity, 1e3, 1e5, 1e7}, weights = {0.7, 0.1, 0.1, 0.1};
  const Frame frame = DrawFrame(2e-3, 1e-2);
  const Updated own = Update(frame, 0, entries);
  StateCovariance expected = StateCovariance::Zero();
  double sum = 0;
  for (size_t i = 0; i < densities.size(); ++i) {
    const Updated one = Update(frame, densities[i] - kDensity, entries);
    const double weight = weights[i] * std::exp(one.log_likelihood - own.log_likelihood);
    const auto apart = (one.mean - own.mean).eval();
    sum += weight;
    expected += weight * (one.covariance - own.covariance + apart * apart.transpose());
  }
  expected /= sum;

  ArrivedState arrived = Arrive(frame);
  const MotionPrior prior{WhiteNoiseOn::kJerk, kDensity};
  (is_linear ? arrived.linear : arrived.angular) = prior;
  MotionBanks::Prediction before;
  (is_linear ? before.linear : before.angular) = ClassesOf(densities, weights);
  before.dt_s = kDtS;
  const StateCovariance open = OpenMotion(before, arrived);
  EXPECT_GT(expected.diagonal()(entries[1]), 0.1 * own.covariance.diagonal()(entries[1]));
  EXPECT_LT((open - expected).norm(), 1e-6 * expected.norm());
}

TEST(OpenMotion, IsWhatAMixtureOfFiltersHasBeyondOne) {
  ExpectMixture(true);
  ExpectMixture(false);
}

TEST(OpenMotion, IsNothingWhereTheDensityIsGiven) {
  MotionBanks::Prediction before;
  before.linear = before.angular = ClassesOf({1, 1e6}, {0.5, 0.5});
  before.dt_s = kDtS;
  EXPECT_EQ(OpenMotion(before, Arrive(DrawFrame(2e-3, 1e-2))).norm(), 0);
}

// Tags that tell a million times more than the prediction: what the difference to their pose says
// is lost to rounding. The pose stays as they have it, and no class of all becomes likely for that.
TEST(OpenMotion, HoldsWhereTheTagsTellNearlyAll) {
  const Frame frame = DrawFrame(1, 1e-6);
  ArrivedState arrived = Arrive(frame);
  arrived.linear = arrived.angular = MotionPrior{WhiteNoiseOn::kJerk, 10};
  MotionBanks::Prediction before;
  before.linear = before.angular = ClassesOf({10, 1e8}, {0.99, 0.01});
  before.dt_s = kDtS;
  const StateCovariance open = OpenMotion(before, arrived);
  ASSERT_TRUE(open.allFinite());
  EXPECT_LT(open.diagonal().head<6>().maxCoeff(), 1e-10);
}

}  // namespace
}  // namespace tagtwist::internal::open_motion_test

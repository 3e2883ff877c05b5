#include "estimator/linear/class_filters.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace tagtwist::internal::class_filters_test {
namespace {

using Covariance = Eigen::Matrix<double, 9, 9>;
using State = ClassFilters::State;
using Filter = ClassFilters::Filter;

// A filter written as a whole.
struct Dense {
  State mean;
  Covariance covariance;
};

Filter Packed(const Dense& dense) {
  Filter out = Filter::Zero();
  out.head<9>() = dense.mean;
  for (int i = 0; i < 3; ++i) {
    for (int j = i; j < 3; ++j) {
      Eigen::Map<Eigen::Matrix3d>(out.data() + ClassFilters::kBlocks[i][j]) =
          dense.covariance.block<3, 3>(3 * i, 3 * j);
    }
  }
  return out;
}

// As many that have nothing in common.
std::vector<Dense> Draw(size_t n, std::mt19937* rng) {
  std::normal_distribution<double> normal;
  std::vector<Dense> out(n);
  for (Dense& dense : out) {
    const auto draw = [&](double) { return normal(*rng); };
    dense.mean = State::NullaryExpr(draw);
    const Covariance root = Covariance::NullaryExpr(draw);
    dense.covariance = root * root.transpose();
  }
  return out;
}

ClassFilters Make(const std::vector<Dense>& dense) {
  ClassFilters out(dense.size(), Filter::Zero());
  for (size_t i = 0; i < dense.size(); ++i) out.Set(i, Packed(dense[i]));
  return out;
}

void ExpectNear(const ClassFilters& filters, const std::vector<Dense>& expected) {
  for (size_t i = 0; i < expected.size(); ++i) {
    const Filter packed = Packed(expected[i]);
    EXPECT_LT((filters.Of(i) - packed).cwiseAbs().maxCoeff(),
              1e-10 * std::max(1.0, packed.cwiseAbs().maxCoeff()))
        << "class " << i << " of " << expected.size();
  }
}

Covariance ForAllAxes(const Eigen::Matrix3d& of_axis) {
  Covariance out;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      out.block<3, 3>(3 * i, 3 * j) = of_axis(i, j) * Eigen::Matrix3d::Identity();
    }
  }
  return out;
}

// More and fewer than are done side by side.
class ClassFiltersOf : public ::testing::TestWithParam<size_t> {
 protected:
  std::mt19937 rng_{12};
  std::vector<Dense> dense_ = Draw(GetParam(), &rng_);
  ClassFilters filters_ = Make(dense_);
};

TEST_P(ClassFiltersOf, PredictAsAKalmanFilterDoes) {
  Eigen::Matrix3d f, q;
  f << 1, 0.3, 0.045, 0, 0.9, 0.3, 0, 0, 0.8;
  q << 0.05, 0.04, 0.03, 0.04, 0.06, 0.02, 0.03, 0.02, 0.07;
  std::vector<double> densities;
  for (Dense& dense : dense_) {
    densities.push_back(std::pow(10.0, static_cast<double>(densities.size()) / 4));
    const Covariance whole = ForAllAxes(f);
    dense.mean = (whole * dense.mean).eval();
    dense.covariance =
        (whole * dense.covariance * whole.transpose() + densities.back() * ForAllAxes(q)).eval();
  }
  filters_.Predict(f, q, densities);
  ExpectNear(filters_, dense_);
}

TEST_P(ClassFiltersOf, UpdateAsAKalmanFilterDoes) {
  const Dense& drawn = dense_.front();
  const Eigen::Matrix3d r = drawn.covariance.topLeftCorner<3, 3>() + Eigen::Matrix3d::Identity();
  const Eigen::Vector3d x(0.5, -1, 2);
  ClassFilters alone = filters_;
  filters_.Update(x, r);
  for (size_t i = 0; i < dense_.size(); ++i) {
    Dense& dense = dense_[i];
    const Eigen::Matrix3d s = dense.covariance.topLeftCorner<3, 3>() + r;
    const Eigen::Vector3d error = x - dense.mean.head<3>();
    EXPECT_NEAR(filters_.LogLikelihood(i),
                -0.5 * (error.dot(s.inverse() * error) + std::log(s.determinant())), 1e-10);
    const Eigen::Matrix<double, 9, 3> gain = dense.covariance.leftCols<3>() * s.inverse();
    dense.mean += gain * error;
    dense.covariance -= (gain * s * gain.transpose()).eval();
    alone.UpdateOne(i, x, r);
    EXPECT_NEAR(alone.LogLikelihood(i), filters_.LogLikelihood(i), 1e-10);
  }
  ExpectNear(filters_, dense_);
  ExpectNear(alone, dense_);
}

TEST_P(ClassFiltersOf, MixToTheMomentsOfTheMixture) {
  std::uniform_real_distribution<double> uniform(0.1, 1);
  const size_t n = dense_.size();
  constexpr double kKeep = 0.7;
  std::vector<double> weights(n), gives(n), wholes(n);
  for (size_t i = 0; i < n; ++i) weights[i] = uniform(rng_);
  for (size_t i = 0; i < n; ++i) gives[i] = uniform(rng_);
  std::vector<Dense> expected(n);
  for (size_t j = 0; j < n; ++j) {
    State first = State::Zero();
    Covariance second = Covariance::Zero();
    for (size_t i = 0; i < n; ++i) {
      const double weight = i == j ? kKeep * weights[i] : i <= j + 1 ? gives[i] : 0;
      wholes[j] += weight;
      first += weight * dense_[i].mean;
      second +=
          weight * (dense_[i].covariance + dense_[i].mean * dense_[i].mean.transpose()).eval();
    }
    expected[j].mean = first / wholes[j];
    expected[j].covariance = second / wholes[j] - expected[j].mean * expected[j].mean.transpose();
  }
  filters_.Mix(kKeep, gives, dense_.front().mean, &weights);
  for (size_t j = 0; j < n; ++j) EXPECT_NEAR(weights[j], wholes[j], 1e-12);
  ExpectNear(filters_, expected);
}

TEST_P(ClassFiltersOf, TurnAndMoveWithTheirOrigin) {
  const Eigen::Matrix3d r =
      Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, -2) / 3).toRotationMatrix();
  Covariance whole = Covariance::Identity();
  whole.topLeftCorner<3, 3>() = r;
  const State by = State::LinSpaced(-1, 3);
  for (Dense& dense : dense_) {
    dense.mean = (whole * dense.mean + by).eval();
    dense.covariance = (whole * dense.covariance * whole.transpose()).eval();
  }
  filters_.Turn(r);
  filters_.Move(by);
  ExpectNear(filters_, dense_);
  const std::vector<double> weights(dense_.size(), 1.0 / static_cast<double>(dense_.size()));
  State mean = State::Zero();
  for (const Dense& dense : dense_) mean += dense.mean / static_cast<double>(dense_.size());
  EXPECT_LT((filters_.Mean(weights) - mean).norm(), 1e-12);
}

INSTANTIATE_TEST_SUITE_P(Numbers, ClassFiltersOf, ::testing::Values(1, 3, 4, 6, 8, 17));

// After an hour without a measurement the prediction is no help, and its variance is far above the
// measurement's: what is left is the measurement's, not rounding.
TEST(ClassFilters, KnowWhatWasMeasuredAfterALongGap) {
  ClassFilters filters(5, Filter::Zero());
  Eigen::Matrix3d f, q;
  const double dt = 3600;
  f << 1, dt, dt * dt / 2, 0, 1, dt, 0, 0, 1;
  q << std::pow(dt, 5) / 20, std::pow(dt, 4) / 8, std::pow(dt, 3) / 6, std::pow(dt, 4) / 8,
      std::pow(dt, 3) / 3, dt * dt / 2, std::pow(dt, 3) / 6, dt * dt / 2, dt;
  filters.Predict(f, q, std::vector<double>(5, 1e8));
  const Eigen::Matrix3d r = Eigen::Vector3d(1e-10, 2e-10, 3e-10).asDiagonal();
  filters.Update(Eigen::Vector3d(1, 2, 3), r);
  for (size_t i = 0; i < 5; ++i) {
    EXPECT_TRUE(std::isfinite(filters.LogLikelihood(i)));
    const Filter filter = filters.Of(i);
    const Eigen::Map<const Eigen::Matrix3d> xx(filter.data() + ClassFilters::kXx);
    EXPECT_LT((xx - r).norm(), 1e-9 * r.norm());
    EXPECT_LT((filter.head<3>() - Eigen::Vector3d(1, 2, 3)).norm(), 1e-9);
    for (const auto block : {ClassFilters::kVv, ClassFilters::kAa}) {
      EXPECT_GT(Eigen::Map<const Eigen::Matrix3d>(filter.data() + block).diagonal().minCoeff(), 0);
    }
  }
}

}  // namespace
}  // namespace tagtwist::internal::class_filters_test

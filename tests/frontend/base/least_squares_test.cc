#include "frontend/base/least_squares.h"

#include <gtest/gtest.h>

#include <cmath>

namespace tagtwist::internal::least_squares_test {
namespace {

// Rosenbrock's valley as least squares: residuals 10 (y - x^2) and 1 - x.
struct Valley {
  using State = Eigen::Vector2d;
  using Normals = QuadraticForm<2>;
  int linearised = 0;

  std::optional<Normals> Linearise(const State& at) {
    ++linearised;
    if (at.x() > 1.5) return std::nullopt;
    Eigen::Matrix2d jacobian;
    jacobian << -20 * at.x(), 10, -1, 0;
    const Eigen::Vector2d residual(10 * (at.y() - at.x() * at.x()), 1 - at.x());
    Normals out;
    out.Add(jacobian, residual, 0.5 * residual.squaredNorm());
    return out;
  }
  auto Solve(const State& /*at*/, double damping, Normals* normals) const {
    return DampedStep(*normals, damping);
  }
  State Step(const State& at, const Eigen::Vector2d& dx) const { return at + dx; }
};

LeastSquaresOptions Options() {
  LeastSquaresOptions options;
  options.max_steps = 100;
  options.absolute_tolerance = 1e-20;
  return options;
}

TEST(LeastSquares, FollowsAValleyToItsLowestPoint) {
  Valley valley;
  const auto out = SolveLeastSquares(valley, Eigen::Vector2d(-1.2, 1.0), Options());
  EXPECT_TRUE(out.converged());
  EXPECT_LT((out.x - Eigen::Vector2d(1, 1)).norm(), 1e-9);
  EXPECT_NEAR(out.cost, 0, 1e-18);
  EXPECT_GT(out.steps, 3);  // the first full step raises the cost
}

// Residuals x and 1 + 0.05 x^2: each step leaves a tenth of the error, with the other sign.
struct Linear {
  using State = double;
  using Normals = QuadraticForm<1>;
  using Vector = Normals::Vector;

  static std::optional<Normals> Linearise(double x) {
    const Eigen::Vector2d residual(x, 1 + 0.05 * x * x), jacobian(1, 0.1 * x);
    Normals out;
    out.Add(jacobian, residual, 0.5 * residual.squaredNorm());
    return out;
  }
  static auto Solve(double /*x*/, double damping, Normals* normals) {
    return DampedStep(*normals, damping);
  }
  static double Step(double x, const Vector& dx) { return x + dx(0); }
};

// Half of the square of what is left is what the next step would lower the cost by.
TEST(LeastSquares, TheLastTwoStepsForetellTheNext) {
  Linear linear;
  LeastSquaresOptions options;
  options.tolerance_of_next = 0.5e-10;
  const auto foretold = SolveLeastSquares(linear, 1.0, options);
  EXPECT_TRUE(foretold.converged());
  EXPECT_LT(std::abs(foretold.x), 1e-5);
  EXPECT_GT(std::abs(foretold.x), 1e-7);
  options.tolerance_of_next = 0;
  options.absolute_tolerance = 0.5e-10;
  EXPECT_EQ(SolveLeastSquares(linear, 1.0, options).steps, foretold.steps + 1);
}

// A step beyond x = 1.5 has no cost: it is damped until it has one.
TEST(LeastSquares, GoesAroundWhereTheCostHasNoValue) {
  Valley valley;
  const auto out = SolveLeastSquares(valley, Eigen::Vector2d(0.01, 20), Options());
  EXPECT_TRUE(out.converged());
  EXPECT_LT((out.x - Eigen::Vector2d(1, 1)).norm(), 1e-9);
}

TEST(LeastSquares, EndsAreTold) {
  Valley valley;
  EXPECT_EQ(SolveLeastSquares(valley, Eigen::Vector2d(2, 0), Options()).end,
            LeastSquaresEnd::kNotEvaluable);
  LeastSquaresOptions options = Options();
  options.max_steps = 2;
  const auto few = SolveLeastSquares(valley, Eigen::Vector2d(-1.2, 1.0), options);
  EXPECT_EQ(few.end, LeastSquaresEnd::kStepLimit);
  EXPECT_LT(few.cost, 12.1);  // half of 4.4^2 + 2.2^2 where it starts
  EXPECT_EQ(few.steps, 2);
  options = Options();
  options.time_up = [] { return true; };
  const auto hurried = SolveLeastSquares(valley, Eigen::Vector2d(-1.2, 1.0), options);
  EXPECT_EQ(hurried.end, LeastSquaresEnd::kTimeUp);
  EXPECT_EQ(hurried.steps, 1);
  struct WellKnown : Valley {  // its first step is its last
    auto Solve(const State& at, double damping, Normals* normals) const {
      auto step = Valley::Solve(at, damping, normals);
      step->is_last = true;
      return step;
    }
  } well_known;
  EXPECT_EQ(SolveLeastSquares(well_known, Eigen::Vector2d(-1.2, 1.0), Options()).steps, 1);
}

// One unknown, whose cost no step lowers: the Jacobian points the wrong way.
struct Uphill {
  using State = double;
  using Normals = QuadraticForm<1>;
  std::optional<Normals> Linearise(double x) const {
    Normals out;
    out.cost = 1 + x * x;
    out.hessian(0, 0) = flat ? 0 : 1;
    out.gradient(0) = -1;
    return out;
  }
  auto Solve(double /*x*/, double damping, Normals* normals) const {
    return DampedStep(*normals, damping);
  }
  double Step(double x, const Eigen::Matrix<double, 1, 1>& dx) const { return x + dx(0); }
  bool flat = false;
};

TEST(LeastSquares, GivesUpWhereNoStepHelpsOrNoneIsDetermined) {
  Uphill uphill;
  const auto out = SolveLeastSquares(uphill, 0.5, Options());
  EXPECT_EQ(out.end, LeastSquaresEnd::kStuck);
  EXPECT_EQ(out.x, 0.5);
  uphill.flat = true;
  const auto flat = SolveLeastSquares(uphill, 0.5, Options());
  EXPECT_EQ(flat.end, LeastSquaresEnd::kStuck);
  EXPECT_EQ(flat.steps, 0);
}

TEST(LeastSquares, TakesAnyStepWhereAskedTo) {
  Uphill uphill;
  LeastSquaresOptions options = Options();
  options.takes_any_step = true;
  options.max_steps = 3;
  EXPECT_EQ(SolveLeastSquares(uphill, 0.5, options).x, 3.5);
}

TEST(QuadraticForm, IsTheSquareThatItWasMadeOf) {
  const Eigen::Matrix<double, 3, 2> jacobian = Eigen::Matrix<double, 3, 2>::Random();
  const Eigen::Vector3d residual = Eigen::Vector3d::Random();
  QuadraticForm<2> form;
  form.Add(jacobian, residual, 0.5 * residual.squaredNorm());
  const Eigen::Vector2d d(0.3, -2);
  const Eigen::Vector3d there = residual + jacobian * d;
  double cost = 5;
  const Eigen::Vector2d gradient = form.GradientAtMoved(d, &cost);
  EXPECT_NEAR(cost, 5 + 0.5 * there.squaredNorm(), 1e-12);
  EXPECT_LT((gradient - jacobian.transpose() * there).norm(), 1e-12);
}

}  // namespace
}  // namespace tagtwist::internal::least_squares_test

#include "estimator/motion/bank/motion_bank.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <string>

#include "tests/support/draws.h"

namespace tagtwist::internal::motion_bank_test {
namespace {

constexpr double kSigmaM = 0.5e-3;

// Position at a time [s]; none of these is a motion that a bank's model draws.
using Path = std::function<double(double)>;

double Step(double x) {
  const double y = std::clamp(x, 0.0, 1.0);
  return y * y * y * (10 - 15 * y + 6 * y * y);
}

// Bang-bang acceleration to a speed and back to rest, forth and back.
double Trapezoid(double t) {
  constexpr double kRamp = 0.4, kCruise = 1.0, kAcceleration = 3, kPeriod = 4;
  const double leg = std::floor(t / kPeriod), u = std::clamp(t - kPeriod * leg - 1, 0.0, 2.4);
  const double speed = kAcceleration * kRamp, whole = speed * (kRamp + kCruise);
  double x = 0;
  if (u < kRamp) {
    x = 0.5 * kAcceleration * u * u;
  } else if (u < 2 * kRamp + kCruise) {
    const double v = std::max(0.0, u - kRamp - kCruise);
    x = 0.5 * speed * kRamp + speed * (u - kRamp) - 0.5 * kAcceleration * v * v;
  } else {
    x = whole;
  }
  return static_cast<int>(leg) % 2 == 0 ? x : whole - x;
}

struct Flight {
  std::string name;
  Path path;
};

std::vector<Flight> Flights(unsigned seed) {
  std::mt19937 rng(seed);
  std::uniform_real_distribution<double> about(0.7, 1.4);
  const double pi2 = 2 * M_PI;
  const double a = 0.4 * about(rng), f = 0.25 * about(rng), start = 15 * about(rng);
  const double buzz_m = 0.004 * about(rng), buzz_hz = 7 * about(rng), blow_m = 0.3 * about(rng);
  const Path sway = [=](double t) { return a * std::sin(pi2 * f * t + 0.3); };
  return {
      {"rest", [](double) { return 0.0; }},
      {"sines", sway},
      {"agile", [=](double t) { return a * std::sin(pi2 * 4 * f * t) + 0.1 * sway(2 * t); }},
      {"take_off", [=](double t) { return Step((t - start) / 2) * (0.5 + sway(t - start)); }},
      {"trapezoid", Trapezoid},
      {"stop_and_go",
       [=](double t) {
         const double u = std::fmod(t, 5);
         const bool moves = static_cast<int>(t / 5) % 2 == 1;
         return moves ? a * std::sin(pi2 * u) * Step(u / 0.5) * Step((5 - u) / 0.5) : 0;
       }},
      {"vibration",
       [=](double t) {
         return sway(0.4 * t) + (t > start ? buzz_m * std::sin(pi2 * buzz_hz * t) : 0);
       }},
      {"hit",
       [=](double t) { return t > start ? blow_m * (1 - std::exp((start - t) / 0.05)) : 0; }},
  };
}

Eigen::Vector3d At(const Path& path, double t) { return path(t) * Eigen::Vector3d(1, -0.6, 0.2); }

struct Score {
  double rms_m = 0, nees = 0, beyond = 0;  // NEES of position and velocity a degree of freedom
};

Score Follow(const Path& path, double rate_hz, MotionBank bank) {
  const double dt = 1 / rate_hz;
  const int n = static_cast<int>(40 * rate_hz),
            skip = std::min(n / 4, static_cast<int>(3 * rate_hz));
  std::mt19937_64 rng(5);
  std::normal_distribution<double> noise(0, kSigmaM);
  Score out;
  for (int k = 0; k < n; ++k) {
    const double t = k * dt;
    const Eigen::Vector3d x = At(path, t);
    if (k > 0) bank.Predict(dt);
    bank.Measure(x + DrawVector<3>(noise, rng), kSigmaM * kSigmaM * Eigen::Matrix3d::Identity());
    if (k < skip) continue;
    Eigen::Matrix<double, 6, 1> e = bank.Mean().head<6>();
    e.head<3>() -= x;
    e.tail<3>() -= (At(path, t + 1e-5) - At(path, t - 1e-5)) / 2e-5;
    const double squared = e.dot(bank.MixtureCovariance().topLeftCorner<6, 6>().inverse() * e);
    out.rms_m += e.head<3>().squaredNorm() / (n - skip);
    out.nees += squared / 6 / (n - skip);
    out.beyond += (squared > 43 ? 1.0 : 0.0) / (n - skip);  // 5 sigma, of one dimension
  }
  out.rms_m = std::sqrt(out.rms_m);
  return out;
}

double BestSingleDensity(const Path& path, double rate_hz) {
  double best = std::numeric_limits<double>::max();
  for (double q = 1e-8; q < 1e8; q *= 10) {
    MotionBankOptions one;
    one.classes = 1;
    one.least_density = q;
    best = std::min(best, Follow(path, rate_hz, MotionBank(one)).rms_m);
  }
  return best;
}

class BankFollows : public testing::TestWithParam<double> {};

// As good as the one density that an oracle would choose, and honest, which no density is on a
// motion that is now at rest and now is not.
TEST_P(BankFollows, FlightsThatAreNotItsOwn) {
  const double rate_hz = GetParam();
  for (const unsigned seed : {1U, 2U}) {
    for (const Flight& flight : Flights(seed)) {
      // Nothing follows what is sampled less than twice a period.
      if (flight.name == "vibration" && rate_hz < 20) continue;
      const Score score = Follow(flight.path, rate_hz, MotionBank(MotionBankOptions()));
      const double best = BestSingleDensity(flight.path, rate_hz);
      SCOPED_TRACE(flight.name + ", seed " + std::to_string(seed));
      EXPECT_LT(score.rms_m, 1.15 * best);
      EXPECT_GT(score.nees, 0.2);
      EXPECT_LT(score.nees, 6);  // the frames in which a jump of the acceleration does not show yet
      EXPECT_LT(score.beyond, 0.02);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Rates, BankFollows, testing::Values(5.0, 30.0));
INSTANTIATE_TEST_SUITE_P(SlowRates, BankFollows, testing::Values(200.0));

TEST(MotionBank, FindsTheDensityOfItsOwnModel) {
  for (const WhiteNoiseOn on : {WhiteNoiseOn::kJerk, WhiteNoiseOn::kAcceleration}) {
    for (const double density : {1e-2, 1.0, 100.0}) {
      const MotionPrior prior{on, density};
      const Eigen::Matrix3d f = Transition(on, 0.02);
      Eigen::Matrix3d q = ProcessCovariance(prior, 0.02);
      if (on == WhiteNoiseOn::kAcceleration) q(2, 2) = 1e-30;
      const Eigen::Matrix3d root = q.llt().matrixL();
      std::mt19937_64 rng(3);
      std::normal_distribution<double> normal;
      Eigen::Matrix3d x = Eigen::Matrix3d::Zero();  // a column an axis
      MotionBank bank(LinearBankOptions(on));
      double mean_log = 0;
      for (int k = 0; k < 1000; ++k) {
        bank.Predict(0.02);
        const Eigen::Matrix3d drawn = Eigen::Matrix3d::NullaryExpr([&] { return normal(rng); });
        x = f * x + root * drawn;
        const Eigen::Vector3d noise = Eigen::Vector3d::NullaryExpr([&] { return normal(rng); });
        bank.Measure(x.row(0).transpose() + 1e-3 * noise, 1e-6 * Eigen::Matrix3d::Identity());
        if (k >= 500) mean_log += std::log10(bank.Density()) / 500;
      }
      EXPECT_NEAR(mean_log, std::log10(density), 0.8) << density;  // half a class is 0.75
    }
  }
}

TEST(MotionBank, RisesWithinAFrameAndComesDownOneClassAtATime) {
  MotionBank bank{MotionBankOptions()};
  const Eigen::Matrix3d covariance = kSigmaM * kSigmaM * Eigen::Matrix3d::Identity();
  for (int k = 0; k < 300; ++k) {
    bank.Predict(0.033);
    bank.Measure(Eigen::Vector3d::Zero(), covariance);
  }
  const double at_rest = bank.Density();
  EXPECT_LT(at_rest, 1e-4);
  bank.Predict(0.033);
  bank.Measure(Eigen::Vector3d(0.05, 0, 0), covariance);
  EXPECT_GT(bank.Density(), 1e3);
  EXPECT_LT((bank.Mean().head<3>() - Eigen::Vector3d(0.05, 0, 0)).norm(), 3 * kSigmaM);
}

TEST(MotionBank, AfterALongGapTheMeasurementSaysWhereItIs) {
  MotionBank bank{MotionBankOptions()};
  const Eigen::Matrix3d covariance = kSigmaM * kSigmaM * Eigen::Matrix3d::Identity();
  for (const double gap_s : {0.1, 10.0, 300.0}) {
    for (int k = 0; k < 100; ++k) {
      bank.Predict(0.01);
      bank.Measure(Eigen::Vector3d(0.01 * k, 0, 0), covariance);
    }
    bank.Predict(gap_s);
    bank.Measure(Eigen::Vector3d(5, 5, 5), covariance);
    EXPECT_LT((bank.Mean().head<3>() - Eigen::Vector3d(5, 5, 5)).norm(), 4 * kSigmaM) << gap_s;
    const MotionBank::Covariance p = bank.MixtureCovariance();
    EXPECT_TRUE(p.llt().info() == Eigen::Success) << gap_s;
  }
}

// Stamps in pairs: metres a second for half a millisecond, then rest.
TEST(MotionBank, StaysFiniteUnderAbsurdTimes) {
  MotionBank bank(AngularBankOptions(WhiteNoiseOn::kJerk));
  const Eigen::Matrix3d covariance = 1e-8 * Eigen::Matrix3d::Identity();
  for (int k = 0; k < 400; ++k) {
    bank.Predict(k % 2 == 0 ? 0.0662 : 5e-4);
    bank.Measure(Eigen::Vector3d(std::sin(0.1 * k), std::cos(0.07 * k), 0.3 * (k % 7)), covariance);
    ASSERT_TRUE(std::isfinite(bank.log_likelihood())) << k;
    ASSERT_TRUE(bank.Mean().allFinite()) << k;
    ASSERT_TRUE(std::isfinite(bank.Density())) << k;
  }
}

// Long rest makes the livelier classes all but impossible; what comes then makes the calm ones so,
// which are told of places that are metres apart by what the others knew.
TEST(MotionBank, VariancesStayPositiveWhereAClassIsImpossible) {
  for (const WhiteNoiseOn on : {WhiteNoiseOn::kJerk, WhiteNoiseOn::kAcceleration}) {
    MotionBank bank(AngularBankOptions(on));
    for (int k = 0; k < 200; ++k) {
      bank.Predict(k % 5 == 0 ? 0.2 : 0.033);
      const double x = k % 40 < 20 ? 0 : 2 * std::sin(3.0 * k);
      bank.Measure({x, 0.3 * x, -x}, Eigen::Vector3d(4e-8, 3e-8, 4e-9).asDiagonal());
      ASSERT_TRUE(bank.ExcessVariance().allFinite()) << k;
      ASSERT_GT(bank.MixtureCovariance().diagonal().minCoeff(), on == WhiteNoiseOn::kJerk ? 0 : -1);
    }
  }
}

TEST(MotionBank, MovingTheOriginChangesNothingElse) {
  MotionBank bank{MotionBankOptions()}, moved = bank;
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  const Eigen::Vector3d origin(1, 2, 3);
  Eigen::Matrix3d covariance = Eigen::Vector3d(1e-6, 4e-6, 9e-6).asDiagonal();
  for (int k = 0; k < 20; ++k) {
    bank.Predict(0.05);
    bank.Measure(Eigen::Vector3d(std::sin(0.3 * k), 0.1 * k, 0), covariance);
  }
  moved = bank;
  moved.TurnOrigin(turn);
  moved.MoveOrigin(origin);
  const Eigen::Vector3d x(0.1, 2, 0.01);
  bank.Measure(x, covariance);
  moved.Measure(turn * x - origin, turn * covariance * turn.transpose());
  EXPECT_NEAR(bank.log_likelihood(), moved.log_likelihood(), 1e-6);
  EXPECT_LT((turn * bank.Mean().head<3>() - origin - moved.Mean().head<3>()).norm(), 1e-9);
  EXPECT_LT((bank.Mean().tail<6>() - moved.Mean().tail<6>()).norm(), 1e-6);
}

}  // namespace
}  // namespace tagtwist::internal::motion_bank_test

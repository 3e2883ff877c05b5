#include "frontend/base/ratio_statistic.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "frontend/base/statistics/chi_square.h"

namespace tagtwist {

using namespace internal;
namespace {

// The standard normal deviate of Student's t.
double NormalOfStudent(double t, size_t blocks) {
  const auto dof = static_cast<double>(blocks - 1);
  const double size = std::sqrt(dof * std::log1p(t * t / dof)) * (8 * dof + 1) / (8 * dof + 3);
  return std::copysign(size, t);
}

double ScoreOf(double difference, double variance, size_t blocks) {
  if (blocks < RatioStatistic::kLeastBlocks || difference == 0) return 0;
  if (!(variance > 0)) return std::copysign(std::numeric_limits<double>::infinity(), difference);
  return NormalOfStudent(difference / std::sqrt(variance), blocks);
}

}  // namespace

void RatioStatistic::CloseBlock() {
  if (open_weight_ != 0) {
    ++blocks_;
    value_ += open_value_;
    weight_ += open_weight_;
    value_value_ += open_value_ * open_value_;
    value_weight_ += open_value_ * open_weight_;
    weight_weight_ += open_weight_ * open_weight_;
  }
  open_value_ = open_weight_ = 0;
}

double RatioStatistic::variance() const {
  if (blocks_ < 2) return std::numeric_limits<double>::infinity();
  const double r = ratio(), n = static_cast<double>(blocks_);
  const double squares = value_value_ - 2 * r * value_weight_ + r * r * weight_weight_;
  return std::max(0.0, squares) / (weight_ * weight_) * n / (n - 1);
}

double RatioStatistic::Score(double expected) const {
  return ScoreOf(ratio() - expected, variance(), blocks_);
}

double ScoreOfDifference(const RatioStatistic& a, const RatioStatistic& b) {
  return ScoreOf(a.ratio() - b.ratio(), a.variance() + b.variance(),
                 std::min(a.blocks(), b.blocks()));
}

double SignificantScore(size_t tests) {
  constexpr double kFalseAlarms = 1e-3;
  const double each = kFalseAlarms / static_cast<double>(std::max<size_t>(1, tests));
  return std::sqrt(ChiSquareQuantile(1 - each, 1));
}

}  // namespace tagtwist

#pragma once
#include <cstddef>

namespace tagtwist {

/// A mean of correlated values, with its standard deviation: values are summed block by block, and
/// blocks (a second of a recording) count as independent. ratio = sum of values / sum of weights;
/// its variance is that of a ratio estimator, sum (v_b - ratio w_b)^2 / w^2 * n / (n - 1) over n
/// blocks (Cochran, Sampling Techniques, 1977, Eq. 6.13). Memory does not grow.
class RatioStatistic {
 public:
  /// Into the open block.
  void Add(double value, double weight = 1) {
    open_value_ += value;
    open_weight_ += weight;
  }
  /// A block without weight does not count.
  void CloseBlock();

  /// Figures of the closed blocks.
  size_t blocks() const { return blocks_; }
  double weight() const { return weight_; }
  double ratio() const { return value_ / weight_; }  // NaN without blocks
  double variance() const;                           // infinite for fewer than two blocks
  /// How far the ratio lies from `expected`, as the standard normal deviate that is as improbable
  /// as Student's t here (n - 1 degrees of freedom; Wallace, Annals of Math. Stat. 30, 1959). 0 for
  /// fewer than kLeastBlocks blocks: too few to say that they differ.
  double Score(double expected) const;
  static constexpr size_t kLeastBlocks = 5;

 private:
  size_t blocks_ = 0;
  double value_ = 0, weight_ = 0, open_value_ = 0, open_weight_ = 0;
  double value_value_ = 0, value_weight_ = 0, weight_weight_ = 0;
};

/// The score of the difference of two independent ratios; degrees of freedom of the smaller one.
double ScoreOfDifference(const RatioStatistic& a, const RatioStatistic& b);

/// Scores beyond this, either way, come up by chance in one of a thousand families of `tests`
/// tests (Bonferroni).
double SignificantScore(size_t tests);

}  // namespace tagtwist

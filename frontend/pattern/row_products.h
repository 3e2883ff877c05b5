#pragma once
#include <Eigen/Core>
#include <array>

#include "frontend/pattern/pattern_state.h"

namespace tagtwist::internal {

/// The sums of a normal matrix over rows of kPatternUnknowns entries, a chunk of rows at a time, in
/// single precision.
class RowProducts {
 public:
  static constexpr int kChunk = 64;
  using Column = Eigen::Array<float, kChunk, 1>;
  using Rows = Eigen::Matrix<float, kChunk, kPatternUnknowns>;

  RowProducts();
  void Add(const Rows& rows, const Column& weights, const Column& residuals);
  /// normal: sum w row row'; gradient: sum w row residual.
  void Finish(Eigen::Matrix<double, kPatternUnknowns, kPatternUnknowns>* normal,
              PatternVector* gradient) const;

 private:
  using Quad = Eigen::Array4f;
  void AddBlock(const Rows& rows, int i, int k);

  Rows weighted_;
  // Lower triangle; the sum of a Quad's entries is an entry.
  std::array<std::array<Quad, kPatternUnknowns>, kPatternUnknowns> products_;
  std::array<Quad, kPatternUnknowns> gradient_;
};

}  // namespace tagtwist::internal

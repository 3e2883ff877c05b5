#pragma once
#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "estimator/graph/graph_builder.h"
#include "estimator/graph/noise_model.h"
#include "estimator/systematic/systematic_basis.h"

namespace tagtwist::internal {

/// Errors of a set-up that last, as they are known while frames come: at first what is given of
/// them, then what residuals show (LearnSystematicErrors), anew each time that twice as many frames
/// have passed. Keeps a bounded number of frames, spread over all that came.
class LastingErrors {
 public:
  explicit LastingErrors(const EstimatorSetup& setup);

  /// Takes a frame at its solution, with the tags that count in it; true: what is known of the
  /// errors has changed. Most frames are not kept, and not copied.
  bool Add(const NoiseModel& noise, int64_t t_ns, const BodyState& state,
           const std::vector<TagDetection>& tags);

  /// Whether there are any.
  bool AreAny() const { return root_ || are_given_; }
  const SystematicBasis& basis() const { return basis_; }
  /// Rows, effects of the basis' parameters, times a square root of the parameters' covariance.
  Eigen::MatrixXd TimesRoot(const Eigen::MatrixXd& effects) const;

 private:
  bool Learn(const NoiseModel& noise);

  EstimatorSetup setup_;
  SystematicBasis basis_;
  bool are_given_;
  std::optional<Eigen::MatrixXd> root_;  // learned; parameters x columns
  std::vector<int> unlearned_;           // parameters of tags that were not seen then,
  double tag_sigma_m_ = 0;               // and what is learned of all
  std::vector<GraphFrame> frames_;
  size_t stride_ = 1, passed_ = 0, next_;  // one of so many is kept; frames at the next turn
};

}  // namespace tagtwist::internal

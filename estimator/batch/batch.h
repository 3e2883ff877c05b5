#pragma once
#include <memory>
#include <vector>

#include "estimator/graph/estimator_options.h"
#include "estimator/imu/imu_options.h"
#include "estimator/result/estimate.h"
#include "frontend/base/for_ranges.h"
#include "frontend/base/result.h"
#include "frontend/base/spans.h"
#include "frontend/types/measurements.h"
#include "frontend/types/rig.h"

namespace tagtwist {

/// Refines a whole recording in one sparse problem; noise that is not given is learned from it.
/// Takes the frames one by one and keeps of each only what the problem needs. Under a rolling
/// shutter it solves twice: the second time for the tags as they would have been seen at the
/// frames' stamps, by the states of the first; and without tracks, for nothing tells in which row
/// their points were.
class BatchEstimator {
 public:
  /// `for_ranges`: how work that can be split is done; the result does not depend on it. `spans` is
  /// told of the stages "start", "solve" (which learns the noise), "covariance" and "rows" of each
  /// solution; it must outlive the estimator. nullptr: nobody.
  BatchEstimator(const SetUp& set_up, const EstimatorOptions& options,
                 ForRanges for_ranges = InOneRange, SpanObserver* spans = nullptr);
  BatchEstimator(BatchEstimator&&) noexcept;
  BatchEstimator& operator=(BatchEstimator&&) noexcept;
  ~BatchEstimator();

  /// An IMU on the body, whose record covers frames that come: then the frames that it covers have
  /// states, tags or not, and there are no tracks. Where it does not go with what the tags say the
  /// estimate is without it, and a warning tells why. Before the first frame.
  void Use(ImuRecord imu);
  /// Stamps must grow.
  void Add(FrameMeasurements measurement);
  /// Solves for all frames. An error when no frame has a usable tag, there is no solution, or what
  /// is seen cannot be what the set-up says.
  Result<Estimate> Solve() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

/// BatchEstimator over measurements at hand.
Result<Estimate> RunBatch(const SetUp& set_up, const EstimatorOptions& options,
                          const std::vector<FrameMeasurements>& measurements);

}  // namespace tagtwist

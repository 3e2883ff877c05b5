#pragma once
#include <deque>
#include <optional>
#include <vector>

#include "estimator/graph/linear_system.h"
#include "estimator/graph/noise_model.h"
#include "estimator/solve/noise_learning.h"
#include "estimator/solve/smoother.h"
#include "residuals/motion_residual.h"
#include "residuals/tag_reprojection_residual.h"

namespace tagtwist {

/// Consecutive frames without tracks, solved again and again while their noise is learned. Each
/// frame's tags are a quadratic form in its pose, linearised again only where the pose has moved by
/// more than the form holds; corners without a covariance of their own keep it from one sigma to
/// the next. No factor is made, nothing else allocated but the normal equations.
class FrameChain {
 public:
  /// Whether the input has this shape: no usable track, no prior from before.
  static bool Fits(const EstimatorSetup& setup, const GraphInput& input);

  /// Starts from the input's states; both must outlive the chain.
  FrameChain(const EstimatorSetup& setup, const GraphInput& input);

  /// What SolveAndInvert gives, but for the graph's factors, from the last states on. Poses may
  /// move by `neglected` [standard deviations times rad or m] before their tags are linearised
  /// again. nullopt where a step raises the cost or a tag cannot be seen: a job for damped steps.
  std::optional<Solution> Solve(const NoiseModel& noise, const SolveOptions& options,
                                double neglected);

  /// ComputeNoiseStatistics at the last solution.
  NoiseStatistics Statistics(const BlockBandedMatrix& covariance);

 private:
  using Matrix6 = Eigen::Matrix<double, 6, 6>;
  using Vector6 = Eigen::Matrix<double, 6, 1>;
  struct SeenTag {
    SeenTag(const TagObservation& observation, const EstimatorSetup& setup)
        : residual(observation, setup.camera, setup.cam_from_body) {}
    TagReprojectionResidual residual;
    double squared_norm = 0;  // when last linearised, without a robust weight
  };
  struct TagRange {
    std::deque<SeenTag>::const_iterator first, last;
    auto begin() const { return first; }
    auto end() const { return last; }
  };
  // A frame's tags in units of their residuals; unit_ takes them to standard deviations.
  struct Form {
    Pose reference;
    Matrix6 hessian;
    Vector6 gradient;
    double cost = 0;
    bool is_robust = false;  // a tag has a weight below 1
  };

  void MakeTags(double sigma_px);
  TagRange TagsOf(size_t k) const;
  void SetNoise(const NoiseModel& noise);
  Vector6 MovedFromReference(size_t k) const;
  bool LinearizeTags(size_t k);
  // False where a tag cannot be seen.
  bool LinearizeWhatMoved(double neglected);
  void LinearizeMotion(size_t k, Eigen::Matrix<double, 18, 1>* residual,
                       Eigen::Matrix<double, 18, 36>* jacobian) const;
  // From state k on; its cost is returned.
  double AddMotionFrom(size_t k, LinearSystem* out) const;
  LinearSystem Assemble() const;
  double LogDetInformation() const;
  void AddTagStatistics(size_t k, const BlockBandedMatrix& covariance, double typical_scale,
                        NoiseStatistics* out) const;
  void AddMotionStatisticFrom(size_t k, const BlockBandedMatrix& covariance,
                              NoiseStatistics* out) const;

  const EstimatorSetup& setup_;
  const GraphInput& input_;
  bool has_own_covariances_;  // of corners
  std::optional<NoiseModel> noise_;
  Graph first_;  // its state and prior
  std::vector<GraphState> states_;
  std::deque<SeenTag> tags_;       // of all frames, in order
  std::vector<size_t> first_tag_;  // of each frame; then how many there are
  std::vector<Form> forms_;
  std::deque<MotionResidual> motions_;
  double huber_delta_, unit_ = 1;
};

}  // namespace tagtwist

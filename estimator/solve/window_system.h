#pragma once
#include <Eigen/Core>
#include <deque>
#include <optional>
#include <utility>
#include <vector>

#include "estimator/graph/graph_builder.h"
#include "estimator/graph/noise_model.h"
#include "estimator/solve/smoother.h"

namespace tagtwist {

/// The window's normal equations where no track is in it, kept from frame to frame. Each frame's
/// tags are reduced to a quadratic form in its pose about the pose where they were linearised, with
/// the noise of that time; they are linearised again when it has moved by more than the form holds.
/// Motion, which is stiff and cheap, is linearised with every new frame. So a frame costs its own
/// tags and a banded solve or two.
class WindowSystem {
 public:
  /// Whether the input has this shape: no usable track, a prior on the first state alone.
  static bool Fits(const EstimatorSetup& setup, const GraphInput& input);

  /// What SolveAndInvert gives, but for the graph's factors and the likelihood; frames that came or
  /// changed their tags since the last call are linearised.
  Result<Solution> Solve(const EstimatorSetup& setup, const NoiseModel& noise,
                         const SolveOptions& options, const GraphInput& input);

  /// Indices of the tags of frame k whose Huber weight was below `least` when last linearised.
  std::vector<int> TagsBelow(int k, double least) const;

  /// The first state leaves for a prior on the second, at the last solution.
  void MarginalizeFirst();
  /// The prior on the first state as a factor, where there is one.
  std::optional<Factor> Prior() const;

 private:
  using Block = BlockBandedMatrix::Block;
  using Vector18 = Eigen::Matrix<double, BlockBandedMatrix::kSize, 1>;
  using Matrix6 = Eigen::Matrix<double, 6, 6>;
  using Vector6 = Eigen::Matrix<double, 6, 1>;

  // Quadratic forms: the gradient at other states, the cost added to *cost.
  struct PriorForm {
    GraphState reference;
    Block hessian;
    Vector18 gradient;
    Vector18 GradientAt(const GraphState& state, double* cost) const;
  };
  struct TagForm {
    Pose reference;
    Matrix6 hessian = Matrix6::Zero();
    Vector6 gradient = Vector6::Zero();
    double cost = 0;
    std::vector<double> weights;  // one a tag
    Vector6 GradientAt(const GraphState& state, double* cost) const;
  };
  struct MotionForm {  // from the state before
    GraphState first, second;
    Block h00, h10, h11;
    Vector18 g0, g1;
    double cost = 0;
    std::pair<Vector18, Vector18> GradientsAt(const GraphState& at_first,
                                              const GraphState& at_second, double* cost) const;
  };
  struct FrameForms {
    int64_t t_ns = 0;
    TagForm tags;
    std::optional<MotionForm> motion;  // none for the first frame
  };

  void Linearize(const EstimatorSetup& setup, const NoiseModel& noise, const GraphInput& input);
  void LinearizeTags(const EstimatorSetup& setup, const NoiseModel& noise, const GraphFrame& frame,
                     TagForm* form) const;
  void LinearizeMotion(const NoiseModel& noise, size_t k);
  void LinearizePrior(const Factor& factor);
  bool LinearizeWhatMoved(const EstimatorSetup& setup, const NoiseModel& noise,
                          const GraphInput& input);
  BlockBandedMatrix Assemble(Eigen::VectorXd* gradient, double* cost) const;

  std::vector<GraphState> states_;
  std::optional<PriorForm> prior_;
  std::deque<FrameForms> frames_;
};

}  // namespace tagtwist

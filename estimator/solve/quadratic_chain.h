#pragma once
#include <functional>
#include <optional>
#include <vector>

#include "estimator/graph/graph.h"
#include "estimator/graph/linear_system.h"
#include "estimator/solve/ceres_solver.h"
#include "estimator/solve/pose_form.h"
#include "estimator/solve/world_tangent.h"
#include "frontend/base/for_ranges.h"
#include "frontend/base/quadratic_form.h"
#include "frontend/base/result.h"

namespace tagtwist::internal {

/// How well QuadraticChain::Solve solves.
struct ChainRules {
  /// What PoseForm may neglect, in standard deviations times rad or m.
  double neglected = 0;
  /// A step after which all forms hold, and no turn between states has changed by what would show,
  /// is the last one; whether the cost falls is not asked. Else full steps must lower the cost
  /// until the tolerance of the options ends them.
  bool ends_when_forms_hold = false;
};

/// What a solve of the chain gives; the states are in its graph.
struct ChainSolution {
  BlockBandedMatrix covariance{0, 0};
  double cost = 0;
  double log_likelihood = 0;  // see Solution
};

/// A graph without points that is solved again and again: in batch while its noise is learned, in
/// the window while frames come and go. What touches one pose alone is kept as a PoseForm,
/// linearised again only where the pose has moved by more than the form holds or the noise has
/// changed; all other factors, motion as a rule, are linearised at every step. Only the blocks that
/// a factor touches count, not its kind.
class QuadraticChain {
 public:
  /// Whether a graph is of this shape.
  static bool Fits(const Graph& graph) { return graph.points.empty(); }

  explicit QuadraticChain(Graph graph = {}, ForRanges for_ranges = InOneRange,
                          PriorTangent tangent = PriorTangent::kOwn);

  /// From the graph's states on, which it moves. An error where full steps do not do: a job for
  /// SolveBanded.
  Result<ChainSolution> Solve(const SolveOptions& options, const ChainRules& rules);

  /// All forms at the poses as they are now, for whoever asks what the factors say there.
  void LinearizeForms() { LinearizeWhatMoved(0); }

  /// Changes factors, by costs of the same blocks: another noise. Forms are kept where they hold
  /// under it.
  void ChangeFactors(const std::function<void(const Graph&, Factor*)>& change);
  /// Another scale of the motion that leads to a state; a factor gets it with ChangeFactors.
  void SetMotion(int state, const MotionScale& scale) {
    graph_.states[static_cast<size_t>(state)].motion = scale;
  }
  /// Puts these in the place of all factors on a state's pose alone.
  void ReplaceFactorsOfPose(int state, std::vector<Factor> factors);
  /// A state after the last one, and then what was measured of it, on it and those before it.
  void AddState(const GraphState& state);
  void AddFactors(std::vector<Factor> factors);
  /// The first state leaves: what is known of it becomes a form in the states that share a factor
  /// with it, linearised at the states as they are.
  void MarginalizeFirst();
  /// The normal equations of all factors on the first state, and of what is known from before: of
  /// it and those that share one with it.
  LinearSystem Leaving() const;
  /// Those of all, at the states as they are.
  LinearSystem NormalEquations() const { return Assemble({}); }
  /// What is known from before about the first state, which is its mean: an information matrix in
  /// GraphState's error state.
  void SetPrior(const Block& information);
  /// Adds to the gradient of what is known from before about the first state, in the tangent of the
  /// prior: that moves with something outside the chain.
  void ShiftPrior(const GraphStep& gradient);
  /// The form of what has left as a factor; none where no state has left.
  std::optional<Factor> Prior() const;

  const Graph& graph() const { return graph_; }
  Graph TakeGraph() && { return std::move(graph_); }
  const PoseForm& form(int state) const { return forms_[static_cast<size_t>(state)]; }
  /// The factor that ties a state to the next one and touches no other, the first one of them; -1
  /// where there is none.
  int StepFrom(int state) const { return steps_[static_cast<size_t>(state)]; }

 private:
  struct Problem;
  /// About the first states of the chain.
  using StatesForm = QuadraticForm<Eigen::Dynamic, std::vector<GraphState>>;

  /// Of the prior at the states as they are: their steps' derivative of the form's tangent.
  Eigen::MatrixXd PriorByStep() const;
  void TurnPrior();
  void Index();
  // Their indices, and the last state that they touch.
  std::vector<size_t> FactorsOfFirst(int* last) const;
  bool LinearizeWhatMoved(double neglected);
  bool Holds(const std::vector<GraphState>& moved, double neglected) const;
  std::optional<double> Add(size_t f, LinearFactor* scratch, LinearSystem* out) const;
  void AddSteps(LinearSystem* out) const;
  void AddForms(size_t n_states, LinearSystem* out) const;
  LinearSystem Assemble(BlockBandedMatrix memory) const;
  double LogDetInformation() const;

  Graph graph_;
  ForRanges for_ranges_;
  std::vector<PoseForm> forms_;  // one a state
  std::vector<int> steps_;       // StepFrom
  std::vector<size_t> others_;   // all factors that are neither
  PriorTangent tangent_;
  std::optional<StatesForm> prior_;  // of states that left, in that tangent
  int bandwidth_ = 1;
};

}  // namespace tagtwist::internal

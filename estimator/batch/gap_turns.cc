#include "estimator/batch/gap_turns.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "estimator/batch/gap_motion.h"
#include "estimator/batch/gaps.h"
#include "estimator/solve/noise_rounds.h"

namespace tagtwist::internal {
namespace {

// States on either side of a gap that are solved with it.
constexpr int kBesideGap = 15;
// Of e' Q^-1 e over a gap, nine of a part: what chance alone does not reach in a gap of a hundred.
constexpr double kMostByChance = 22;
// Weight of the density that is expected, in degrees of freedom, against the gap's own.
constexpr double kPriorDof = 4, kDof = 9;
// In the logarithm: ways that are less likely are left out, and less likely than that not told.
constexpr double kLeastGain = -5.3;
constexpr double kLeastToldWeight = 0.05;

// By how much a part's density is raised, from what it was raised by.
double Raised(double now, const VarianceStatistic& motion) {
  return std::max(1.0, (kPriorDof + now * motion.sum) / (kPriorDof + motion.dof));
}

// A way through a gap with the density that it takes.
struct Way {
  Solution solution;
  MotionScale raised;
  double rest = 0;       // half the sum of squares of all but the motion over the gap
  double corners = 0;    // of which the corners'
  double of_motion = 0;  // logarithm of the likelihood of the motion over the gap: Student's t
  double turned = 0;     // e' Q^-1 e of the attitude's part of it, at the density that was expected
};

double OfStudent(double squares) {
  return -0.5 * (kPriorDof + kDof) * std::log1p(squares / kPriorDof);
}

// From the input's states and `raised` on.
std::optional<Way> SolveWay(const EstimatorSetup& setup, const SolveOptions& options,
                            const NoiseModel& noise, const FrameRange& gap,
                            const MotionScale& expected, MotionScale raised, GraphInput input) {
  constexpr int kRounds = 6;
  constexpr double kSettled = 1.1;
  const bool is_learned = MotionIsLearned(setup.options);
  for (int round = 0;; ++round) {
    SetMotion(gap, {expected.linear * raised.linear, expected.angular * raised.angular},
              &input.frames);
    auto solution = SolveAndInvert(setup, noise, input, options);
    if (!solution) return std::nullopt;
    const GapMotion motion = MotionOver(gap, noise, *solution);
    const MotionScale next{Raised(raised.linear, motion.linear),
                           Raised(raised.angular, motion.angular)};
    const auto is_near = [](double a, double b) { return a < kSettled * b && b < kSettled * a; };
    const bool settled =
        is_near(next.linear, raised.linear) && is_near(next.angular, raised.angular);
    if (!is_learned || settled || round + 1 == kRounds) {
      Way out{std::move(*solution), raised};
      out.rest = out.solution.cost - 0.5 * (motion.linear.sum + motion.angular.sum);
      out.corners = CostOfCorners(setup, noise, input.frames, out.solution);
      out.of_motion = OfStudent(raised.linear * motion.linear.sum) +
                      OfStudent(raised.angular * motion.angular.sum);
      out.turned = raised.angular * motion.angular.sum;
      return out;
    }
    raised = next;
    TakeStates(solution->graph, &input.frames);
  }
}

// Logarithm of the other's likelihood over the kept one's. What is not of the corners counts for
// less: bodies turn about one axis, and the prior takes its three axes for equally lively.
double GainOf(const Way& other, const Way& kept) {
  constexpr double kTrustInMotion = 0.3;
  const double of_corners = kept.corners - other.corners;
  const double of_rest = kept.rest - other.rest - of_corners;
  return of_corners + kTrustInMotion * (of_rest + other.of_motion - kept.of_motion);
}

// Of a body that turned in a gap otherwise than its rates on both sides and its motion before say,
// these tell nothing of the way: others remain as likely as bodies turn so fast. The least
// logarithm of the likelihood of that way over the kept one's.
std::optional<double> LeastGain(const std::vector<GraphFrame>& frames, const FrameRange& gap,
                                const Way& kept, const GapTurn& other) {
  constexpr double kLeast = -1.6, kUsualRate = 6.3;  // a fifth; rad/s
  if (!(kept.turned > kMostByChance)) return std::nullopt;
  const GraphFrame& first = frames[static_cast<size_t>(gap.first)];
  const GraphFrame& last = frames[static_cast<size_t>(gap.last)];
  const double dt_s = ToSeconds(last.t_ns - first.t_ns);
  const Eigen::Vector3d expected =
      0.5 * dt_s * (first.state.twist.omega_body + last.state.twist.omega_body);
  const GapTurn turn = TurnThrough(frames, gap);
  if (!IsUnexpected(turn.whole + turn.rest, expected)) return std::nullopt;
  const double rate = (other.whole + other.rest).norm() / dt_s;
  return kLeast - std::pow(rate / kUsualRate, 2);
}

// A way that no body could take may have no solution but numbers.
bool IsFinite(const OtherAccount& account) {
  return std::all_of(account.covariances.begin(), account.covariances.end(),
                     [](const Block& block) { return block.allFinite(); });
}

// What is to know of a gap: the kept way, and the others.
struct GapAccount {
  Way kept;
  OpenAccounts others;
};
struct Look {
  FrameRange gap;
  MotionScale expected;
  GapAccount account;
};

std::optional<GapAccount> LookAt(const EstimatorSetup& setup, const SolveOptions& options,
                                 const NoiseModel& noise, const FrameRange& gap,
                                 const MotionScale& expected, const GraphInput& whole) {
  constexpr int kMostTurns = 3;
  const Stretch stretch = Around(whole, gap, kBesideGap);
  const FrameRange there{gap.first - stretch.states.first, gap.last - stretch.states.first};
  auto kept = SolveWay(setup, options, noise, there, expected, {}, stretch.input);
  if (!kept) return std::nullopt;
  GapAccount out{std::move(*kept), {stretch.states.first, gap, {}, true, kLeastToldWeight}};
  if (!IsBridged(gap)) return out;
  const GapTurn turn = TurnThrough(stretch.input.frames, there);
  for (const int direction : {1, -1}) {
    for (int turns = 1; turns <= kMostTurns; ++turns) {
      GraphInput input = stretch.input;
      const GapTurn on = TurnedOn(input.frames, there, turn, direction * turns);
      const auto least = LeastGain(input.frames, there, out.kept, on);
      LayBridges(on, there, &input.frames);
      const auto other =
          SolveWay(setup, options, noise, there, expected, out.kept.raised, std::move(input));
      if (!other || AreTheSame(other->solution, out.kept.solution.graph.states)) break;
      double gain = GainOf(*other, out.kept);
      if (least && turns == 1) gain = std::max(gain, *least);
      if (!(gain > kLeastGain)) break;
      OtherAccount account = AccountOf(other->solution, gain);
      if (!IsFinite(account)) break;
      out.others.others.push_back(std::move(account));
    }
  }
  std::stable_sort(out.others.others.begin(), out.others.others.end(),
                   [](const OtherAccount& a, const OtherAccount& b) { return a.gain > b.gain; });
  return out;
}

bool NeedsALook(const FrameRange& gap, const NoiseModel& noise, const MotionScale& expected,
                const GraphInput& input, const Solution& solution) {
  if (IsBridged(gap)) return true;
  const MotionScale& now = input.frames[static_cast<size_t>(gap.last)].motion;
  if (now.linear != expected.linear || now.angular != expected.angular) return true;
  const GapMotion motion = MotionOver(gap, noise, solution);
  return std::max(motion.linear.sum, motion.angular.sum) > kMostByChance;
}

// Each by itself, at once where work can be split.
std::vector<Look> LookAtAll(const EstimatorSetup& setup, const SolveOptions& options,
                            const NoiseModel& noise, const std::vector<FrameRange>& gaps,
                            const GraphInput& input, const Solution& solution) {
  const bool is_learned = MotionIsLearned(setup.options);
  std::vector<std::optional<Look>> found(gaps.size());
  setup.for_ranges(gaps.size(), [&](size_t first, size_t last) {
    for (size_t i = first; i < last; ++i) {
      const MotionScale expected =
          is_learned ? ExpectedMotion(gaps, gaps[i], noise, input.frames) : MotionScale();
      if (!NeedsALook(gaps[i], noise, expected, input, solution)) continue;
      auto account = LookAt(setup, options, noise, gaps[i], expected, input);
      if (account) found[i] = Look{gaps[i], expected, std::move(*account)};
    }
  });
  std::vector<Look> out;
  for (std::optional<Look>& look : found) {
    if (look) out.push_back(std::move(*look));
  }
  return out;
}

// Of the kept way into the input; whether that changed much.
bool TakeMotionOf(const GapAccount& account, const FrameRange& gap, const MotionScale& expected,
                  GraphInput* input) {
  constexpr double kClearlyRaised = 2, kMuch = 1.2;
  const auto taken = [](double raised) { return raised > kClearlyRaised ? raised : 1; };
  const MotionScale motion{expected.linear * taken(account.kept.raised.linear),
                           expected.angular * taken(account.kept.raised.angular)};
  const MotionScale before = input->frames[static_cast<size_t>(gap.last)].motion;
  SetMotion(gap, motion, &input->frames);
  const auto is_near = [](double a, double b) { return a < kMuch * b && b < kMuch * a; };
  return !is_near(before.linear, motion.linear) || !is_near(before.angular, motion.angular);
}

}  // namespace

Result<Solution> DecideGaps(const EstimatorSetup& setup, const SolveOptions& options,
                            const std::vector<FrameRange>& gaps, Solution solution,
                            GraphInput* input, NoiseModel* noise, std::vector<OpenAccounts>* open) {
  constexpr int kMostRounds = 4;
  open->clear();
  for (int round = 0;; ++round) {
    std::vector<Look> looks = LookAtAll(setup, options, *noise, gaps, *input, solution);
    *open = std::vector<OpenAccounts>();
    if (looks.empty()) return solution;
    GraphInput anew = *input;
    bool changed = false;
    for (Look& look : looks) {
      changed = TakeMotionOf(look.account, look.gap, look.expected, &anew) || changed;
      if (!look.account.others.others.empty()) open->push_back(std::move(look.account.others));
    }
    changed = TakeLikelier(*open, &anew) || changed;
    if (!changed || round == kMostRounds) return solution;
    NoiseModel learned = *noise;
    auto solved = SolveAndLearn(setup, options, &anew, &learned);
    if (!solved) return solution;
    solution = std::move(*solved);
    *input = std::move(anew);
    *noise = learned;
  }
}

}  // namespace tagtwist::internal

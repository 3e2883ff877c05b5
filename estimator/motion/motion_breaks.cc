#include "estimator/motion/motion_breaks.h"

#include <algorithm>
#include <cmath>

#include "estimator/graph/noise_model.h"
#include "estimator/graph/pose_bound.h"
#include "frontend/base/format_text.h"
#include "frontend/base/statistics/quantile.h"

namespace tagtwist::internal {
namespace {

constexpr int kBeside = 3;  // frames on either side of a break

// How far apart two poses are, or may be.
struct Apart {
  double m, rad;
};

// What poses by the tags of two frames may be apart where the body stands: six sigma, and what maps
// and lenses leave.
std::optional<Apart> Slack(const EstimatorSetup& setup, const GraphFrame& a, const GraphFrame& b) {
  constexpr double kSigmas = 6;
  constexpr Apart kLeast{0.04, 0.1};
  double square_m = 0, square_rad = 0;
  for (const GraphFrame* frame : {&a, &b}) {
    const auto bound =
        PoseBound(setup, NoiseModel().corner_sigma_px, frame->state.world_from_body, frame->tags);
    if (!bound) return std::nullopt;
    square_m += bound->diagonal().tail<3>().sum();
    square_rad += bound->diagonal().head<3>().sum();
  }
  return Apart{kLeast.m + kSigmas * std::sqrt(square_m),
               kLeast.rad + kSigmas * std::sqrt(square_rad)};
}

// How much further a frame lies from the one before, `here`, than the velocities on both sides,
// over two intervals each, and the hardest push take it, stamps being off by a third of an
// interval; negative where it is nearer.
Apart Beyond(GraphFrame* const* here, double usual_s) {
  constexpr double kMps2 = 200, kRadps2 = 2000, kStamps = 0.3;
  const auto twist = [&](int from, int to) {
    return TwistBetween(here[from]->state.world_from_body, here[to]->state.world_from_body,
                        ToSeconds(here[to]->t_ns - here[from]->t_ns));
  };
  const Twist before = twist(-2, 0), after = twist(1, 3), jump = twist(0, 1);
  const double dt_s = ToSeconds(here[1]->t_ns - here[0]->t_ns), push_s = std::max(dt_s, usual_s);
  const auto beyond = [&](const Eigen::Vector3d& v, const Eigen::Vector3d& a,
                          const Eigen::Vector3d& b, double most) {
    return (v - 0.5 * (a + b)).norm() * dt_s - most * push_s * push_s / 4 -
           kStamps * usual_s * std::max(a.norm(), b.norm());
  };
  return {beyond(jump.v_world, before.v_world, after.v_world, kMps2),
          beyond(jump.omega_body, before.omega_body, after.omega_body, kRadps2)};
}

// Of each frame whether the body may have been carried since the one before: above 1 it was.
std::vector<double> Scores(const EstimatorSetup& setup, const std::vector<GraphFrame*>& seen) {
  constexpr double kInARow = 2.5;  // usual intervals
  std::vector<double> intervals_s, out(seen.size(), 0);
  for (size_t k = 1; k < seen.size(); ++k) {
    intervals_s.push_back(ToSeconds(seen[k]->t_ns - seen[k - 1]->t_ns));
  }
  if (seen.size() < 2 * kBeside) return out;
  const double usual_s = Quantile(intervals_s, 0.5);
  for (size_t k = kBeside; k + kBeside <= seen.size(); ++k) {
    const auto interval = intervals_s.begin() + static_cast<std::ptrdiff_t>(k) - 1;
    const double longest_s = *std::max_element(interval - (kBeside - 1), interval + kBeside);
    if (longest_s > kInARow * usual_s) continue;
    const Apart beyond = Beyond(&seen[k - 1], usual_s);
    if (!(beyond.m > 0 || beyond.rad > 0)) continue;
    const auto slack = Slack(setup, *seen[k - 1], *seen[k]);
    if (slack) out[k] = std::max(beyond.m / slack->m, beyond.rad / slack->rad);
  }
  return out;
}

}  // namespace

std::optional<std::string> MarkBreaks(const EstimatorSetup& setup,
                                      std::vector<GraphFrame>* frames) {
  std::vector<GraphFrame*> seen;
  for (GraphFrame& frame : *frames) {
    if (frame.tags.size() > 1 && !frame.leaves_open) seen.push_back(&frame);
  }
  const std::vector<double> scores = Scores(setup, seen);
  size_t n = 0;
  double first_s = 0;
  for (size_t k = kBeside; k + kBeside <= scores.size(); ++k) {
    // A jump shows in the velocities beside it, too.
    const auto here = scores.begin() + static_cast<std::ptrdiff_t>(k);
    const double most = *std::max_element(here - (kBeside - 1), here + kBeside);
    if (!(scores[k] > 1 && scores[k] >= most)) continue;
    seen[k]->motion.breaks = true;
    if (n++ == 0) first_s = ToSeconds(seen[k]->t_ns - frames->front().t_ns);
  }
  if (n == 0) return std::nullopt;
  return Format(
      "the body is elsewhere from one frame to the next %zu time%s, first at %.3f s: it was "
      "carried there, or the clock was set; its motion begins anew",
      n, n == 1 ? "" : "s", first_s);
}

}  // namespace tagtwist::internal

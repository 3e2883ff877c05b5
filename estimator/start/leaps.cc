#include "estimator/start/leaps.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>

#include "estimator/graph/noise_model.h"
#include "estimator/graph/pose_bound.h"
#include "estimator/rig/rig_pose.h"
#include "frontend/base/statistics/quantile.h"
#include "frontend/types/cubic.h"

namespace tagtwist::internal {
namespace {

constexpr double kFastestMps = 10, kFastestRadps = 20;

// What a pose may be off.
struct Slack {
  double m, rad;
};
constexpr Slack kSmall{0.02, 0.1};  // of poses from single frames

bool CanGo(const Pose& from, const Pose& to, double dt_s, const Slack& slack) {
  return (to.translation() - from.translation()).norm() < slack.m + kFastestMps * dt_s &&
         AngleBetween(from, to) < slack.rad + kFastestRadps * dt_s;
}

bool CanGo(const GraphFrame& from, const GraphFrame& to, const Slack& slack = kSmall) {
  return CanGo(from.state.world_from_body, to.state.world_from_body, ToSeconds(to.t_ns - from.t_ns),
               slack);
}

// Of a frame's tags; nullopt where they do not fix a pose.
std::optional<Slack> SlackOf(const EstimatorSetup& setup, const GraphFrame& frame) {
  constexpr double kLeapSigmas = 6;
  const auto bound =
      PoseBound(setup, NoiseModel().corner_sigma_px, frame.state.world_from_body, frame.tags);
  if (!bound) return std::nullopt;
  return Slack{kSmall.m + kLeapSigmas * std::sqrt(bound->diagonal().tail<3>().sum()),
               kSmall.rad + kLeapSigmas * std::sqrt(bound->diagonal().head<3>().sum())};
}

BodyState OnCubic(const GraphFrame& from, const GraphFrame& to, int64_t t_ns) {
  const double span_s = ToSeconds(to.t_ns - from.t_ns);
  return CubicBetween(from.state, to.state, span_s, ToSeconds(t_ns - from.t_ns) / span_s);
}

// From the cubic between two states [m], [rad].
Slack FromCubic(const GraphFrame& from, const GraphFrame& to, const GraphFrame& between) {
  const Pose at = OnCubic(from, to, between.t_ns).world_from_body;
  const Pose& there = between.state.world_from_body;
  return {(there.translation() - at.translation()).norm(), AngleBetween(there, at)};
}

bool Shows(const GraphFrame& frame, int id) {
  return std::any_of(frame.tags.begin(), frame.tags.end(),
                     [id](const TagDetection& tag) { return tag.id == id; });
}

// Frames with tags, in order of time: those that others support, and those that stand alone.
struct SeenFrames {
  std::vector<const GraphFrame*> supported, alone;
  std::vector<size_t> run_end;  // behind the last of the supported ones that follow without a gap
  double longest_run_s = 0;
};

// Frames with several tags support themselves, a lone tag is supported where three frames in a row
// show it.
SeenFrames FindSupported(const std::vector<GraphFrame>& frames) {
  constexpr double kInARow = 2.5;  // usual intervals
  constexpr int kEnough = 3;
  std::vector<const GraphFrame*> seen;
  std::vector<double> intervals_s;
  for (const GraphFrame& frame : frames) {
    if (frame.tags.empty()) continue;
    if (!seen.empty()) intervals_s.push_back(ToSeconds(frame.t_ns - seen.back()->t_ns));
    seen.push_back(&frame);
  }
  SeenFrames out;
  if (intervals_s.empty()) return out;
  const double most_s = kInARow * Quantile(intervals_s, 0.5);
  for (size_t k = 0; k < seen.size(); ++k) {
    const int id = seen[k]->tags[0].id;
    int in_a_row = 1;  // that show it
    const auto more = [&](size_t interval, size_t to) {
      return in_a_row < kEnough && intervals_s[interval] < most_s && Shows(*seen[to], id);
    };
    for (size_t j = k; j > 0 && more(j - 1, j - 1); --j) ++in_a_row;
    for (size_t j = k; j + 1 < seen.size() && more(j, j + 1); ++j) ++in_a_row;
    const bool is_supported = seen[k]->tags.size() > 1 || in_a_row >= kEnough;
    (is_supported ? out.supported : out.alone).push_back(seen[k]);
  }
  out.run_end.assign(out.supported.size(), out.supported.size());
  for (size_t k = out.supported.size(); k-- > 1;) {
    const double gap_s = ToSeconds(out.supported[k]->t_ns - out.supported[k - 1]->t_ns);
    out.run_end[k - 1] = gap_s < most_s ? out.run_end[k] : k;
  }
  for (size_t k = 0; k < out.supported.size(); ++k) {
    const int64_t run_ns = out.supported[out.run_end[k] - 1]->t_ns - out.supported[k]->t_ns;
    out.longest_run_s = std::max(out.longest_run_s, ToSeconds(run_ns));
  }
  return out;
}

// The most that the body is from the cubic in nine of ten stretches of that length [s] without a
// gap, at that share of their time; of shorter ones, where there are none, cubed. nullopt where no
// stretch is long enough to tell.
std::optional<Slack> UsualFromCubic(const SeenFrames& seen, double span_s, double share) {
  constexpr size_t kLooks = 200;
  constexpr double kShortest = 0.25;  // of the span
  constexpr double kShare = 0.9;      // what is wrong still moves the frames beside it, too
  const std::vector<const GraphFrame*>& frames = seen.supported;
  const double longest_s = seen.longest_run_s;
  if (longest_s < kShortest * span_s) return std::nullopt;
  const double look_s = std::min(span_s, 0.9 * longest_s), scale = std::pow(span_s / look_s, 3);
  std::vector<double> off_m, off_rad;
  for (size_t k = 0; k < frames.size(); k += 1 + frames.size() / kLooks) {
    const auto at = [&](double after_s) {
      size_t j = k;
      while (j < seen.run_end[k] && ToSeconds(frames[j]->t_ns - frames[k]->t_ns) < after_s) ++j;
      return j;
    };
    const size_t between = at(share * look_s), to = at(look_s);
    if (to == seen.run_end[k] || between == k || between == to) continue;
    const Slack off = FromCubic(*frames[k], *frames[to], *frames[between]);
    off_m.push_back(off.m);
    off_rad.push_back(off.rad);
  }
  if (off_m.empty()) return std::nullopt;
  return Slack{scale * Quantile(off_m, kShare), scale * Quantile(off_rad, kShare)};
}

struct Glimpse {
  const GraphFrame *frame, *from, *to;  // with the supported ones around it
};

std::vector<Glimpse> UnlikelyGlimpses(const EstimatorSetup& setup,
                                      const std::vector<GraphFrame>& frames) {
  constexpr double kTimes = 4;
  const SeenFrames seen = FindSupported(frames);
  std::vector<Glimpse> out;
  auto after = seen.supported.begin();
  for (const GraphFrame* here : seen.alone) {
    while (after != seen.supported.end() && (*after)->t_ns < here->t_ns) ++after;
    if (after == seen.supported.begin() || after == seen.supported.end()) continue;
    const GraphFrame &from = **(after - 1), &to = **after;
    const double span_s = ToSeconds(to.t_ns - from.t_ns);
    const auto slack = SlackOf(setup, *here);
    const auto usual = UsualFromCubic(seen, span_s, ToSeconds(here->t_ns - from.t_ns) / span_s);
    if (!slack || !usual) continue;
    const Slack off = FromCubic(from, to, *here);
    if (off.m > slack->m + kTimes * usual->m || off.rad > slack->rad + kTimes * usual->rad) {
      out.push_back({here, &from, &to});
    }
  }
  return out;
}

}  // namespace

bool IsWithinReach(const Pose& from, const Pose& to, double dt_s) {
  return CanGo(from, to, dt_s, kSmall);
}

std::vector<bool> Leaps(const EstimatorSetup& setup, const std::vector<GraphFrame>& frames) {
  std::vector<size_t> seen;
  for (size_t i = 0; i < frames.size(); ++i) {
    if (!frames[i].tags.empty()) seen.push_back(i);
  }
  std::vector<bool> out(frames.size(), false);
  for (size_t k = 1; k + 1 < seen.size(); ++k) {
    const GraphFrame &before = frames[seen[k - 1]], &here = frames[seen[k]],
                     &after = frames[seen[k + 1]];
    if (here.tags.size() > 1) continue;
    const auto slack = SlackOf(setup, here);
    if (!slack || CanGo(before, here, *slack) || CanGo(here, after, *slack)) continue;
    const auto mirrored = MirroredPoseOf(setup, here.tags, here.state.world_from_body);
    GraphFrame other = here;
    if (mirrored) other.state.world_from_body = *mirrored;
    if (CanGo(before, other, *slack) || CanGo(other, after, *slack)) continue;
    out[seen[k]] = CanGo(before, after);
  }
  return out;
}

bool DropBeyondReach(std::vector<GraphFrame>* frames) {
  constexpr size_t kOften = 50;  // one in so many frames
  size_t n_seen = 0;
  std::vector<GraphFrame*> beyond;
  for (GraphFrame& frame : *frames) {
    if (!frame.tags.empty()) ++n_seen;
    const Twist& twist = frame.state.twist;
    const bool is_fast =
        twist.v_world.norm() > kFastestMps || twist.omega_body.norm() > kFastestRadps;
    if (is_fast && frame.tags.size() == 1) beyond.push_back(&frame);
  }
  if (kOften * beyond.size() > n_seen) return false;
  for (GraphFrame* frame : beyond) frame->tags.clear();
  return !beyond.empty();
}

bool DropUnlikelyGlimpses(const EstimatorSetup& setup, std::vector<GraphFrame>* frames) {
  const std::vector<Glimpse> unlikely = UnlikelyGlimpses(setup, *frames);
  for (const Glimpse& glimpse : unlikely) {
    (*frames)[static_cast<size_t>(glimpse.frame - frames->data())].tags.clear();
  }
  // What they had led the states to is not where those without them start from.
  const GraphFrame* done = nullptr;
  for (const auto& [glimpse, from, to] : unlikely) {
    if (from == done) continue;
    done = from;
    for (GraphFrame& frame : *frames) {
      const bool is_between = frame.t_ns > from->t_ns && frame.t_ns < to->t_ns;
      if (is_between && frame.tags.empty()) frame.state = OnCubic(*from, *to, frame.t_ns);
    }
  }
  return !unlikely.empty();
}

bool HasUnlikelyGlimpses(const EstimatorSetup& setup, const std::vector<GraphFrame>& frames) {
  return !UnlikelyGlimpses(setup, frames).empty();
}

}  // namespace tagtwist::internal

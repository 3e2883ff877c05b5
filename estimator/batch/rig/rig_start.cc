#include "estimator/batch/rig/rig_start.h"

#include <algorithm>
#include <cmath>

#include "frontend/base/format_text.h"

namespace tagtwist::internal {
namespace {

constexpr size_t kMostSamples = 400, kFewestSamples = 10;

// What one camera says at a time of its own clock.
struct Sample {
  int64_t t_ns;
  Pose pose;
  PoseCovariance covariance;
};

std::vector<Sample> Spread(const std::vector<FrameEstimate>& frames) {
  std::vector<Sample> seen;
  for (const FrameEstimate& frame : frames) {
    if (frame.status != FrameStatus::kOk) continue;
    seen.push_back(
        {frame.t_ns, frame.state.world_from_body, frame.covariance.topLeftCorner<6, 6>()});
  }
  const size_t n = std::min(seen.size(), kMostSamples);
  std::vector<Sample> out;
  for (size_t i = 0; i < n; ++i) out.push_back(seen[i * seen.size() / n]);
  return out;
}

// Poses between the cameras under one clock, and how certain each is: sums of variances.
struct Relative {
  Pose cam_from_first;
  double rotation = 0, position = 0;
};

std::vector<Relative> Between(const Trajectory& first, const std::vector<Sample>& samples,
                              MountedOn mounted_on, double clock_s) {
  const int64_t clock_ns = std::llround(1e9 * clock_s);
  std::vector<Relative> out;
  for (const Sample& sample : samples) {
    const int64_t t_ns = sample.t_ns + clock_ns;
    if (t_ns < first.states.front().t_ns || t_ns > first.states.back().t_ns) continue;
    const StateAndCovariance at = *first.At(t_ns);
    const Pose& of_first = at.state.world_from_body;
    const auto of_both = [&](int entry) {
      return at.covariance.diagonal().segment<3>(entry).sum() +
             sample.covariance.diagonal().segment<3>(entry).sum();
    };
    out.push_back({mounted_on == MountedOn::kBody ? Inverse(sample.pose) * of_first
                                                  : sample.pose * Inverse(of_first),
                   of_both(0), of_both(3)});
  }
  return out;
}

// Squared distance from a pose in what is to be expected. Errors that last are in no covariance:
// never less than a milliradian and a millimetre.
double Misfit(const Relative& relative, const Pose& reference) {
  constexpr double kLeastRad = 1e-3, kLeastM = 1e-3;
  const PoseStep d = Difference(relative.cam_from_first, reference);
  return d.head<3>().squaredNorm() / (relative.rotation + kLeastRad * kLeastRad) +
         d.tail<3>().squaredNorm() / (relative.position + kLeastM * kLeastM);
}

// Beyond it a pose counts as if it were there.
constexpr double kMostMisfit = 25;

double MeanMisfit(const std::vector<Relative>& between, const Pose& reference) {
  double sum = 0;
  for (const Relative& relative : between)
    sum += std::min(kMostMisfit, Misfit(relative, reference));
  return sum / static_cast<double>(between.size());
}

// From the best of some, to the mean of those that are near.
Pose RobustMean(const std::vector<Relative>& between) {
  constexpr size_t kCandidates = 20;
  constexpr int kRounds = 5;
  Pose best;
  double least = HUGE_VAL;
  const size_t n = std::min(kCandidates, between.size());
  for (size_t i = 0; i < n; ++i) {
    const Pose& candidate = between[i * between.size() / n].cam_from_first;
    const double there = MeanMisfit(between, candidate);
    if (there < least) {
      least = there;
      best = candidate;
    }
  }
  for (int round = 0; round < kRounds; ++round) {
    PoseStep sum = PoseStep::Zero();
    double weights = 0;
    for (const Relative& relative : between) {
      if (Misfit(relative, best) > kMostMisfit) continue;
      const double weight = 1 / (1e-6 + relative.rotation + relative.position);
      sum += weight * Difference(relative.cam_from_first, best);
      weights += weight;
    }
    if (weights > 0) best = Retract(best, sum / weights);
  }
  return best;
}

}  // namespace

Result<RelativeMount> StartMount(const Trajectory& first, const std::vector<FrameEstimate>& frames,
                                 MountedOn mounted_on, double clock_sigma_s) {
  constexpr double kSigmas = 4, kFinestS = 1e-4;
  constexpr int kSteps = 20;  // to either side
  const std::vector<Sample> samples = Spread(frames);
  RelativeMount out;
  double least = HUGE_VAL;
  const auto consider = [&](double clock_s) {
    const std::vector<Relative> between = Between(first, samples, mounted_on, clock_s);
    if (between.size() < kFewestSamples) return;
    const Pose mean = RobustMean(between);
    const double prior = clock_sigma_s > 0 ? std::pow(clock_s / clock_sigma_s, 2) : 0;
    const auto n = static_cast<double>(between.size());
    const double there = MeanMisfit(between, mean) + prior / n;
    if (!(there < least)) return;
    least = there;
    out = {mean, clock_s, static_cast<int>(between.size())};
  };
  consider(0);
  // Ever finer steps about the best.
  for (double step_s = kSigmas * clock_sigma_s / kSteps; step_s > kFinestS; step_s /= 5) {
    const double about_s = out.clock_s;
    for (int i = -kSteps; i <= kSteps; ++i) consider(about_s + i * step_s);
  }
  if (out.frames == 0) {
    return Error{
        Format("fewer than %zu of its frames lie within the first one's time", kFewestSamples)};
  }
  return out;
}

}  // namespace tagtwist::internal

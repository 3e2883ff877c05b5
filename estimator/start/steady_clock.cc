#include "estimator/start/steady_clock.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>

#include "frontend/base/format_text.h"
#include "frontend/base/statistics/quantile.h"

namespace tagtwist::internal {
namespace {

// stamp = first + period * number, from the first stamp on [s].
struct Line {
  double first_s = 0, period_s = 0;
};

Line FitLine(const std::vector<double>& stamps_s, const std::vector<int64_t>& numbers) {
  const auto n = static_cast<double>(numbers.size());
  double mean_t = 0, mean_n = 0;
  for (size_t i = 0; i < numbers.size(); ++i) {
    mean_t += stamps_s[i] / n;
    mean_n += static_cast<double>(numbers[i]) / n;
  }
  double cross = 0, square = 0;
  for (size_t i = 0; i < numbers.size(); ++i) {
    const double dn = static_cast<double>(numbers[i]) - mean_n;
    cross += dn * (stamps_s[i] - mean_t);
    square += dn * dn;
  }
  const double period_s = cross / square;
  return {mean_t - period_s * mean_n, period_s};
}

// No frame lost.
std::vector<int64_t> Consecutive(size_t size) {
  std::vector<int64_t> numbers(size);
  std::iota(numbers.begin(), numbers.end(), int64_t{0});
  return numbers;
}

double MedianInterval(const std::vector<double>& stamps_s) {
  std::vector<double> intervals;
  intervals.reserve(stamps_s.size());
  for (size_t i = 1; i < stamps_s.size(); ++i) intervals.push_back(stamps_s[i] - stamps_s[i - 1]);
  const auto middle = intervals.begin() + static_cast<std::ptrdiff_t>(intervals.size() / 2);
  std::nth_element(intervals.begin(), middle, intervals.end());
  return *middle;
}

// Numbers by a phase-locked loop: a tick runs on at the median interval and is drawn to the stamps,
// so that neither one late stamp nor a slightly wrong period makes it lose count. A frame counts as
// lost where the next stamp is 0.7 periods late: earlier ones may be the jitter's.
std::vector<int64_t> Followed(const std::vector<double>& stamps_s) {
  constexpr double kGain = 0.1;
  const double period_s = std::max(MedianInterval(stamps_s), 1e-6);
  std::vector<int64_t> numbers;
  numbers.reserve(stamps_s.size());
  double tick_s = stamps_s.front();
  int n_late = 0, n_lost = 0;
  for (size_t i = 0; i < stamps_s.size(); ++i) {
    const double t = stamps_s[i];
    const auto steps = static_cast<int64_t>(std::floor((t - tick_s) / period_s + 0.3));
    // Where the next one comes soon, this one was late; the newest is what most were before it.
    const bool is_newest = i + 1 == stamps_s.size();
    const bool is_late = is_newest ? n_late > n_lost : stamps_s[i + 1] - t < 0.5 * period_s;
    if (steps > 1) ++(is_late ? n_late : n_lost);
    const int64_t step = numbers.empty() ? 0 : is_late ? 1 : std::max<int64_t>(1, steps);
    numbers.push_back(numbers.empty() ? 0 : numbers.back() + step);
    tick_s += period_s * static_cast<double>(step);
    tick_s += kGain * (t - tick_s);
  }
  return numbers;
}

// Whether two of three frames come at the tick after the one before: shorter periods fit anything,
// and those of frames stamped in pairs.
bool MostFollow(const std::vector<int64_t>& numbers) {
  size_t follow = 0;
  for (size_t i = 1; i < numbers.size(); ++i) follow += numbers[i] - numbers[i - 1] == 1 ? 1 : 0;
  return 3 * follow > 2 * (numbers.size() - 1);
}

// How many frames a host takes at a time, more than two: the longest run of stamps less than an
// eighth of a long interval apart, where most are. 2 where that is not so.
int FramesAtATime(const std::vector<double>& stamps_s) {
  constexpr int kMost = 8;
  std::vector<double> intervals_s;
  intervals_s.reserve(stamps_s.size());
  for (size_t i = 1; i < stamps_s.size(); ++i) {
    intervals_s.push_back(stamps_s[i] - stamps_s[i - 1]);
  }
  const double soon_s = Quantile(intervals_s, 0.9) / 8;
  if (!(Quantile(intervals_s, 0.5) < soon_s)) return 2;
  int most = 1, run = 1;
  for (const double interval_s : intervals_s) {
    run = interval_s < soon_s ? run + 1 : 1;
    most = std::max(most, run);
  }
  return std::clamp(most, 2, kMost);
}

// Standard deviations of the line's values, for stamps of this scatter, where those of `used` have
// told it.
std::vector<double> TickSigmas(const std::vector<int64_t>& numbers,
                               const std::vector<int64_t>& used, double rms_s) {
  const auto n = static_cast<double>(used.size());
  double mean = 0, square = 0;
  for (const int64_t number : used) mean += static_cast<double>(number) / n;
  for (const int64_t number : used) square += std::pow(static_cast<double>(number) - mean, 2);
  std::vector<double> sigmas;
  sigmas.reserve(numbers.size());
  for (const int64_t number : numbers) {
    const double d = static_cast<double>(number) - mean;
    sigmas.push_back(rms_s * std::sqrt(1 / n + d * d / square));
  }
  return sigmas;
}

// Ticks and stamps apart: root mean square and largest, in periods.
struct Misfit {
  double rms = 0, largest = 0;
};

Misfit MisfitOf(const std::vector<double>& stamps_s, const std::vector<int64_t>& numbers,
                const Line& line) {
  Misfit out;
  for (size_t i = 0; i < stamps_s.size(); ++i) {
    const double d = (stamps_s[i] - line.first_s) / line.period_s - static_cast<double>(numbers[i]);
    out.rms += d * d / static_cast<double>(stamps_s.size());
    out.largest = std::max(out.largest, std::abs(d));
  }
  out.rms = std::sqrt(out.rms);
  return out;
}

// Stamps and their numbers.
struct Numbered {
  std::vector<double> stamps_s;
  std::vector<int64_t> numbers;
};

// Those that were taken in time, where now and then one was taken late, as of a host that was busy:
// most lie close to the line, the others behind it. All where that is not so.
Numbered InTime(const Numbered& all) {
  constexpr double kHalfOfNormal = 1.349;  // standard deviations between its quartiles
  constexpr double kTail = 0.5, kLate = 5;
  constexpr int kRounds = 4;
  Numbered used = all;
  for (int round = 0; round < kRounds; ++round) {
    const Line line = FitLine(used.stamps_s, used.numbers);
    std::vector<double> late(all.numbers.size());
    for (size_t i = 0; i < late.size(); ++i) {
      late[i] =
          all.stamps_s[i] - line.first_s - line.period_s * static_cast<double>(all.numbers[i]);
    }
    const double middle = Quantile(late, 0.5),
                 sigma = std::max((Quantile(late, 0.75) - Quantile(late, 0.25)) / kHalfOfNormal,
                                  1e-3 * line.period_s);
    if (round == 0 &&
        sigma > kTail * MisfitOf(all.stamps_s, all.numbers, line).rms * line.period_s) {
      return all;
    }
    used = {};
    for (size_t i = 0; i < late.size(); ++i) {
      if (late[i] < middle - kLate * sigma) return all;
      if (late[i] > middle + kLate * sigma) continue;
      used.stamps_s.push_back(all.stamps_s[i]);
      used.numbers.push_back(all.numbers[i]);
    }
  }
  constexpr double kMost = 0.7;
  return static_cast<double>(used.numbers.size()) > kMost * static_cast<double>(all.numbers.size())
             ? used
             : all;
}

}  // namespace

std::optional<SteadyClock> FitSteadyClock(const std::vector<int64_t>& stamps_ns) {
  constexpr size_t kLeastStamps = 10;
  constexpr double kMostMisfit = 0.75;  // periods; half a burst's of those that come in bursts
  constexpr double kAtTicks = 0.02, kSteady = 0.005;  // periods
  if (stamps_ns.size() < kLeastStamps) return std::nullopt;
  std::vector<double> stamps_s;
  stamps_s.reserve(stamps_ns.size());
  for (const int64_t t : stamps_ns) {
    stamps_s.push_back(1e-9 * static_cast<double>(t - stamps_ns.front()));
  }
  const int at_a_time = FramesAtATime(stamps_s);
  std::optional<SteadyClock> best;
  std::vector<std::vector<int64_t>> choices = {Consecutive(stamps_s.size())};
  if (at_a_time == 2) choices.push_back(Followed(stamps_s));  // else by the interval in a burst
  for (const std::vector<int64_t>& numbers : choices) {
    if (!MostFollow(numbers)) continue;
    const Line plain = FitLine(stamps_s, numbers);
    // Where all are at the ticks none can be late.
    const bool is_steady = MisfitOf(stamps_s, numbers, plain).rms < kSteady;
    const Numbered late_ones_out = is_steady ? Numbered() : InTime({stamps_s, numbers});
    const std::vector<int64_t>& used = is_steady ? numbers : late_ones_out.numbers;
    const Line line = is_steady ? plain : FitLine(late_ones_out.stamps_s, used);
    const Misfit misfit = MisfitOf(stamps_s, numbers, line),
                 in_time = is_steady ? misfit : MisfitOf(late_ones_out.stamps_s, used, line);
    if (!(in_time.largest < kMostMisfit * (at_a_time - 1))) continue;
    const bool is_evident = used.size() < numbers.size() && in_time.rms < kAtTicks;
    const bool is_as_evident = best && (best->is_evident || !is_evident);
    if (is_as_evident &&
        (best->is_evident != is_evident || best->rms_s <= misfit.rms * line.period_s)) {
      continue;
    }
    best.emplace();
    best->period_s = line.period_s;
    best->rms_s = misfit.rms * line.period_s;
    best->is_evident = is_evident;
    best->sigma_s = TickSigmas(numbers, used, in_time.rms * line.period_s);
    best->t_ns.reserve(numbers.size());
    for (const int64_t number : numbers) {
      const double t_s = line.first_s + line.period_s * static_cast<double>(number);
      best->t_ns.push_back(stamps_ns.front() + static_cast<int64_t>(std::llround(1e9 * t_s)));
    }
  }
  return best;
}

StateCovariance OfClock(const BodyState& state, double sigma_s) {
  StateVector by_time = StateVector::Zero();
  by_time.head<6>() << state.twist.omega_body, state.twist.v_world;
  return sigma_s * sigma_s * by_time * by_time.transpose();
}

std::string TextOf(const SteadyClock& clock) {
  return Format(
      "the camera's clock is steady at %.3f ms, the stamps scatter by %.2f ms RMS around it: "
      "frames are taken at its ticks, and the states are of those; stamps name the frames",
      1e3 * clock.period_s, 1e3 * clock.rms_s);
}

}  // namespace tagtwist::internal

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "estimator/report/findings/findings.h"
#include "frontend/base/format_text.h"
#include "frontend/base/statistics/quantile.h"

namespace tagtwist::internal {
namespace {

using Frames = std::vector<FrameEstimate>;

std::vector<double> TimesOf(const Frames& frames) {
  std::vector<double> out;
  for (const FrameEstimate& f : frames) out.push_back(ToSeconds(f.t_ns - frames.front().t_ns));
  return out;
}

template <typename Test>
std::vector<bool> FlagsOf(const Frames& frames, Test&& test) {
  std::vector<bool> out;
  for (const FrameEstimate& f : frames) out.push_back(test(f));
  return out;
}

size_t CountOf(const std::vector<bool>& flags) {
  return static_cast<size_t>(std::count(flags.begin(), flags.end(), true));
}

// "2.1 % of frames (13 of 612)"
std::string ShareText(size_t count, size_t all) {
  return Format("%.1f %% of frames (%zu of %zu)",
                100 * static_cast<double>(count) / static_cast<double>(all), count, all);
}

bool HasState(const FrameEstimate& f) { return f.status != FrameStatus::kNoFix; }

double Sigma3(const FrameEstimate& f, int first) {
  return std::sqrt(f.covariance.diagonal().segment<3>(first).sum());
}

// Count of the frames with a state for which the flag is as asked.
std::vector<double> Sigmas(const Frames& frames, int first, const std::vector<bool>& flags,
                           bool flag) {
  std::vector<double> out;
  for (size_t i = 0; i < frames.size(); ++i) {
    if (flags[i] == flag && HasState(frames[i])) out.push_back(Sigma3(frames[i], first));
  }
  return out;
}

void AddNoState(const Frames& frames, const std::vector<double>& t_s, std::vector<Finding>* out) {
  const auto flags = FlagsOf(frames, [](const FrameEstimate& f) { return !HasState(f); });
  if (CountOf(flags) == 0) return;
  out->push_back({ShareText(CountOf(flags), frames.size()) + " have no state, at " +
                      StretchesText(t_s, flags) + ".",
                  "No tag had been seen yet, or the tags left two attitudes open: begin over "
                  "several tags, or estimate without --sliding_window, which knows such frames "
                  "from those after them."});
}

void AddAmbiguous(const Frames& frames, const std::vector<double>& t_s, std::vector<Finding>* out) {
  const auto flags = FlagsOf(frames, [](const FrameEstimate& f) {
    return f.status == FrameStatus::kAmbiguous && f.n_tags > 0;
  });
  if (CountOf(flags) == 0) return;
  const auto there = Sigmas(frames, 3, flags, true);
  out->push_back({ShareText(CountOf(flags), frames.size()) + " leave two poses open, at " +
                      StretchesText(t_s, flags) +
                      Format(": their states are the likelier ones, their covariances have both in "
                             "them (position is known to %.3g mm there at worst).",
                             1e3 * Quantile(there, 1)),
                  "Small tags of one plane look alike from two sides: show more of them, larger "
                  "ones, or from nearer and at a slant."});
}

void AddOpenTurns(const Frames& frames, const std::vector<double>& t_s, std::vector<Finding>* out) {
  const auto flags = FlagsOf(frames, [](const FrameEstimate& f) {
    return f.status == FrameStatus::kAmbiguous && f.n_tags == 0;
  });
  if (CountOf(flags) == 0) return;
  out->push_back({ShareText(CountOf(flags), frames.size()) +
                      " lie where no tag was seen and leave open which way the body turned, at " +
                      StretchesText(t_s, flags) +
                      ": their states are the likeliest way, their covariances have the others in "
                      "them.",
                  "Keep tags in view while the body turns: put more of them there."});
}

void AddHurried(const Frames& frames, const std::vector<double>& t_s, std::vector<Finding>* out) {
  const auto flags =
      FlagsOf(frames, [](const FrameEstimate& f) { return f.status == FrameStatus::kHurried; });
  if (CountOf(flags) == 0) return;
  out->push_back({ShareText(CountOf(flags), frames.size()) +
                      " were answered in a hurry, with what was known at the deadline, at " +
                      StretchesText(t_s, flags) + ".",
                  "Allow a longer --deadline_ms, or a smaller --window_frames."});
}

void AddFewTags(const Frames& frames, const TagMap& map, const std::vector<double>& t_s,
                std::vector<Finding>* out) {
  const int enough = map.tags().size() > 1 ? 2 : 1;
  const auto flags = FlagsOf(frames, [&](const FrameEstimate& f) { return f.n_tags < enough; });
  const auto none = FlagsOf(frames, [](const FrameEstimate& f) { return f.n_tags == 0; });
  if (CountOf(flags) == 0) return;
  std::string text = ShareText(CountOf(flags), frames.size()) +
                     (enough == 2 ? " saw fewer than 2 tags" : " saw no tag") + ", at " +
                     StretchesText(t_s, flags);
  if (enough == 2 && CountOf(none) > 0) text += Format("; %zu of them saw none", CountOf(none));
  const auto there = Sigmas(frames, 3, flags, true), elsewhere = Sigmas(frames, 3, flags, false);
  if (!there.empty() && !elsewhere.empty()) {
    text += Format("; position is known to %.1f mm there at worst, elsewhere to %.1f mm (median)",
                   1e3 * Quantile(there, 1), 1e3 * Quantile(elsewhere, 0.5));
  }
  out->push_back({text + ".",
                  "Put more tags there, or keep more of them in view: farther away, slower, with "
                  "more light and a shorter exposure."});
}

// A gap of more than this many intervals is taken for a missing frame.
constexpr double kGap = 1.6;

// Whether the stamps or a steady clock tell the moments better, batch finds out by itself.
void AddRestlessStamps(const Frames& frames, const std::vector<double>& steps,
                       std::vector<Finding>* out) {
  double interval_s = 0, squares = 0;
  for (const double step : steps) interval_s += step / static_cast<double>(steps.size());
  for (const double step : steps) squares += (step - interval_s) * (step - interval_s);
  // An interval has the jitter of two stamps.
  const double jitter_s = std::sqrt(squares / static_cast<double>(steps.size()) / 2);
  std::vector<double> speeds, sigmas;
  for (const FrameEstimate& f : frames) {
    if (!HasState(f)) continue;
    speeds.push_back(f.state.twist.v_world.norm());
    sigmas.push_back(Sigma3(f, 3));
  }
  if (speeds.empty()) return;
  const double speed_mps = Quantile(speeds, 0.5), sigma_m = Quantile(sigmas, 0.5);
  if (!(jitter_s > 0.05 * interval_s && jitter_s * speed_mps > sigma_m)) return;
  out->push_back(
      {Format("Stamps are restless: %.2f ms RMS around an interval of %.1f ms. The body does "
              "%.2g mm in that time (median), and its position is known to %.2g mm.",
              1e3 * jitter_s, 1e3 * interval_s, 1e3 * jitter_s * speed_mps, 1e3 * sigma_m),
       "Fine if frames were taken at just those moments. If the camera's own clock is steadier "
       "than its stamps, this costs accuracy: estimate in batch, which finds out (--clock auto)."});
}

void AddStamps(const Frames& frames, const std::vector<double>& t_s, bool window,
               std::vector<Finding>* out) {
  if (frames.size() < 10) return;
  std::vector<double> steps;
  for (size_t i = 1; i < t_s.size(); ++i) steps.push_back(t_s[i] - t_s[i - 1]);
  const double interval_s = Quantile(steps, 0.5);
  std::vector<double> ordinary;
  size_t gaps = 0;
  double missing = 0;
  for (const double step : steps) {
    if (step > kGap * interval_s) {
      ++gaps;
      missing += std::round(step / interval_s) - 1;
    } else {
      ordinary.push_back(step);
    }
  }
  if (gaps > 0) {
    const auto longest = std::max_element(steps.begin(), steps.end());
    out->push_back(
        {Format("About %.0f frames are missing, in gaps of more than %.1f times the median "
                "interval of %.1f ms (%zu of them); the longest is %.2f s, from %.2f s on.",
                missing, kGap, 1e3 * interval_s, gaps, *longest,
                t_s[static_cast<size_t>(longest - steps.begin())]),
         "States beside a gap are less certain; a camera or a disk that is too slow drops frames.",
         true});
  }
  if (window) AddRestlessStamps(frames, ordinary, out);
}

// Twists known five times worse than the median, away from the ends, where they always are.
void AddBadTwists(const Frames& frames, const std::vector<double>& t_s, std::vector<Finding>* out) {
  constexpr double kEnds = 0.5, kWorse = 5;
  std::vector<double> sigmas;
  for (const FrameEstimate& f : frames) {
    if (HasState(f)) sigmas.push_back(Sigma3(f, 6));
  }
  if (sigmas.empty()) return;
  const double median = Quantile(sigmas, 0.5);
  std::vector<bool> flags(frames.size(), false);
  double worst = 0;
  int least = std::numeric_limits<int>::max(), most = 0;
  for (size_t i = 0; i < frames.size(); ++i) {
    const bool at_end = t_s[i] < kEnds || t_s[i] > t_s.back() - kEnds;
    if (at_end || !HasState(frames[i]) || !(Sigma3(frames[i], 6) > kWorse * median)) continue;
    flags[i] = true;
    worst = std::max(worst, Sigma3(frames[i], 6));
    least = std::min(least, frames[i].n_tags);
    most = std::max(most, frames[i].n_tags);
  }
  if (CountOf(flags) == 0) return;
  const std::string tags = least == most ? Format("%d", most) : Format("%d to %d", least, most);
  out->push_back({Format("Velocity is known to %.3f m/s at worst, against %.4f m/s in the median "
                         "frame, at ",
                         worst, median) +
                      StretchesText(t_s, flags) + ", where " + tags +
                      (most == 1 && least == 1 ? " tag was" : " tags were") + " in use.",
                  ""});
}

void AddDropped(const Estimate& e, const RunFacts& facts, std::vector<Finding>* out) {
  if (!facts.live || facts.live->frames_dropped == 0) return;
  const size_t came = e.frames.size() + facts.live->frames_dropped;
  out->push_back({Format("%zu of %zu frames were dropped: others were still being worked on.",
                         facts.live->frames_dropped, came),
                  "A --deadline_ms, fewer --window_frames or a slower camera leave time for all."});
}

}  // namespace

std::vector<Finding> FrameFindings(const Estimate& e, const RunFacts& facts, const TagMap& map) {
  std::vector<Finding> out;
  if (e.frames.empty()) return out;
  const std::vector<double> t_s = TimesOf(e.frames);
  AddNoState(e.frames, t_s, &out);
  AddDropped(e, facts, &out);
  AddHurried(e.frames, t_s, &out);
  AddFewTags(e.frames, map, t_s, &out);
  AddBadTwists(e.frames, t_s, &out);
  for (Finding& finding : out) finding.is_in_sigmas = true;
  AddAmbiguous(e.frames, t_s, &out);
  AddOpenTurns(e.frames, t_s, &out);
  // Where several cameras take frames the time between two of them says nothing.
  if (e.cameras.size() < 2) {
    AddStamps(e.frames, t_s, e.mode == EstimateMode::kSlidingWindow, &out);
  }
  return out;
}

}  // namespace tagtwist::internal

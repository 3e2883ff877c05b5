#include <algorithm>
#include <cmath>
#include <limits>

#include "estimator/report/findings/findings.h"
#include "estimator/result/run_tally.h"
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

size_t CountOf(const std::vector<bool>& flags) {
  return static_cast<size_t>(std::count(flags.begin(), flags.end(), true));
}

// "2.1 % of frames (13 of 612)"
std::string ShareText(size_t count, size_t all) {
  return Format("%.1f %% of frames (%zu of %zu)",
                100 * static_cast<double>(count) / static_cast<double>(all), count, all);
}

bool HasState(const FrameEstimate& f) { return f.status != FrameStatus::kNoFix; }

void AddNoState(const FrameTally& all, std::vector<Finding>* out) {
  if (all.without_state.count() == 0) return;
  out->push_back({ShareText(all.without_state.count(), all.frames) + " have no state, at " +
                      all.without_state.Text() + ".",
                  "No tag had been seen yet, or the tags left two attitudes open: begin over "
                  "several tags, or estimate without --sliding_window, which knows such frames "
                  "from those after them."});
}

void AddAmbiguous(const FrameTally& all, std::vector<Finding>* out) {
  if (all.ambiguous.count() == 0) return;
  out->push_back({ShareText(all.ambiguous.count(), all.frames) + " leave two poses open, at " +
                      all.ambiguous.Text() +
                      Format(": their states are the likelier ones, their covariances have both in "
                             "them (position is known to %.3g mm there at worst).",
                             1e3 * all.worst_ambiguous_m),
                  "Small tags of one plane look alike from two sides: show more of them, larger "
                  "ones, or from nearer and at a slant."});
}

void AddOpenTurns(const FrameTally& all, std::vector<Finding>* out) {
  if (all.open_turns.count() == 0) return;
  out->push_back({ShareText(all.open_turns.count(), all.frames) +
                      " lie where no tag was seen and leave open which way the body turned, at " +
                      all.open_turns.Text() +
                      ": their states are the likeliest way, their covariances have the others in "
                      "them.",
                  "Keep tags in view while the body turns: put more of them there."});
}

void AddUnheard(const FrameTally& all, std::vector<Finding>* out) {
  if (all.unheard.where.count() == 0) return;
  out->push_back(
      {ShareText(all.unheard.where.count(), all.frames) +
           " show tags that say, one frame after the other, a pose far from the estimate's, at " +
           all.unheard.where.Text() +
           ": the estimate goes by what it knew before, and one of both is wrong.",
       "Look at the closed form there. Faster than the shutter reads its lines? A tag that was "
       "carried off, or another with its id?"});
}

void AddHurried(const FrameTally& all, std::vector<Finding>* out) {
  if (all.hurried.count() == 0) return;
  out->push_back({ShareText(all.hurried.count(), all.frames) +
                      " were answered in a hurry, with what was known at the deadline, at " +
                      all.hurried.Text() + ".",
                  "Allow a longer --deadline_ms, or a smaller --window_frames."});
}

// Frames that see enough are judged by those that are kept.
void AddFewTags(const FrameTally& all, const Frames& kept, const TagMap& map,
                std::vector<Finding>* out) {
  const bool has_several = map.tags().size() > 1;
  const FewTagsTally& few = all.few_tags[has_several ? 1 : 0];
  const size_t none = all.few_tags[0].where.count();
  if (few.where.count() == 0) return;
  std::string text = ShareText(few.where.count(), all.frames) +
                     (has_several ? " saw fewer than 2 tags" : " saw no tag") + ", at " +
                     few.where.Text();
  if (has_several && none > 0) text += Format("; %zu of them saw none", none);
  std::vector<double> elsewhere;
  for (const FrameEstimate& f : kept) {
    if (f.n_tags >= few.fewer_than && HasState(f)) elsewhere.push_back(Sigma3(f.covariance, 3));
  }
  if (few.worst_m && !elsewhere.empty()) {
    text += Format("; position is known to %.1f mm there at worst, elsewhere to %.1f mm (median)",
                   1e3 * *few.worst_m, 1e3 * Quantile(elsewhere, 0.5));
  }
  out->push_back({text + ".",
                  "Put more tags there, or keep more of them in view: farther away, slower, with "
                  "more light and a shorter exposure."});
}

// Whether the stamps or a steady clock tell the moments better, batch finds out by itself.
void AddRestlessStamps(const Frames& kept, const StepTally::Figures& steps,
                       std::vector<Finding>* out) {
  // An interval has the jitter of two stamps.
  const double interval_s = steps.mean_s, jitter_s = std::sqrt(steps.mean_square_s2 / 2);
  std::vector<double> speeds, sigmas;
  for (const FrameEstimate& f : kept) {
    if (!HasState(f)) continue;
    speeds.push_back(f.state.twist.v_world.norm());
    sigmas.push_back(Sigma3(f.covariance, 3));
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

void AddStamps(const FrameTally& all, const Frames& kept, bool window, std::vector<Finding>* out) {
  const auto steps = all.steps.Get();
  if (all.frames < 10 || !steps) return;
  if (steps->gaps > 0) {
    out->push_back(
        {Format("About %.0f frames are missing, in gaps of more than %.1f times the median "
                "interval of %.1f ms (%zu of them); the longest is %.2f s, from %.2f s on.",
                steps->missing, StepTally::kGap, 1e3 * steps->usual_s, steps->gaps,
                steps->longest_s, steps->longest_from_s),
         "States beside a gap are less certain; a camera or a disk that is too slow drops frames.",
         true});
  }
  if (window) AddRestlessStamps(kept, *steps, out);
}

// Twists known five times worse than the median, away from the ends, where they always are. Not
// those that nobody needs to know better.
void AddBadTwists(const Frames& frames, const std::vector<double>& t_s, std::vector<Finding>* out) {
  constexpr double kEnds = 0.5, kWorse = 5, kWellKnownMps = 0.005;
  std::vector<double> sigmas;
  for (const FrameEstimate& f : frames) {
    if (HasState(f)) sigmas.push_back(Sigma3(f.covariance, 6));
  }
  if (sigmas.empty()) return;
  const double median = Quantile(sigmas, 0.5);
  std::vector<bool> flags(frames.size(), false);
  double worst = 0;
  int least = std::numeric_limits<int>::max(), most = 0;
  for (size_t i = 0; i < frames.size(); ++i) {
    const bool at_end = t_s[i] < kEnds || t_s[i] > t_s.back() - kEnds;
    const double limit = std::max(kWorse * median, kWellKnownMps);
    if (at_end || !HasState(frames[i]) || !(Sigma3(frames[i].covariance, 6) > limit)) continue;
    flags[i] = true;
    worst = std::max(worst, Sigma3(frames[i].covariance, 6));
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

void AddDropped(const FrameTally& all, const RunFacts& facts, std::vector<Finding>* out) {
  if (!facts.live || facts.live->frames_dropped == 0) return;
  const size_t came = all.frames + facts.live->frames_dropped;
  out->push_back({Format("%zu of %zu frames were dropped: others were still being worked on.",
                         facts.live->frames_dropped, came),
                  "A --deadline_ms, fewer --window_frames or a slower camera leave time for all."});
}

}  // namespace

std::vector<Finding> FrameFindings(const Estimate& e, const RunFacts& facts, const TagMap& map) {
  std::vector<Finding> out;
  if (e.frames.empty()) return out;
  const FrameTally all = TallyOf(e, facts.all.get()).frames;
  AddNoState(all, &out);
  AddDropped(all, facts, &out);
  AddHurried(all, &out);
  AddFewTags(all, e.frames, map, &out);
  AddBadTwists(e.frames, TimesOf(e.frames), &out);
  for (Finding& finding : out) finding.is_in_sigmas = true;
  AddAmbiguous(all, &out);
  AddOpenTurns(all, &out);
  AddUnheard(all, &out);
  // Where several cameras take frames the time between two of them says nothing.
  if (e.cameras.size() < 2) {
    AddStamps(all, e.frames, e.mode == EstimateMode::kSlidingWindow, &out);
  }
  return out;
}

}  // namespace tagtwist::internal

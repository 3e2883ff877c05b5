#include "estimator/report/html/bound_section.h"

#include <array>
#include <cmath>
#include <limits>

#include "estimator/evaluation/error_bound.h"
#include "estimator/result/run_tally.h"
#include "frontend/base/format_text.h"
#include "frontend/base/units.h"

namespace tagtwist::internal {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

// RMSE / bound of the row with that key, as text of position, attitude, velocity, rate.
std::string RatioText(const std::vector<ComparisonRow>& rows, ComparisonKey key) {
  for (const ComparisonRow& row : rows) {
    if (row.key != key || !row.accuracy || !row.accuracy->rmse_over_bound) continue;
    const BoundRatio& ratio = *row.accuracy->rmse_over_bound;
    std::string out = Format("%.2f, %.2f", ratio.position, ratio.rotation);
    if (ratio.velocity) out += Format(", %.2f, %.2f", *ratio.velocity, *ratio.rate);
    return out;
  }
  return "n/a";
}

std::vector<std::string> PoseCells(const std::string& name, const ErrorBound& b) {
  if (b.frames == 0) return {name, "0", "n/a", "n/a"};
  return {name, std::to_string(b.frames), Format("%.3f", 1e3 * b.position_m),
          Format("%.4f", kDegreesPerRadian * b.rotation_rad)};
}

TextTable Table(const EstimateBounds& bounds, const std::vector<ComparisonRow>& rows) {
  TextTable out = {{"bound, RMS (3-D)", "frames", "position mm", "attitude deg", "vel m/s",
                    "rate rad/s", "RMSE / bound"},
                   PoseCells("each frame's tags alone", bounds.frame),
                   PoseCells("whole estimate", bounds.smoothed)};
  out[1].insert(out[1].end(), {"n/a", "n/a", "n/a"});
  const ErrorBound& s = bounds.smoothed;
  out[2].push_back(s.frames == 0 ? "n/a" : Format("%.4f", s.velocity_mps));
  out[2].push_back(s.frames == 0 ? "n/a" : Format("%.4f", s.rate_radps));
  out[2].push_back(RatioText(rows, bounds.key));
  return out;
}

std::string Words(const Estimate& e, const ErrorBound& alone) {
  std::string out =
      "No unbiased method can do better than the bound (Cramér-Rao) with these corners; the "
      "printed standard deviations are that of the whole estimate. RMSE / bound (position, "
      "attitude, "
      "velocity, rate; with ground truth) is 1 where the estimate takes all that the corners and "
      "the motion's smoothness give. ";
  if (alone.frames == 0) return out + "No frame's tags fix its pose alone.";
  double tags = 0;
  for (const FrameEstimate& f : e.lagged.empty() ? e.frames : e.lagged) {
    tags += f.pose_bound ? f.n_tags : 0;
  }
  const HalfNoiseGain linear = GainOfHalfNoise(e.noise.linear.on);
  out += Format(
      "With %.1f tags a frame on average, one frame alone fixes the position to %.2f mm. That goes "
      "with the corner noise and with one over the square root of the number of tags: a camera "
      "with half the noise, or four times as many tags, halves it. ",
      tags / static_cast<double>(alone.frames), 1e3 * alone.position_m);
  return out + Format(
                   "The whole estimate would gain less, as the neighbours' help is already in "
                   "it: its position about %.1f times, its velocity about %.1f times.",
                   linear.pose, linear.twist);
}

// Standard deviations of the part that begins at `first`, frame by frame.
std::vector<double> OfFrames(const std::vector<FrameEstimate>& frames, int first, double unit) {
  std::vector<double> out;
  for (const FrameEstimate& f : frames) {
    out.push_back(f.status == FrameStatus::kNoFix ? kNone : unit * Sigma3(f.covariance, first));
  }
  return out;
}

std::vector<double> OfTags(const std::vector<FrameEstimate>& frames, int first, double unit) {
  std::vector<double> out;
  for (const FrameEstimate& f : frames) {
    out.push_back(f.pose_bound ? unit * std::sqrt(f.pose_bound->diagonal().segment<3>(first).sum())
                               : kNone);
  }
  return out;
}

Plot Curves(const Estimate& e, const std::vector<double>& t_s, const BoundSlots& slots,
            const std::string& title, int first, double unit) {
  const bool window = e.lagged.size() == t_s.size() && !t_s.empty();
  Plot plot;
  plot.title = title;
  plot.decimals = 4;
  plot.trim = true;
  plot.t_s = t_s;
  plot.series = {{slots.frame_alone, OfTags(window ? e.lagged : e.frames, first, unit), {}},
                 {slots.optimised, OfFrames(e.frames, first, unit), {}}};
  if (window) {
    plot.series.push_back({slots.lagged, OfFrames(e.lagged, first, unit), {}});
  }
  return plot;
}

}  // namespace

ReportSection BoundSection(const Estimate& e, const std::vector<ComparisonRow>& rows,
                           const std::vector<double>& t_s, const BoundSlots& slots) {
  const EstimateBounds bounds = BoundsOf(e);
  return {"Bound",
          ParagraphHtml(Words(e, bounds.frame), "note") + TableHtml(Table(bounds, rows)),
          {Curves(e, t_s, slots, "position bound [mm]", 3, 1e3),
           Curves(e, t_s, slots, "attitude bound [deg]", 0, kDegreesPerRadian)}};
}

}  // namespace tagtwist::internal

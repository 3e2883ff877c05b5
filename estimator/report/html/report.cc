#include "estimator/report/html/report.h"

#include <algorithm>
#include <array>
#include <utility>

#include "estimator/evaluation/pose_series.h"
#include "estimator/report/html/bound_section.h"
#include "estimator/report/html/calibration_section.h"
#include "estimator/report/html/imu_section.h"
#include "estimator/report/html/page.h"
#include "estimator/report/html/pictures.h"
#include "estimator/report/html/plots.h"
#include "estimator/report/html/reprojection_section.h"
#include "estimator/report/html/words.h"
#include "frontend/base/format_text.h"
#include "frontend/base/statistics/quantile.h"

namespace tagtwist::internal {
namespace {

enum Slot : size_t {
  kTruth,
  kClosedForm,
  kOptimised,
  kLagged,
  kTags,
  kTracks,
  kFrameBound,
  kFirstStage
};

PlotInput Plots(const Estimate& e, const ReportInput& input) {
  PlotInput out;
  for (const FrameEstimate& f : e.frames) out.stamps_ns.push_back(f.t_ns);
  out.t0_ns = e.frames.empty() ? 0 : e.frames.front().t_ns;
  out.truth = input.truth;
  out.series.push_back({kClosedForm, ClosedFormSeries(e.frames, ClosedFormVariant::kLowPass), {}});
  out.series.push_back({kOptimised, EstimatedSeries(e.frames), {}});
  if (!e.lagged.empty()) out.series.push_back({kLagged, EstimatedSeries(e.lagged), {}});
  return out;
}

ReportSection FromAbove(const PlotInput& plots, const ReportInput& input,
                        const std::vector<std::string>& slots) {
  std::vector<PicturePath> paths;
  std::vector<size_t> used;
  for (const PlottedSeries& s : plots.series) {
    paths.push_back({s.slot, s.series, s.slot != kClosedForm});
    used.push_back(s.slot);
  }
  if (!input.truth.empty() && !plots.stamps_ns.empty()) {
    PicturePath truth{kTruth, {}, true};
    for (const TruthSample& s : input.truth) {
      if (s.t_ns < plots.stamps_ns.front() || s.t_ns > plots.stamps_ns.back()) continue;
      truth.series.push_back({s.t_ns, s.world_from_body, std::nullopt, std::nullopt});
    }
    paths.insert(paths.begin() + 1, truth);
    used.insert(used.begin(), kTruth);
  }
  return {
      "Trajectory from above",
      ParagraphHtml("The map as printed: x of W runs down, y to the right, in metres. The wheel "
                    "zooms, dragging moves, a double-click shows everything.",
                    "note") +
          LegendHtml(used, slots) + MapPictureSvg(input.map_moves ? TagMap() : input.map, paths),
      {}};
}

Plot OverFrames(const std::string& title, const std::vector<double>& t_s, int decimals) {
  Plot plot;
  plot.title = title;
  plot.decimals = decimals;
  plot.t_s = t_s;
  return plot;
}

ReportSection Counts(const Estimate& e, const std::vector<double>& t_s) {
  Plot tags = OverFrames("tags per frame", t_s, 0), tracks = OverFrames("tracks per frame", t_s, 0);
  PlotSeries tag_series{kTags, {}, {}}, track_series{kTracks, {}, {}};
  for (const FrameEstimate& f : e.frames) {
    tag_series.values.push_back(f.n_tags);
    track_series.values.push_back(f.n_tracks);
  }
  const bool any_tracks = std::any_of(e.frames.begin(), e.frames.end(),
                                      [](const FrameEstimate& f) { return f.n_tracks > 0; });
  tags.series = {std::move(tag_series)};
  tracks.series = {std::move(track_series)};
  std::string html;
  if (!e.frames.empty()) html = TagsOverTimeSvg(e.reprojection, e.frames.front().t_ns);
  if (!html.empty()) html = ParagraphHtml("When each tag was in use, by its id.", "note") + html;
  ReportSection out{"Measurements", html, {std::move(tags)}};
  if (any_tracks) out.plots.push_back(std::move(tracks));
  return out;
}

struct Stage {
  const char* name;
  const std::vector<double>* ms;
  TimeTotal all;
};

std::vector<Stage> Stages(const RunFacts& facts) {
  const StageTimes& times = facts.times;
  const StageTotals all = facts.totals.value_or(StageTotals());
  std::vector<Stage> out = {{"detect", &times.detect_ms, all.detect},
                            {"track", &times.track_ms, all.track},
                            {"seed", &times.seed_ms, all.seed},
                            {"optimise", &times.optimise_ms, all.optimise},
                            {"frame", &times.frame_ms, all.frame}};
  for (Stage& stage : out) {
    if (facts.totals || stage.ms->empty()) continue;
    stage.all = {stage.ms->size(), 0, Quantile(*stage.ms, 1)};
    for (const double ms : *stage.ms) stage.all.sum_ms += ms;
  }
  return out;
}

ReportSection Times(const RunFacts& facts, const std::vector<double>& t_s) {
  TextTable table = {{"stage", "runs", "median ms", "p95 ms", "p99 ms", "max ms", "total s"}};
  Plot plot = OverFrames("time per frame [ms]", t_s, 3);
  size_t slot = kFirstStage;
  for (const Stage& stage : Stages(facts)) {
    const std::vector<double>& ms = *stage.ms;
    const size_t this_slot = slot++;
    if (ms.empty()) continue;
    table.push_back({stage.name, std::to_string(stage.all.count), Format("%.2f", Quantile(ms, 0.5)),
                     Format("%.2f", Quantile(ms, 0.95)), Format("%.2f", Quantile(ms, 0.99)),
                     Format("%.2f", stage.all.max_ms), Format("%.2f", 1e-3 * stage.all.sum_ms)});
    if (ms.size() == t_s.size()) plot.series.push_back({this_slot, ms, {}});
  }
  ReportSection out{"Times", table.size() > 1 ? TableHtml(table) : "", {}};
  if (!plot.series.empty()) out.plots.push_back(std::move(plot));
  return out;
}

// Of a rig's cameras a row each.
ReportSection Cameras(const std::vector<CameraShare>& cameras) {
  TextTable table = {{"camera", "frames with tags", "tags", "used", "RMS px"}};
  for (const CameraShare& camera : cameras) {
    table.push_back({camera.name, std::to_string(camera.frames), std::to_string(camera.tags),
                     std::to_string(camera.used), Format("%.3f", camera.rms_px)});
  }
  return {"Cameras", TableHtml(table), {}};
}

}  // namespace

std::string FormatReport(const Estimate& e, const ReportInput& input) {
  ReportPage page;
  page.title = "tagtwist: " + input.facts.dataset;
  page.html = ReportWordsHtml(e, input);
  page.slots = {"ground truth", "closed form", "optimised",       "optimised, lagged",
                "tags",         "tracks",      "each frame alone"};
  for (const Stage& stage : Stages(input.facts)) page.slots.emplace_back(stage.name);
  if (!e.lagged.empty()) page.slots[kOptimised] = "optimised, lag 0";
  const PlotInput plots = Plots(e, input);
  std::vector<double> t_s;
  for (const int64_t t_ns : plots.stamps_ns) t_s.push_back(ToSeconds(t_ns - plots.t0_ns));
  page.sections.push_back(FromAbove(plots, input, page.slots));
  if (input.calibration) page.sections.push_back(CalibrationSection(*input.calibration));
  if (input.rig) page.sections.push_back(RigSection(*input.rig));
  for (ReportSection& section : TrajectorySections(plots)) {
    page.sections.push_back(std::move(section));
  }
  page.sections.push_back(BoundSection(e, input.rows, t_s, {kFrameBound, kOptimised, kLagged}));
  page.sections.push_back(Counts(e, t_s));
  if (!e.cameras.empty()) page.sections.push_back(Cameras(e.cameras));
  if (auto imu = ImuSection(e)) page.sections.push_back(std::move(*imu));
  if (!e.reprojection_px.empty()) {
    page.sections.push_back(ReprojectionSection(e, input.map));
  }
  page.sections.push_back(Times(input.facts, t_s));
  return FormatReportPage(page);
}

}  // namespace tagtwist::internal

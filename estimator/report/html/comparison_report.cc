#include "estimator/report/html/comparison_report.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "estimator/report/files/summary_json.h"
#include "estimator/report/html/page.h"
#include "estimator/report/html/pictures.h"
#include "estimator/report/html/plots.h"

namespace tagtwist::internal {
namespace {

// The series on the truth's clock and in the truth's frames, so that plots need not align.
PoseSeries Aligned(const PoseSeries& series, const std::optional<Accuracy>& accuracy) {
  if (!accuracy) return series;
  const Alignment& a = accuracy->alignment;
  PoseSeries out;
  out.reserve(series.size());
  for (const PoseSample& s : series) {
    out.push_back(Transform(s, a.truth_from_world, a.body_from_marker));
    out.back().t_ns += std::llround(1e9 * a.time_offset_s);
  }
  return out;
}

PlotInput Plots(const Comparison& c) {
  PlotInput out;
  out.truth = c.truth;
  out.max_truth_gap_s = c.options.alignment.max_truth_gap_s;
  out.connect = true;
  for (size_t i = 0; i < c.series.size(); ++i) {
    out.series.push_back({i + 1, Aligned(c.series[i].series, c.rows[i].accuracy), {}});
    for (const PoseSample& s : out.series.back().series) out.stamps_ns.push_back(s.t_ns);
  }
  std::sort(out.stamps_ns.begin(), out.stamps_ns.end());
  out.stamps_ns.erase(std::unique(out.stamps_ns.begin(), out.stamps_ns.end()), out.stamps_ns.end());
  out.t0_ns = out.stamps_ns.empty() ? 0 : out.stamps_ns.front();
  return out;
}

ReportSection FromAbove(const PlotInput& plots, const std::vector<std::string>& slots) {
  std::vector<PicturePath> paths;
  std::vector<size_t> used;
  for (const PlottedSeries& s : plots.series) {
    paths.push_back({s.slot, s.series, true});
    used.push_back(s.slot);
  }
  PicturePath truth{0, {}, true};
  for (const TruthSample& s : plots.truth) {
    if (s.t_ns < plots.stamps_ns.front() || s.t_ns > plots.stamps_ns.back()) continue;
    truth.series.push_back({s.t_ns, s.world_from_body, std::nullopt, std::nullopt});
  }
  if (!truth.series.empty()) {
    paths.insert(paths.begin(), truth);
    used.insert(used.begin(), 0);
  }
  return {"Trajectories from above", LegendHtml(used, slots) + MapPictureSvg(TagMap(), paths), {}};
}

std::string Words(const Comparison& c) {
  std::string out;
  if (c.truth.empty()) {
    out = ParagraphHtml("There is no ground truth.");
  } else {
    out = ParagraphHtml("Ground truth: " + c.truth_path +
                        ". Alignment: " + ToString(c.options.alignment.kind) + ".");
  }
  return out + TableHtml(ComparisonCells(c.rows, c.options.rpe_seconds)) +
         ParagraphHtml(ComparisonNotes(c.rows), "note");
}

}  // namespace

Result<Comparison> Compare(std::vector<NamedSeries> series, std::vector<TruthSample> truth,
                           const std::string& truth_path, const EvaluationOptions& options) {
  Comparison out{std::move(series), {}, std::move(truth), truth_path, options};
  for (const NamedSeries& named : out.series) {
    ComparisonRow row{named.name, named.series.size(), std::nullopt,
                      ComputeRoughness(named.series)};
    if (!out.truth.empty()) {
      auto accuracy = Evaluate(named.series, out.truth, options);
      if (!accuracy) return Error{named.name + ": " + accuracy.error().message};
      row.accuracy = std::move(*accuracy);
    }
    out.rows.push_back(std::move(row));
  }
  return out;
}

std::string FormatComparisonJson(const Comparison& c) {
  using Json = nlohmann::ordered_json;
  Json out = Json::object();
  out["ground_truth"] = c.truth.empty() ? Json(nullptr) : Json(c.truth_path);
  out["align"] = ToString(c.options.alignment.kind);
  out["inputs"] = Json::array();
  for (const ComparisonRow& row : c.rows) {
    Json input = Json::object();
    input["name"] = row.name;
    input["frames"] = row.frames;
    if (row.accuracy) {
      input["accuracy"] = AccuracyJson(*row.accuracy);
      input["alignment"] = AlignmentJson(row.accuracy->alignment);
    }
    if (row.roughness) {
      input["roughness"] = {{"velocity_mps", row.roughness->velocity_mps},
                            {"rate_radps", row.roughness->rate_radps}};
    }
    out["inputs"].push_back(std::move(input));
  }
  return FormatJson(out);
}

std::string FormatComparisonReport(const Comparison& c) {
  ReportPage page;
  page.title = "tagtwist: comparison";
  page.html = Words(c);
  page.slots = {"ground truth"};
  for (const NamedSeries& named : c.series) page.slots.push_back(named.name);
  const PlotInput plots = Plots(c);
  page.sections.push_back(FromAbove(plots, page.slots));
  for (ReportSection& section : TrajectorySections(plots)) {
    page.sections.push_back(std::move(section));
  }
  return FormatReportPage(page);
}

}  // namespace tagtwist::internal

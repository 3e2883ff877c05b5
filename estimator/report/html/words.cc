#include "estimator/report/html/words.h"

#include <algorithm>
#include <cctype>

#include "estimator/graph/noise_model.h"
#include "estimator/report/findings/findings.h"
#include "estimator/report/findings/verdict.h"
#include "estimator/report/html/page.h"
#include "estimator/result/run_tally.h"
#include "frontend/base/format_text.h"
#include "frontend/base/statistics/quantile.h"

namespace tagtwist::internal {
namespace {

const ComparisonRow* FindRow(const std::vector<ComparisonRow>& rows, ComparisonKey key) {
  for (const ComparisonRow& row : rows) {
    if (row.key == key) return &row;
  }
  return nullptr;
}

std::string WhatWasDone(const Estimate& e, const ReportInput& input) {
  const FrameTally all = TallyOf(e, input.facts.all.get()).frames;
  const size_t predicted = all.count(FrameStatus::kPredicted),
               none = all.count(FrameStatus::kNoFix);
  const size_t before_tags = all.before_first_tag, open = none - before_tags;
  std::string out =
      Format("Pose and twist of the body for %zu of %zu frames", all.with_state, all.frames);
  if (all.frames > 0) out += Format(", %.2f s", ToSeconds(all.last_ns - all.first_ns));
  out += e.mode == EstimateMode::kBatch ? ", estimated from all images together (batch)."
                                        : ", estimated as the images came in (sliding window).";
  if (predicted > 0) {
    out += Format(
        " In %zu frames no tag was usable; their states come from tracks, neighbours and "
        "the motion prior.",
        predicted);
  }
  if (before_tags > 0) {
    out += Format(" %zu frames before the first tag have no state.", before_tags);
  }
  if (const size_t ambiguous = all.count(FrameStatus::kAmbiguous); ambiguous > 0) {
    out += Format(
        " In %zu frames two poses are open, or which way the body turned: the state is the "
        "likelier, the covariance has both in it.",
        ambiguous);
  }
  if (open > 0) {
    out += Format(" In %zu frames the tags left two attitudes open: they have no state.", open);
  }
  if (input.facts.live) out += " It was live.";
  out += Format(" The map has %zu tags, of which %zu were used. It took %.1f s and %.0f MiB.",
                input.map.tags().size(), e.reprojection.tags.size(), input.facts.wall_s,
                input.facts.peak_rss_mib);
  if (!input.facts.all) return out;
  return out + Format(
                   " The run was long: curves, percentiles and errors against truth are of %zu "
                   "frames spread evenly over it; the files have all.",
                   e.frames.size());
}

std::string NoiseText(const Estimate& e) {
  const NoiseModel& n = e.noise;
  const auto density = [](const MotionPrior& prior, const char* unit) {
    const bool jerk = prior.on == WhiteNoiseOn::kJerk;
    const std::string shake =
        prior.shake_s > 0 ? Format(" with a tremor of %.2g ms", 1e3 * prior.shake_s) : "";
    return Format("%s %.3g (%s/s^%d)^2/Hz%s", jerk ? "jerk" : "acceleration", prior.psd, unit,
                  jerk ? 3 : 2, shake.c_str());
  };
  std::string out = Format("Noise (%s): corners %.3g px, tracks %.3g px, %s, angular %s.",
                           NameOf(n.source), n.corner_sigma_px, n.track_sigma_px,
                           density(n.linear, "m").c_str(), density(n.angular, "rad").c_str());
  if (!e.reprojection_px.empty()) {
    out += Format(
        " Corners lie %.3f px (median; 95 %% below %.3f px) from where the estimate puts "
        "them.",
        Quantile(e.reprojection_px, 0.5), Quantile(e.reprojection_px, 0.95));
  }
  return out;
}

std::string AccuracyText(const std::vector<ComparisonRow>& rows) {
  const ComparisonRow* optimised = FindRow(rows, ComparisonKey::kOptimised);
  const ComparisonRow* closed = FindRow(rows, ComparisonKey::kClosedForm);
  if (optimised == nullptr || !optimised->accuracy) {
    return "There is no ground truth to judge by; the table tells how restless the twists are.";
  }
  const Accuracy& a = *optimised->accuracy;
  std::string out = Format("Against ground truth (%zu frames): position %.3g mm RMS (3-D)",
                           a.matched, 1e3 * a.position_m.rmse);
  const bool both = closed != nullptr && closed->accuracy;
  if (both) out += Format(", closed form %.3g mm", 1e3 * closed->accuracy->position_m.rmse);
  if (a.velocity_mps) {
    out += Format("; velocity %.3g m/s", a.velocity_mps->rmse);
    if (both && closed->accuracy->velocity_mps) {
      out += Format(", closed form %.3g m/s", closed->accuracy->velocity_mps->rmse);
    }
  }
  out += ".";
  const auto& nees = a.nees ? a.nees : a.nees_pose;
  if (nees) {
    out += Format(
        " NEES is %.2f for %d degrees of freedom (%.2f each; 1 means that the covariance "
        "is right; below, that it is cautious; above, that it promises too much).",
        nees->mean, nees->dof, nees->per_dof());
  }
  return out;
}

// A warning as a sentence.
std::string Sentence(std::string text) {
  if (text.empty()) return text;
  // A file's name stays as it is.
  const std::string first = text.substr(0, text.find(' '));
  const bool is_word =
      std::all_of(first.begin(), first.end(), [](unsigned char c) { return std::isalpha(c) != 0; });
  if (is_word) text[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(text[0])));
  return text.back() == '.' ? text : text + ".";
}

std::string ItemHtml(const Finding& finding) {
  std::string out = "<li><p>" + EscapeHtml(finding.fact) + "</p>";
  if (!finding.advice.empty()) out += "<p class=\"note\">" + EscapeHtml(finding.advice) + "</p>";
  return out + "</li>\n";
}

std::string FindingsHtml(const Estimate& e, const ReportInput& input) {
  std::vector<Finding> findings;
  for (const std::string& warning : e.warnings) findings.push_back({Sentence(warning), ""});
  for (Finding& finding : Findings(e, input.facts, input.map, input.truth)) {
    findings.push_back(std::move(finding));
  }
  std::string out = "<h2>What to look at</h2>\n";
  if (e.frames.empty()) return out + ParagraphHtml("There is no frame.");
  if (findings.empty()) {
    return out + ParagraphHtml(
                     "Nothing was found that speaks against this estimate. Looked for: frames with "
                     "few tags, missing frames, restless stamps, tags off the map, errors that go "
                     "with the place in the image or with the tag" +
                     std::string(input.truth.empty()
                                     ? "."
                                     : ", constant offsets and clocks apart against truth, "
                                       "covariances that do not cover the errors."));
  }
  out += "<ul class=\"findings\">\n";
  for (const Finding& finding : findings) out += ItemHtml(finding);
  return out + "</ul>\n";
}

}  // namespace

std::string ReportWordsHtml(const Estimate& e, const ReportInput& input) {
  std::string verdict = VerdictText(e, Findings(e, input.facts, input.map, input.truth),
                                    input.truth, input.facts.doubts);
  std::string out = ParagraphHtml("Verdict: " + verdict) + ParagraphHtml(WhatWasDone(e, input));
  if (const std::string certainty = CertaintyText(e); !certainty.empty()) {
    out += ParagraphHtml(certainty);
  }
  out += ParagraphHtml(AccuracyText(input.rows)) + ParagraphHtml(NoiseText(e));
  if (!input.rows.empty()) out += TableHtml(ComparisonCells(input.rows, 1));
  out += ParagraphHtml(ComparisonNotes(input.rows), "note") + FindingsHtml(e, input);
  return out + ParagraphHtml(
                   "Plots: drag to zoom, all of them follow; double-click for everything; "
                   "shift-drag to move; two fingers on a touch screen. The buttons hide "
                   "and show a series everywhere.",
                   "note");
}

}  // namespace tagtwist::internal

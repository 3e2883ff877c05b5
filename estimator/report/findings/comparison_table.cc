#include "estimator/report/findings/comparison_table.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "estimator/result/run_tally.h"
#include "frontend/base/format_text.h"
#include "frontend/base/units.h"

namespace tagtwist {

using namespace internal;
namespace {

constexpr const char* kNothing = "n/a";
constexpr size_t kMaxNameWidth = 32;

[[gnu::format(printf, 2, 0)]] std::string Number(double value, const char* format) {
  std::array<char, 40> text;
  std::snprintf(text.data(), text.size(), format, value);
  return text.data();
}

[[gnu::format(printf, 2, 0)]] std::string Rmse(const std::optional<ErrorStatistics>& statistics,
                                               const char* format) {
  return statistics ? Number(statistics->rmse, format) : kNothing;
}

// NEES per degree of freedom: of the whole state, or of the pose where the truth has no twist.
std::string NeesText(const Accuracy& accuracy) {
  if (accuracy.nees) return Number(accuracy.nees->per_dof(), "%.2f");
  if (accuracy.nees_pose) return Number(accuracy.nees_pose->per_dof(), "%.2f") + " pose";
  return kNothing;
}

std::vector<std::string> AccuracyCells(const ComparisonRow& row) {
  std::vector<std::string> cells = {row.name, std::to_string(row.frames)};
  if (!row.accuracy) {
    cells.resize(8, kNothing);
    return cells;
  }
  const Accuracy& a = *row.accuracy;
  cells.push_back(Number(1e3 * a.position_m.rmse, "%.2f"));
  cells.push_back(Number(kDegreesPerRadian * a.rotation_rad.rmse, "%.3f"));
  cells.push_back(a.rpe_time ? Number(1e3 * a.rpe_time->translation_m.rmse, "%.2f") : kNothing);
  cells.push_back(Rmse(a.velocity_mps, "%.4f"));
  cells.push_back(Rmse(a.rate_radps, "%.4f"));
  cells.push_back(NeesText(a));
  return cells;
}

bool AnyAccuracy(const std::vector<ComparisonRow>& rows) {
  return std::any_of(rows.begin(), rows.end(), [](const auto& r) { return r.accuracy; });
}

// Cuts a long name in its middle, so that both its folder and its file can still be told.
std::string Shorten(const std::string& name) {
  if (name.size() <= kMaxNameWidth) return name;
  const size_t tail = kMaxNameWidth * 2 / 3, head = kMaxNameWidth - tail - 2;
  return name.substr(0, head) + ".." + name.substr(name.size() - tail);
}

std::string Align(const TextTable& table) {
  std::vector<size_t> width(table.front().size(), 0);
  for (const auto& row : table) {
    for (size_t c = 0; c < row.size(); ++c) width[c] = std::max(width[c], row[c].size());
  }
  std::string out;
  for (const auto& row : table) {
    for (size_t c = 0; c < row.size(); ++c) {
      const std::string padding(width[c] - row[c].size(), ' ');
      out += c == 0 ? row[c] + padding : "  " + padding + row[c];
    }
    out.erase(out.find_last_not_of(' ') + 1);
    out += "\n";
    if (&row == &table.front()) {
      size_t total = width[0];
      for (size_t c = 1; c < width.size(); ++c) total += 2 + width[c];
      out += std::string(total, '-') + "\n";
    }
  }
  return out;
}

// Where the hand-eye alignment found the marker, a line a trajectory.
std::string HandEyeNotes(const std::vector<ComparisonRow>& rows) {
  std::string out;
  for (const ComparisonRow& row : rows) {
    if (!row.accuracy || !row.accuracy->alignment.sigmas.Any()) continue;
    const Alignment& a = row.accuracy->alignment;
    const Eigen::Vector3d mm = 1e3 * a.body_from_marker.translation(),
                          sigma_mm = 1e3 * a.sigmas.body_from_marker.tail<3>();
    out += Shorten(row.name) + Format(": marker in the body at %.1f %.1f %.1f mm +- %.1f %.1f %.1f",
                                      mm.x(), mm.y(), mm.z(), sigma_mm.x(), sigma_mm.y(),
                                      sigma_mm.z());
    if (a.sigmas.time_offset_s > 0) {
      out += Format("; clock %.2f ms +- %.2f", 1e3 * a.time_offset_s, 1e3 * a.sigmas.time_offset_s);
    }
    out += "\n";
  }
  return out;
}

std::optional<TwistRoughness> RoughnessOf(const TwistChanges& changes) {
  if (changes.count == 0) return std::nullopt;
  const double scale = 6.0 * static_cast<double>(changes.count);
  return TwistRoughness{std::sqrt(changes.velocity / scale), std::sqrt(changes.rate / scale)};
}

}  // namespace

ComparisonRow MakeComparisonRow(const std::string& name, const PoseSeries& series,
                                const std::vector<TruthSample>& truth,
                                const EvaluationOptions& options) {
  ComparisonRow row{name, series.size(), std::nullopt, ComputeRoughness(series)};
  if (auto accuracy = Evaluate(series, truth, options)) row.accuracy = std::move(*accuracy);
  return row;
}

std::vector<ComparisonRow> CompareMethods(const Estimate& estimate,
                                          const std::vector<TruthSample>& truth,
                                          const EvaluationOptions& options,
                                          const RunTally* all_frames) {
  const RunTally all = TallyOf(estimate, all_frames);
  const auto row = [&](ComparisonKey key, const char* name, const PoseSeries& series,
                       const SeriesTally& tally) {
    ComparisonRow out{name, tally.frames, std::nullopt, RoughnessOf(tally.changes), key};
    if (auto accuracy = Evaluate(series, truth, options)) out.accuracy = std::move(*accuracy);
    // Those that are kept of a long run are not neighbours.
    if (all_frames != nullptr && out.accuracy) out.accuracy->rpe_frames.reset();
    return out;
  };
  const auto closed_form = [&](ComparisonKey key, const char* name, ClosedFormVariant variant) {
    return row(key, name, ClosedFormSeries(estimate.frames, variant),
               all.frames.closed_form[static_cast<size_t>(variant)]);
  };
  const bool window = !estimate.lagged.empty();
  std::vector<ComparisonRow> rows = {
      closed_form(ComparisonKey::kNone, "closed form (plain)", ClosedFormVariant::kPlain),
      closed_form(ComparisonKey::kNone, "closed form (RANSAC)", ClosedFormVariant::kRansac),
      closed_form(ComparisonKey::kClosedForm, "closed form (RANSAC + low-pass)",
                  ClosedFormVariant::kLowPass),
      row(ComparisonKey::kOptimised, window ? "optimised (lag 0)" : "optimised",
          EstimatedSeries(estimate.frames), all.frames.estimated)};
  if (window) {
    rows.push_back(row(ComparisonKey::kOptimisedLagged, "optimised (lagged)",
                       EstimatedSeries(estimate.lagged), all.lagged.estimated));
  }
  return rows;
}

TextTable ComparisonCells(const std::vector<ComparisonRow>& rows, double rpe_seconds) {
  if (AnyAccuracy(rows)) {
    const std::string rpe = "RPE " + Number(rpe_seconds, "%g") + "s mm";
    TextTable table = {
        {"RMSE", "frames", "ATE mm", "ATE deg", rpe, "vel m/s", "rate rad/s", "NEES/dof"}};
    for (const ComparisonRow& row : rows) table.push_back(AccuracyCells(row));
    return table;
  }
  TextTable table = {{"no ground truth", "frames", "velocity noise m/s", "rate noise rad/s"}};
  for (const ComparisonRow& row : rows) {
    const auto& r = row.roughness;
    table.push_back({row.name, std::to_string(row.frames),
                     r ? Number(r->velocity_mps, "%.4f") : kNothing,
                     r ? Number(r->rate_radps, "%.4f") : kNothing});
  }
  return table;
}

std::string ComparisonNotes(const std::vector<ComparisonRow>& rows) {
  if (!AnyAccuracy(rows)) return "noise: RMS of second differences / sqrt(6), of 3-D norms\n";
  const std::string hand_eye = HandEyeNotes(rows);
  for (auto row = rows.rbegin(); row != rows.rend(); ++row) {
    if (!row->accuracy) continue;
    const auto& nees = row->accuracy->nees ? row->accuracy->nees : row->accuracy->nees_pose;
    if (!nees) continue;
    return hand_eye + "NEES/dof: 1 where the covariance is right; 95% band " +
           Number(nees->band_low / nees->dof, "%.2f") + " to " +
           Number(nees->band_high / nees->dof, "%.2f") + " if errors were independent\n";
  }
  return hand_eye;
}

std::string FormatComparisonTable(const std::vector<ComparisonRow>& rows, double rpe_seconds) {
  if (rows.empty()) return "";
  TextTable table = ComparisonCells(rows, rpe_seconds);
  for (auto& row : table) row[0] = Shorten(row[0]);
  return Align(table) + ComparisonNotes(rows);
}

}  // namespace tagtwist

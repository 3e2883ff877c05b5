#include "estimator/fleet/fleet_changes.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>
#include <utility>

#include "estimator/fleet/figures.h"
#include "frontend/base/format_text.h"
#include "frontend/base/statistics/student_t.h"

namespace tagtwist::internal {
namespace {

// Logarithm of how bad a figure is; nullopt where it has none.
std::optional<double> LogOf(const Figure& figure, double value) {
  if (!(value > 0) || !std::isfinite(value)) return std::nullopt;
  const double log = std::log(value);
  return figure.worse == Figure::Worse::kFurtherFromOne ? std::abs(log) : log;
}

std::string KeyOf(const FleetRow& row) {
  std::string out = row.name;
  for (const auto& [flag, value] : row.values) out += '\0' + flag + '\0' + value;
  return out;
}

// New rows with their old ones.
void Pair(const Fleet& old_fleet, const Fleet& new_fleet, FleetChanges* out) {
  std::map<std::string, size_t> old_rows;
  for (size_t i = 0; i < old_fleet.rows.size(); ++i) old_rows.emplace(KeyOf(old_fleet.rows[i]), i);
  for (size_t i = 0; i < new_fleet.rows.size(); ++i) {
    const FleetRow& row = new_fleet.rows[i];
    const auto found = old_rows.find(KeyOf(row));
    out->old_of_new.push_back(found == old_rows.end() ? FleetChanges::kNoRow : found->second);
    if (found == old_rows.end()) {
      ++out->only_new;
      continue;
    }
    const FleetRow& before = old_fleet.rows[found->second];
    if (before.outcome != row.outcome) out->outcomes.push_back({found->second, i});
    if (before.tables_sha256 != row.tables_sha256) ++out->other_tables;
    old_rows.erase(found);
  }
  out->only_old = old_rows.size();
}

// A new row, and the logarithm of its figure over that of its old one.
struct LogRatio {
  size_t row = 0;
  double value = 0;
};

std::vector<LogRatio> LogRatiosOf(size_t figure, const Fleet& old_fleet, const Fleet& new_fleet,
                                  const FleetChanges& pairs) {
  std::vector<LogRatio> out;
  for (size_t i = 0; i < new_fleet.rows.size(); ++i) {
    if (pairs.old_of_new[i] == FleetChanges::kNoRow) continue;
    const FleetRow &now = new_fleet.rows[i], &before = old_fleet.rows[pairs.old_of_new[i]];
    if (now.outcome != FleetOutcome::kDone || before.outcome != FleetOutcome::kDone) continue;
    const auto log_now = LogOf(Figures()[figure], now.figures[figure]);
    const auto log_before = LogOf(Figures()[figure], before.figures[figure]);
    if (log_now && log_before) out.push_back({i, *log_now - *log_before});
  }
  return out;
}

// One a recording: the mean of its rows.
std::vector<double> MeansOfRecordings(const std::vector<LogRatio>& ratios, const Fleet& new_fleet) {
  std::map<std::string, std::pair<double, size_t>> sums;  // of a recording's rows
  for (const LogRatio& ratio : ratios) {
    auto& [sum, count] = sums[new_fleet.rows[ratio.row].name];
    sum += ratio.value;
    ++count;
  }
  std::vector<double> out;
  out.reserve(sums.size());
  for (const auto& [name, of_rows] : sums) {
    out.push_back(of_rows.first / static_cast<double>(of_rows.second));
  }
  return out;
}

// Student's t of the mean; p is that of this figure alone.
FigureChange Judge(size_t figure, const std::vector<double>& ratios) {
  FigureChange out;
  out.figure = figure;
  out.recordings = ratios.size();
  if (ratios.empty()) return out;
  const auto n = static_cast<double>(ratios.size());
  const double mean = std::accumulate(ratios.begin(), ratios.end(), 0.0) / n;
  double squares = 0;
  for (const double x : ratios) squares += (x - mean) * (x - mean);
  out.became_larger = static_cast<size_t>(
      std::count_if(ratios.begin(), ratios.end(), [](double x) { return x > 0; }));
  out.ratio = out.low = out.high = std::exp(mean);
  if (ratios.size() < kLeastRecordings) return out;
  out.is_tested = Figures()[figure].worse != Figure::Worse::kNone;
  const double sigma = std::sqrt(squares / (n - 1) / n);
  const double half_width = sigma * StudentBand(1 - kFleetLevel, n - 1);
  out.low = std::exp(mean - half_width);
  out.high = std::exp(mean + half_width);
  if (sigma > 0) {
    out.p = StudentTwoSided(mean / sigma, n - 1);
  } else {
    out.p = mean == 0 ? 1 : 0;
  }
  return out;
}

// Rows whose ratio the others do not foretell: the mean and spread without it, whose t has two
// degrees of freedom less than there are rows. `tests`: how many there are in all.
void AddSingle(size_t figure, const std::vector<LogRatio>& ratios, size_t tests,
               std::vector<RecordingChange>* out) {
  if (ratios.size() <= kLeastRecordings) return;
  const auto others = static_cast<double>(ratios.size() - 1);
  double sum = 0, squares = 0;
  for (const LogRatio& ratio : ratios) sum += ratio.value;
  for (const LogRatio& ratio : ratios) {
    if (!(std::abs(ratio.value) > std::log(kLeastSingleFactor))) continue;
    const double mean = (sum - ratio.value) / others;
    squares = 0;
    for (const LogRatio& other : ratios) {
      if (other.row != ratio.row) squares += (other.value - mean) * (other.value - mean);
    }
    const double sigma = std::sqrt(squares / (others - 1) * (1 + 1 / others));
    const double off = std::abs(ratio.value - mean);
    const double p = sigma > 0 ? StudentTwoSided(off / sigma, others - 1) : (off > 0 ? 0 : 1);
    if (p * static_cast<double>(tests) >= kFleetLevel) continue;
    out->push_back({ratio.row, figure, std::exp(ratio.value)});
  }
}

// Holm: the smallest p times the number of tests, the next one times one less, and never less than
// the one before.
void CorrectForMany(std::vector<FigureChange>* changes) {
  std::vector<FigureChange*> tested;
  for (FigureChange& change : *changes) {
    if (change.is_tested) tested.push_back(&change);
  }
  std::stable_sort(tested.begin(), tested.end(),
                   [](const FigureChange* a, const FigureChange* b) { return a->p < b->p; });
  double so_far = 0;
  for (size_t i = 0; i < tested.size(); ++i) {
    const double corrected = std::min(1.0, static_cast<double>(tested.size() - i) * tested[i]->p);
    tested[i]->p = so_far = std::max(so_far, corrected);
    tested[i]->is_named =
        so_far < kFleetLevel && std::abs(std::log(tested[i]->ratio)) > kLeastChange;
  }
}

}  // namespace

FleetChanges CompareFleets(const Fleet& old_fleet, const Fleet& new_fleet) {
  FleetChanges out;
  out.old_place = old_fleet.place;
  Pair(old_fleet, new_fleet, &out);
  std::vector<std::vector<LogRatio>> ratios;
  size_t tests = 0;
  for (size_t figure = 0; figure < Figures().size(); ++figure) {
    ratios.push_back(LogRatiosOf(figure, old_fleet, new_fleet, out));
    out.figures.push_back(Judge(figure, MeansOfRecordings(ratios.back(), new_fleet)));
    if (out.figures.back().is_tested) tests += ratios.back().size();
  }
  CorrectForMany(&out.figures);
  for (const FigureChange& change : out.figures) {
    if (change.is_tested) AddSingle(change.figure, ratios[change.figure], tests, &out.single);
  }
  return out;
}

std::string ChangeText(const RecordingChange& change, const Fleet& new_fleet) {
  const Figure& figure = Figures()[change.figure];
  return NameOf(new_fleet.rows[change.new_row]) + ": " + figure.title +
         (figure.unit[0] != '\0' ? std::string(" [") + figure.unit + "]" : "") +
         Format(" %.3g times what it was, unlike the others: %s", change.ratio,
                change.ratio > 1 ? "worse" : "better");
}

std::string ChangeText(const FigureChange& change) {
  const Figure& figure = Figures()[change.figure];
  const bool larger = change.ratio > 1;
  const char* const what = figure.worse == Figure::Worse::kFurtherFromOne
                               ? (larger ? "further from 1" : "nearer to 1")
                               : (larger ? "larger" : "smaller");
  const double best = larger ? change.low : 1 / change.high;
  const double worst = larger ? change.high : 1 / change.low;
  const double middle = larger ? change.ratio : 1 / change.ratio;
  const size_t agree = larger ? change.became_larger : change.recordings - change.became_larger;
  return std::string(figure.title) +
         (figure.unit[0] != '\0' ? std::string(" [") + figure.unit + "]" : "") +
         Format(" %.1f %% %s (99 %%: %.1f to %.1f %%), in %zu of %zu recordings: %s",
                100 * (middle - 1), what, 100 * (best - 1), 100 * (worst - 1), agree,
                change.recordings, larger ? "worse" : "better");
}

}  // namespace tagtwist::internal

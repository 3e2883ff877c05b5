#include <algorithm>
#include <cmath>
#include <utility>

#include "estimator/graph/noise_model.h"
#include "estimator/report/findings/findings.h"
#include "frontend/base/format_text.h"

namespace tagtwist::internal {
namespace {

double Rms(const RatioStatistic& squares) { return std::sqrt(squares.ratio()); }

// Square of a mean, less what chance adds to it.
double SquareOf(const RatioStatistic& mean) {
  if (mean.blocks() < RatioStatistic::kLeastBlocks) return 0;
  return mean.ratio() * mean.ratio() - mean.variance();
}

// What of the errors is the same every time at one place in the image, or at one tag.
struct Systematic {
  bool significant = false;
  double share = 0;  // of the mean square
  double rms_px = 0;
  size_t worst = 0;  // index of the cell
};

Systematic ByPlace(const ReprojectionErrorsByPlace& errors) {
  Systematic out;
  const double least = SignificantScore(2 * errors.cells.size());
  double sum = 0, worst = 0;
  for (size_t i = 0; i < errors.cells.size(); ++i) {
    const RegionErrors& cell = errors.cells[i];
    const double square = SquareOf(cell.u) + SquareOf(cell.v);
    sum += cell.u.weight() * square;
    const bool stands_out = std::abs(cell.u.Score(0)) > least || std::abs(cell.v.Score(0)) > least;
    if (!stands_out) continue;
    out.significant = true;
    if (square > worst) out.worst = i;
    worst = std::max(worst, square);
  }
  out.share = std::max(0.0, sum / (errors.squares.ratio() * errors.squares.weight()));
  out.rms_px = std::sqrt(out.share) * Rms(errors.squares);
  return out;
}

struct OffTag {
  int id = -1;
  double shift_m = 0, sigma_m = 0;
};

// What the tags' places explain, and those that lie off by so much that half of the RMS of their
// own errors comes from it.
Systematic ByTag(const ReprojectionErrorsByPlace& errors, std::vector<OffTag>* off) {
  Systematic out;
  const double least = SignificantScore(2 * errors.tags.size());
  double sum = 0;
  for (const auto& [id, tag] : errors.tags) {
    const double square_m2 = SquareOf(tag.x_m) + SquareOf(tag.y_m);
    const double px_per_m = tag.px_per_m.ratio();
    const double square_px2 = std::max(0.0, square_m2) * px_per_m * px_per_m;
    sum += tag.squares.weight() * square_px2;
    if (std::max(std::abs(tag.x_m.Score(0)), std::abs(tag.y_m.Score(0))) <= least) continue;
    out.significant = true;
    if (!(square_px2 > 0.25 * tag.squares.ratio())) continue;
    off->push_back({id, std::hypot(tag.x_m.ratio(), tag.y_m.ratio()),
                    std::sqrt(tag.x_m.variance() + tag.y_m.variance())});
  }
  out.share = sum / (errors.squares.ratio() * errors.squares.weight());
  out.rms_px = std::sqrt(out.share) * Rms(errors.squares);
  std::stable_sort(off->begin(), off->end(),
                   [](const OffTag& a, const OffTag& b) { return a.shift_m > b.shift_m; });
  return out;
}

std::string PlaceText(size_t cell) {
  const auto columns = static_cast<size_t>(ReprojectionErrorsByPlace::kColumns);
  const auto rows = static_cast<size_t>(ReprojectionErrorsByPlace::kRows);
  const size_t row = 3 * (cell / columns) / rows, column = 3 * (cell % columns) / columns;
  const char* const down[] = {"top", "", "bottom"};
  const char* const across[] = {"left", "", "right"};
  std::string out = down[row];
  if (column != 1) out += (out.empty() ? "" : " ") + std::string(across[column]);
  return out.empty() ? "in the middle" : "at the " + out;
}

// The outermost ring with corners in it against the innermost.
bool GrowsOutwards(const ReprojectionErrorsByPlace& errors, std::pair<double, double>* rms_px) {
  const auto enough = [](const RegionErrors& ring) {
    return ring.squares.blocks() >= RatioStatistic::kLeastBlocks;
  };
  const auto inner = std::find_if(errors.rings.begin(), errors.rings.end(), enough);
  const auto outer = std::find_if(errors.rings.rbegin(), errors.rings.rend(), enough);
  if (inner == errors.rings.end()) return false;
  *rms_px = {Rms(inner->squares), Rms(outer->squares)};
  constexpr double kGrown = 1.3;
  return rms_px->second > kGrown * rms_px->first &&
         ScoreOfDifference(outer->squares, inner->squares) > SignificantScore(1);
}

// True when the lens is accused.
bool AddLens(const ReprojectionErrorsByPlace& errors, const Systematic& by_place,
             const Systematic& by_tag, std::vector<Finding>* out) {
  constexpr double kShare = 0.15;
  std::pair<double, double> rms_px;
  const bool grows = GrowsOutwards(errors, &rms_px);
  const bool is_systematic = by_place.significant && by_place.share > kShare;
  std::string text;
  if (grows) {
    text = Format("Reprojection grows towards the corners, from %.3f to %.3f px RMS", rms_px.first,
                  rms_px.second);
  }
  if (!is_systematic) {
    if (!grows) return false;
    out->push_back({text + ", but not in one direction: chance there, not the lens.",
                    "Blur, darkness or steep views at the border would do that."});
    return false;
  }
  text += grows ? ": corners there" : "Corners";
  text += Format(
              " are off in the same direction again and again, by %.3f px RMS (%.0f %% of the "
              "mean square), most ",
              by_place.rms_px, 100 * by_place.share) +
          PlaceText(by_place.worst) + " of the image";
  if (by_tag.share > by_place.share) {
    text += Format("; that %.0f %% go with the tag speaks for the map rather than the lens",
                   100 * by_tag.share);
    out->push_back({text + ".", "--calibrate refines both; move over more of the map."});
    return false;
  }
  out->push_back({text + ": the lens calibration is off.",
                  "Calibrate the camera anew, or let --calibrate refine the lens from this "
                  "recording; a camera file of other images, or images rectified already, would "
                  "look the same."});
  return true;
}

void AddTags(const ReprojectionErrorsByPlace& errors, const std::vector<OffTag>& off,
             bool lens_is_off, std::vector<Finding>* out) {
  if (off.empty()) return;
  constexpr size_t kNamed = 5;
  std::string text = off.size() == 1 ? "Tag "
                                     : Format(
                                           "%zu of %zu tags in use lie off the map "
                                           "by more than chance: tag ",
                                           off.size(), errors.tags.size());
  for (size_t i = 0; i < std::min(kNamed, off.size()); ++i) {
    if (i > 0) text += ", ";
    text += Format("%d", off[i].id);
    text += off.size() == 1 ? " has moved or is mapped wrongly: it lies " : " by ";
    text += Format("%.1f mm (±%.1f)", 1e3 * off[i].shift_m, 1e3 * off[i].sigma_m);
  }
  if (off.size() == 1) text += " from where the map has it";
  if (off.size() > kNamed) text += Format(" and %zu more", off.size() - kNamed);
  out->push_back({text + ". The estimate gives way to it, so it may be more.",
                  lens_is_off ? "The lens can do that: mend it first."
                              : "Measure them again, pass over them (--movable_tags), or let "
                                "--calibrate move them."});
}

void AddNoise(const NoiseModel& noise, const ReprojectionErrorsByPlace& errors,
              std::vector<Finding>* out) {
  const double sigma_px = std::sqrt(errors.squares.ratio() / 2);
  const double expected = 2 * noise.corner_sigma_px * noise.corner_sigma_px;
  if (!(std::abs(errors.squares.Score(expected)) > SignificantScore(1))) return;
  const double ratio = sigma_px / noise.corner_sigma_px;
  const std::string facts = Format(
      "Corners scatter by %.3f px a coordinate, the given noise is "
      "%.3f px",
      sigma_px, noise.corner_sigma_px);
  const std::string advice = "Leave out --corner_sigma_px: it is learned then.";
  if (noise.corner_is_given && ratio > 1.5) {
    out->push_back({facts + ": the covariances promise too much.", advice});
  } else if (noise.corner_is_given && ratio < 1.0 / 3) {
    out->push_back({facts + ": the estimate is worse than it need be, and too cautious.", advice});
  }
  constexpr double kBadPx = 1;
  if (!noise.corner_is_given && noise.corner_sigma_px > kBadPx && sigma_px > kBadPx) {
    out->push_back({Format("Corners scatter by %.2f px a coordinate; a good set-up stays well "
                           "below %.0f px.",
                           sigma_px, kBadPx),
                    "Look for a camera file or a map of something else, a tag size in other units, "
                    "blur or a rolling shutter."});
  }
}

}  // namespace

std::vector<Finding> ReprojectionFindings(const Estimate& estimate) {
  std::vector<Finding> out;
  const ReprojectionErrorsByPlace& errors = estimate.reprojection;
  if (!(errors.squares.weight() > 0 && errors.squares.ratio() > 0)) return out;
  std::vector<OffTag> off;
  const Systematic by_tag = ByTag(errors, &off);
  const bool lens_is_off = AddLens(errors, ByPlace(errors), by_tag, &out);
  AddTags(errors, off, lens_is_off, &out);
  // Where the estimate looked for errors of lens and map, what it found is in its covariances.
  const bool is_covered = estimate.systematic.position_m > 0;
  for (Finding& finding : out) finding.is_in_sigmas = is_covered;
  AddNoise(estimate.noise, errors, &out);
  return out;
}

}  // namespace tagtwist::internal

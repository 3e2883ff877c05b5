#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <vector>

#include "frontend/base/ratio_statistic.h"

namespace tagtwist {

/// Reprojection errors of an image region, [px] and [px^2] a corner; error = seen - predicted.
struct RegionErrors {
  RatioStatistic squares, u, v;
  void CloseBlock();
};

/// What a tag's corners say of it, averaged over frames.
struct TagErrors {
  RatioStatistic squares;   // of the reprojection error [px^2], a corner
  RatioStatistic x_m, y_m;  // where it seems to lie from its place, in its own frame [m]
  RatioStatistic px_per_m;  // its scale in the image
  struct Interval {
    int64_t first_ns = 0, last_ns = 0;
  };
  std::vector<Interval> seen;        // used in the estimate; short gaps are bridged
  int64_t bridged_ns = 250'000'000;  // as short; doubled where there would be too many intervals
  void CloseBlock();
};

/// Reprojection errors of the tags that an estimate was made with, by place in the image and by
/// tag, in blocks of a second so that means have honest standard deviations (RatioStatistic).
struct ReprojectionErrorsByPlace {
  static constexpr int kColumns = 8, kRows = 6;  // cells of the image, row by row
  /// Rings around the principal point, the image's farthest corner at 1; equally wide.
  static constexpr size_t kRings = 4;
  RatioStatistic squares;  // of all [px^2], a corner
  std::array<RegionErrors, kColumns * kRows> cells;
  std::array<RegionErrors, kRings> rings;
  std::map<int, TagErrors> tags;  // by id
};

}  // namespace tagtwist

#pragma once
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "frontend/base/ratio_statistic.h"
#include "frontend/types/camera.h"
#include "frontend/types/measurements.h"
#include "frontend/types/pose.h"
#include "frontend/types/tag_map.h"

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

/// Collects them. Memory does not grow with the frames.
class ReprojectionTally {
 public:
  ReprojectionTally() = default;
  /// The tags of a frame and where its camera was. Stamps must grow.
  void Add(const Camera& camera, const TagMap& map, int64_t t_ns, const Pose& cam_from_world,
           const std::vector<TagDetection>& tags);
  /// The errors of all frames until now.
  ReprojectionErrorsByPlace Errors() const;

 private:
  void AddTag(const Camera& camera, const TagMap& map, int64_t t_ns, const Pose& cam_from_world,
              const TagDetection& tag);
  void CloseBlock();

  std::optional<int64_t> block_ns_;  // where the open block began
  ReprojectionErrorsByPlace errors_;
};

}  // namespace tagtwist

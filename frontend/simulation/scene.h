#pragma once
#include <Eigen/Core>
#include <memory>
#include <vector>

#include "frontend/base/result.h"
#include "frontend/simulation/scene_parts.h"
#include "frontend/types/tag_family.h"
#include "frontend/types/tag_map.h"

namespace tagtwist::internal {

/// The world that the renderer draws. Immutable; tags and occluders in the order of the map.
class Scene {
 public:
  static Result<Scene> Make(const TagMap& map, const SceneOptions& options);

  const SceneOptions& options() const { return options_; }
  /// The squares at the corners of a Kalibr board's tags.
  const std::vector<Patch>& scribbles() const { return scribbles_; }
  const std::vector<Patch>& tags() const { return tags_; }  // with their paper
  const std::vector<WallSheet>& walls() const { return walls_; }
  /// Occluders swing about their places; t_s moves them.
  std::vector<Patch> OccludersAt(double t_s) const;
  bool all_tags_on_floor() const { return all_tags_on_floor_; }

 private:
  struct Occluder {
    Patch patch;
    Eigen::Vector3d swing = Eigen::Vector3d::Zero();  // amplitude [m]
    double rate_radps = 1, phase_rad = 0;
  };
  void AddOccluders(const Eigen::Vector3d& low, const Eigen::Vector3d& high);

  SceneOptions options_;
  std::shared_ptr<const std::vector<TagPattern>> patterns_;  // tags_ point into it
  std::vector<Patch> tags_, scribbles_;
  std::vector<WallSheet> walls_;
  std::vector<Occluder> occluders_;
  bool all_tags_on_floor_ = false;
};

}  // namespace tagtwist::internal

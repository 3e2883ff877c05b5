#pragma once
#include <optional>
#include <string>
#include <vector>

#include "frontend/base/result.h"
#include "frontend/types/camera.h"
#include "frontend/types/measurements.h"
#include "frontend/types/tag_map.h"

namespace tagtwist::internal {

/// A map from what was seen: from nothing, or besides tags that are known.
struct MappingOptions {
  double tag_size_m = 0;            // side of every unknown tag's black square, > 0
  std::string family = "tag36h11";  // of the map that is made
  std::vector<Tag> known;           // where they are is held, and fixes the world
  std::optional<int> root;          // without known tags: the tag that fixes the world; else the
                                    // one seen most often
  int least_frames = 5;             // that a tag's place must agree in, >= 2
};

struct Mapping {
  TagMap map;  // the known tags, then the new ones; or, by id, in the root's tag frame
  std::vector<Eigen::Matrix<double, 6, 6>> covariances;  // of world_from_tag, in the map's order; 0
                                                         // for known tags and the root
  std::vector<int> left_out;                             // ids seen that could not be placed
  double corner_sigma_px = 0;
};

/// Tags are placed one after the other, from those next to the root outwards: every frame that sees
/// a placed tag proposes where each other one is, with both minima of both poses; the place that
/// most frames agree on is taken, so that no flip survives views from several sides. Then all tags
/// and frames are adjusted together (solver.h), the root or the known tags fixed. An
/// error when the root is never seen or no other tag can be placed; where tags are known no other
/// one needs to be.
Result<Mapping> MapTags(const Camera& camera, const std::vector<FrameMeasurements>& measurements,
                        const MappingOptions& options);

}  // namespace tagtwist::internal

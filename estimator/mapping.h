#pragma once
#include <optional>
#include <string>
#include <vector>

#include "frontend/types/camera.h"
#include "frontend/types/measurements.h"
#include "frontend/types/result.h"
#include "frontend/types/tag_map.h"

namespace tagtwist {

/// A map from nothing but what was seen.
struct MappingOptions {
  double tag_size_m = 0;            // side of every tag's black square, > 0
  std::string family = "tag36h11";  // of the map that is made
  std::optional<int> root;          // the tag that fixes the world; else the one seen most often
  int least_frames = 5;             // that a tag's place must agree in, >= 2
};

struct Mapping {
  TagMap map;                                            // world: the root's tag frame
  std::vector<Eigen::Matrix<double, 6, 6>> covariances;  // of world_from_tag, in the map's order; 0
                                                         // for the root
  std::vector<int> left_out;                             // ids seen that could not be placed
  double corner_sigma_px = 0;
};

/// Tags are placed one after the other, from those next to the root outwards: every frame that sees
/// a placed tag proposes where each other one is, with both minima of both poses; the place that
/// most frames agree on is taken, so that no flip survives views from several sides. Then all tags
/// and frames are adjusted together (calibration_solver.h), the root fixed. An error when the root
/// is never seen or no other tag can be placed.
Result<Mapping> MapTags(const Camera& camera, const std::vector<FrameMeasurements>& measurements,
                        const MappingOptions& options);

}  // namespace tagtwist

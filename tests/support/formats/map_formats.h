#pragma once

namespace tagtwist::internal {

/// Two tags of 0.2 m, ids 0 and 1, 0.25 m from centre to centre, as each program writes them.
constexpr const char* kKalibrGrid = R"(target_type: 'aprilgrid' #gridtype
tagCols: 2               #number of apriltags
tagRows: 1               #number of apriltags
tagSize: 0.2             #size of apriltag, edge to edge [m]
tagSpacing: 0.25         #ratio of space between tags to tagSize
)";

/// The first lies on the floor, its printed right along x; the second stands on the plane x = 1,
/// faces -x, and its printed up is z.
constexpr const char* kWpilibField = R"({
  "tags": [
    {
      "ID": 1,
      "pose": {
        "translation": { "x": 0.1, "y": 0.1, "z": 0.0 },
        "rotation": { "quaternion": { "W": 0.5, "X": -0.5, "Y": -0.5, "Z": -0.5 } }
      }
    },
    {
      "ID": 4,
      "pose": {
        "translation": { "x": 1.0, "y": 0.2, "z": 0.3 },
        "rotation": { "quaternion": { "W": 0.0, "X": 0.0, "Y": 0.0, "Z": 1.0 } }
      }
    }
  ],
  "field": { "length": 16.54175, "width": 8.0137 }
}
)";

constexpr const char* kTagSlam = R"(tagslam_parameters:
  pixel_noise: 1.0
bodies:
  - drone:
      is_static: false
      tags: [{id: 30, size: 0.1}]
  - room:
      is_static: true
      default_tag_size: 0.2
      pose:
        position: {x: 0, y: 0, z: 0}
        rotation: {x: 0, y: 0, z: 0}
      tags:
        - id: 1
          pose:
            position: {x: 0.1, y: 0.1, z: 0}
            rotation: {x: 0, y: 0, z: 0}
        - id: 4
          size: 0.2
          pose:
            position: {x: 1.0, y: 0.2, z: 0.3}
            rotation: {x: 1.2091995761561452, y: -1.2091995761561452, z: -1.2091995761561452}
)";

constexpr const char* kOwnMap = R"(tag_map:
  tags:
    - {id: 1, size_m: 0.2, position_m: [0.1, 0.1, 0]}
    - {id: 4, size_m: 0.2, position_m: [1, 0.2, 0.3], rotation: [0, 0, -1, -1, 0, 0, 0, 1, 0]}
)";

}  // namespace tagtwist::internal

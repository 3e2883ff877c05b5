#pragma once
#include <cstddef>
#include <string>

namespace tagtwist {

/// What one camera of several has in an estimate.
struct CameraShare {
  std::string name;
  size_t frames = 0;  // in which it sees a tag of the map
  size_t tags = 0;    // that it sees in them,
  size_t used = 0;    // and of those that the states are made with,
  double rms_px = 0;  // how far a corner's coordinate is from its prediction, root mean square
};

}  // namespace tagtwist

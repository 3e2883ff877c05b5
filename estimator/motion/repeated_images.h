#pragma once
#include <array>
#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "frontend/types/measurements.h"

namespace tagtwist::internal {

/// Images that a driver, a recorder or a converter gave a second time, under a stamp of their own:
/// that stamp is no exposure, and a body that moves was elsewhere by then. Noise makes no two
/// images of a camera alike to the last bit, but at rest those of a renderer without noise are; so
/// a repeated image counts as one where the tags moved between the two different ones before it.
class RepeatedImages {
 public:
  /// The next frame, of one camera or several. Of cameras that repeat their image while the tags
  /// move, tags and tracks are taken out, and the closed form, which is of them.
  void TakeOut(FrameMeasurements* frame);
  /// Frames with such a camera.
  size_t count() const { return count_; }
  /// For the person who runs it; nullopt without any.
  std::optional<std::string> Warning() const;

 private:
  using Tags = std::vector<std::pair<int, std::array<Eigen::Vector2d, 4>>>;  // by id
  struct Seen {
    Tags tags;           // of the camera's latest image that was not a repeated one
    bool moves = false;  // they, the last time that two different images in a row had any
  };
  bool IsRepeated(const FrameMeasurements& frame, int camera);

  std::map<int, Seen> seen_;  // by camera
  Tags now_;                  // their memory is kept from frame to frame
  std::vector<int> cameras_;
  size_t count_ = 0;
  int64_t first_ns_ = 0;  // of those
};

}  // namespace tagtwist::internal

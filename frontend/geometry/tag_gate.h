#pragma once
#include <optional>
#include <vector>

#include "frontend/types/camera.h"
#include "frontend/types/measurements.h"
#include "frontend/types/tag_map.h"

namespace tagtwist::internal {

/// Keeps out what no tag can look like, before it enters anything: quads that run clockwise, that
/// are not convex, or that are no projection of a square (phantoms; corners bent inwards by the
/// image's border or a hand). A quad's eight numbers leave two to judge it by (SquareMisfitPx);
/// how far right ones are off is learned from the latest.
class TagGate {
 public:
  /// Of a rig's cameras, in order.
  TagGate(TagMap map, std::vector<Camera> cameras);
  TagGate(TagMap map, Camera camera);

  /// Takes out of a frame's tags, all of the map, those that can be none, and returns them. Leaves
  /// in `misfits_px` those of the others (SquareMisfitPx, approximated where that is good), 0 where
  /// there is none, of small or odd tags but the first two, and of tags with a covariance.
  std::vector<TagDetection> TakeRefused(std::vector<TagDetection>* tags,
                                        std::vector<double>* misfits_px = nullptr);

 private:
  void Learn(double misfit_px);
  double SigmaPx();
  double MisfitPx(const TagDetection& tag, double about_px, double sigma_px,
                  int* searches_left) const;
  bool Passes(const TagDetection& tag, const std::optional<double>& about_px,
              double sigma_px) const;

  TagMap map_;
  std::vector<Camera> cameras_;
  std::vector<double> misfits_px_;  // of the latest quads, a ring
  size_t next_ = 0;                 // place in it
  std::optional<double> sigma_px_;  // that they told,
  size_t learned_ = 0;              // so many of them ago
};

}  // namespace tagtwist::internal

#pragma once
#include <Eigen/Core>
#include <optional>
#include <vector>

#include "frontend/types/camera.h"
#include "frontend/types/measurements.h"
#include "frontend/types/tag_map.h"

namespace tagtwist::internal {

/// Focal length [px] of square pixels without distortion, the principal point given, that makes the
/// columns of those homographies (pixel_from_plane, 3x3, any scale) images of orthogonal unit
/// vectors: Zhang 2000, Eqs. 3 and 4, least squares over all. nullopt where they do not tell it:
/// too few, or planes that face the camera.
std::optional<double> FocalLengthByHomographies(
    const std::vector<Eigen::Matrix3d>& pixel_from_plane, const Eigen::Vector2d& principal_point);

/// A lens near enough for a calibration to start from.
struct LensStart {
  Camera camera;
  double error_px = 0;  // median over frames of the root mean square of their corners' errors
};
/// Of that model, of which nothing is known but the image's size: the centre of the image, square
/// pixels, and the focal length by homographies or of a grid (a fifth to four widths; also with a
/// barrel's k1 where the model is radial-tangential), whichever brings the map's corners nearest to
/// the pixels from the homographies' poses; then focal length, centre, k1, k2 and poses by least
/// squares. nullopt where no frame has two tags of one plane of the map.
std::optional<LensStart> FindLensStart(const std::vector<FrameMeasurements>& frames,
                                       const TagMap& map, int width, int height, LensModel lens);

}  // namespace tagtwist::internal

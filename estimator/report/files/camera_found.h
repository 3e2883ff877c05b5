#pragma once
#include <string>
#include <vector>

#include "estimator/calibration/lens/lens_from_nothing.h"

namespace tagtwist::internal {

/// What a calibration from nothing says of itself, as lines for a terminal: its figures, where the
/// image saw corners, the verdict.
std::string CameraFoundText(const LensFound& found);

/// "good: nothing speaks against it", or "not good: " with what would mend it.
std::string CameraVerdict(const LensFound& found);

/// The camera as a configuration (section `camera`), with sigmas, coverage and verdict in comments.
std::string CameraFoundConfig(const LensFound& found);

/// What there is to say of it, a line each: the lens, how it fits, what was refined besides.
std::vector<std::string> CameraFigures(const LensFound& found);

/// Where the image saw corners (SVG): a dot each, cells without any marked.
std::string CoverageSvg(const LensFound& found);

/// A picture (SVG): every corner where the image saw it, cells without any marked, figures and
/// verdict below.
std::string CameraFoundSvg(const LensFound& found);

}  // namespace tagtwist::internal

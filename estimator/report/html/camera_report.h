#pragma once
#include <string>

#include "estimator/calibration/lens/lens_from_nothing.h"

namespace tagtwist::internal {

/// A calibration from nothing as a page that opens without a network: verdict, what is missing, the
/// lens with its sigmas, and where the image was covered. `recording`: as the user named it.
std::string CameraReportHtml(const LensFound& found, const std::string& recording);

}  // namespace tagtwist::internal

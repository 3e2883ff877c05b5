#pragma once
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>

#include "frontend/types/camera.h"

namespace tagtwist::internal {

/// Why an image cannot be the camera's, "the image has 640 x 480 px, the configured camera 376 x
/// 240"; nullopt where it can, and for an empty one.
std::optional<std::string> ImageSizeProblem(const cv::Mat& image, const Camera& camera);

}  // namespace tagtwist::internal

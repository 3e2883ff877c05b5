#include "estimator/online/image_size.h"

namespace tagtwist::internal {

std::optional<std::string> ImageSizeProblem(const cv::Mat& image, const Camera& camera) {
  if (image.empty() || (image.cols == camera.width && image.rows == camera.height)) {
    return std::nullopt;
  }
  return "the image has " + std::to_string(image.cols) + " x " + std::to_string(image.rows) +
         " px, the configured camera " + std::to_string(camera.width) + " x " +
         std::to_string(camera.height);
}

}  // namespace tagtwist::internal

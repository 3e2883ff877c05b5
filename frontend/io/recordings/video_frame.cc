#include "frontend/io/recordings/video_frame.h"

#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>

namespace tagtwist::internal {

bool Grab(cv::VideoCapture* capture) {
  try {
    return capture->grab();
  } catch (const cv::Exception&) {
    return false;
  }
}

void RetrieveGray(cv::VideoCapture* capture, Frame* frame) {
  cv::Mat image;
  try {
    if (!capture->retrieve(image) || image.empty()) {
      frame->image_problem = "cannot decode";
    } else if (image.channels() == 1) {
      frame->image = image.clone();
    } else {
      cv::cvtColor(image, frame->image, cv::COLOR_BGR2GRAY);
    }
  } catch (const cv::Exception&) {
    frame->image_problem = "cannot decode";
  }
}

}  // namespace tagtwist::internal

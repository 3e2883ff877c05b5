#pragma once
#include "frontend/io/recordings/data_source.h"

namespace cv {
class VideoCapture;
}

namespace tagtwist::internal {

/// True when there is a next image; false also where the decoder throws.
bool Grab(cv::VideoCapture* capture);

/// The image that was grabbed last, as 8-bit gray, or why there is none.
void RetrieveGray(cv::VideoCapture* capture, Frame* frame);

}  // namespace tagtwist::internal

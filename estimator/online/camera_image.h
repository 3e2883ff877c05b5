#pragma once
#include <opencv2/core/mat.hpp>

namespace tagtwist {

/// What one camera of the rig (Rig::cameras, by its index) saw.
struct CameraImage {
  int camera = 0;
  cv::Mat image;  // 8-bit gray, of that camera's size; empty: none was read, or a bad one
};

}  // namespace tagtwist

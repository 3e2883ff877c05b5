#pragma once
#include <string>

#include "frontend/types/camera.h"

namespace tagtwist::internal {

/// A 752 x 480 camera with a lens, and the same camera as each program writes it.
inline Camera WideCamera() {
  Camera c;
  c.width = 752, c.height = 480, c.fx = 458.654, c.fy = 457.296, c.cx = 367.215, c.cy = 248.375;
  c.k1 = -0.28340811, c.k2 = 0.07395907, c.p1 = 0.00019359, c.p2 = 1.76187114e-05;
  return c;
}

constexpr const char* kKalibrCamchain = R"(cam0:
  camera_model: pinhole
  cam_overlaps: [1]
  distortion_coeffs: [0.011, -0.002, 0.0003, -0.0001]
  distortion_model: equidistant
  intrinsics: [400.5, 401.5, 320.25, 241.75]
  resolution: [640, 480]
  rostopic: /cam0/image_raw
cam1:
  T_cn_cnm1:
  - [1.0, 0.0, 0.0, -0.11]
  - [0.0, 1.0, 0.0, 0.0]
  - [0.0, 0.0, 1.0, 0.0]
  - [0.0, 0.0, 0.0, 1.0]
  T_cam_imu:
  - [0.0, 1.0, 0.0, 0.5]
  - [-1.0, 0.0, 0.0, -0.25]
  - [0.0, 0.0, 1.0, 0.125]
  - [0.0, 0.0, 0.0, 1.0]
  camera_model: pinhole
  distortion_coeffs: [-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05]
  distortion_model: radtan
  intrinsics: [458.654, 457.296, 367.215, 248.375]
  resolution: [752, 480]
  timeshift_cam_imu: 0.0001
)";

constexpr const char* kOpenCvYaml = R"(%YAML:1.0
---
calibration_time: "Mon Nov 23 13:00:00 2026"
image_width: 752
image_height: 480
flags: 0
camera_matrix: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 4.58654e+02, 0., 3.67215e+02, 0., 4.57296e+02, 2.48375e+02, 0., 0., 1. ]
distortion_coefficients: !!opencv-matrix
   rows: 5
   cols: 1
   dt: d
   data: [ -2.8340811e-01, 7.395907e-02, 1.9359e-04, 1.76187114e-05, 0. ]
avg_reprojection_error: 2.5e-01
)";

constexpr const char* kOpenCvXml = R"(<?xml version="1.0"?>
<opencv_storage>
<image_width>752</image_width>
<image_height>480</image_height>
<camera_matrix type_id="opencv-matrix">
  <rows>3</rows>
  <cols>3</cols>
  <dt>d</dt>
  <data>
    4.58654e+02 0. 3.67215e+02 0. 4.57296e+02 2.48375e+02 0. 0. 1.</data></camera_matrix>
<distortion_coefficients type_id="opencv-matrix">
  <rows>1</rows>
  <cols>4</cols>
  <dt>d</dt>
  <data>
    -2.8340811e-01 7.395907e-02 1.9359e-04 1.76187114e-05</data></distortion_coefficients>
</opencv_storage>
)";

constexpr const char* kRosCameraInfo = R"(image_width: 752
image_height: 480
camera_name: downward
camera_matrix:
  rows: 3
  cols: 3
  data: [458.654, 0, 367.215, 0, 457.296, 248.375, 0, 0, 1]
distortion_model: plumb_bob
distortion_coefficients:
  rows: 1
  cols: 5
  data: [-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05, 0]
rectification_matrix:
  rows: 3
  cols: 3
  data: [1, 0, 0, 0, 1, 0, 0, 0, 1]
projection_matrix:
  rows: 3
  cols: 4
  data: [400, 0, 367, 0, 0, 400, 248, 0, 0, 0, 1, 0]
)";

constexpr const char* kRosTopicEcho = R"(header:
  seq: 3
  frame_id: camera
height: 480
width: 752
distortion_model: plumb_bob
D: [-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05, 0.0]
K: [458.654, 0.0, 367.215, 0.0, 457.296, 248.375, 0.0, 0.0, 1.0]
binning_x: 0
)";

constexpr const char* kOwnCamera = R"(camera:
  width: 752
  height: 480
  fx: 458.654
  fy: 457.296
  cx: 367.215
  cy: 248.375
  distortion_model: radtan
  distortion: [-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05]
)";

}  // namespace tagtwist::internal

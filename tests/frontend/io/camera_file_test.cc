#include "frontend/io/setup/camera_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "estimator/online/config.h"
#include "tests/support/formats/camera_formats.h"
#include "tests/support/formats/spoiled_text.h"
#include "tests/support/test_files.h"

namespace tagtwist::internal::camera_file_test {
namespace {

using ::testing::HasSubstr;

void ExpectSameCamera(const Camera& a, const Camera& b) {
  EXPECT_EQ(a.width, b.width);
  EXPECT_EQ(a.height, b.height);
  EXPECT_EQ(a.lens, b.lens);
  for (double Camera::*k :
       {&Camera::fx, &Camera::fy, &Camera::cx, &Camera::cy, &Camera::k1, &Camera::k2, &Camera::p1,
        &Camera::p2, &Camera::k3, &Camera::k4, &Camera::k5, &Camera::k6}) {
    EXPECT_EQ(a.*k, b.*k);
  }
}

struct Format {
  const char* name;
  const char* file;
  const char* text;
  const char* camera;
};
void PrintTo(const Format& format, std::ostream* out) { *out << format.name; }

class CameraFormat : public testing::TestWithParam<Format> {};

TEST_P(CameraFormat, GivesTheCamera) {
  const TempFolder folder;
  WriteText(folder / GetParam().file, GetParam().text);
  const auto read = ReadCameraFile(folder / GetParam().file, GetParam().camera);
  ASSERT_TRUE(read) << read.error().message;
  ExpectSameCamera(read->camera, WideCamera());
}

// Whatever part of it is there, it is read or refused in one line that begins with the file.
TEST_P(CameraFormat, AnyTruncationIsRefusedOrRead) {
  const TempFolder folder;
  const std::string whole = GetParam().text, path = folder / GetParam().file;
  size_t refused = 0;
  for (size_t size = 0; size < whole.size(); size += 7) {
    WriteText(path, whole.substr(0, size));
    const auto read = ReadCameraFile(path, GetParam().camera);
    if (read) continue;
    ++refused;
    EXPECT_EQ(read.error().message.find(path), 0u);
    EXPECT_EQ(read.error().message.find('\n'), std::string::npos);
  }
  EXPECT_GT(refused, whole.size() / 7 / 3);
}

INSTANTIATE_TEST_SUITE_P(All, CameraFormat,
                         testing::Values(Format{"Kalibr", "camchain.yaml", kKalibrCamchain, "cam1"},
                                         Format{"OpenCvYaml", "cam.yml", kOpenCvYaml, ""},
                                         Format{"OpenCvXml", "cam.xml", kOpenCvXml, ""},
                                         Format{"RosCameraInfo", "cam.yaml", kRosCameraInfo, ""},
                                         Format{"RosTopicEcho", "cam.yaml", kRosTopicEcho, ""},
                                         Format{"Own", "cam.yaml", kOwnCamera, ""}),
                         [](const auto& test) { return std::string(test.param.name); });

TEST(CameraFile, KalibrEquidistantAndMount) {
  const TempFolder folder;
  WriteText(folder / "chain.yaml", kKalibrCamchain);
  const auto first = ReadCameraFile(folder / "chain.yaml", "cam0");
  ASSERT_TRUE(first) << first.error().message;
  EXPECT_EQ(first->camera.lens, LensModel::kEquidistant);
  EXPECT_EQ(first->camera.fy, 401.5);
  EXPECT_EQ(first->camera.k3, 0.0003);
  EXPECT_EQ(first->camera.k4, -0.0001);
  EXPECT_FALSE(first->cam_from_body);
  const auto second = ReadCameraFile(folder / "chain.yaml", "cam1");
  ASSERT_TRUE(second && second->cam_from_body);
  EXPECT_LT((*second->cam_from_body * Eigen::Vector3d(1, 2, 3) - Eigen::Vector3d(2.5, -1.25, 3.125))
                .norm(),
            1e-12);
}

TEST(CameraFile, OpenCvFisheyeAndRationalModels) {
  const TempFolder folder;
  const std::string five = "data: [ -2.8340811e-01, 7.395907e-02, 1.9359e-04, 1.76187114e-05, 0. ]";
  WriteText(folder / "fisheye.yml", Replaced(Replaced(kOpenCvYaml, "flags: 0", "fisheye_model: 1"),
                                             five, "data: [ 0.01, 0.02, 0.03, 0.04 ]"));
  const auto fisheye = ReadCameraFile(folder / "fisheye.yml", "");
  ASSERT_TRUE(fisheye) << fisheye.error().message;
  EXPECT_EQ(fisheye->camera.lens, LensModel::kEquidistant);
  EXPECT_EQ(fisheye->camera.k4, 0.04);
  WriteText(folder / "rational.yml",
            Replaced(kOpenCvYaml, five, "data: [ 1, 2, 3, 4, 5, 6, 7, 8, 0, 0, 0, 0 ]"));
  const auto rational = ReadCameraFile(folder / "rational.yml", "");
  ASSERT_TRUE(rational) << rational.error().message;
  EXPECT_EQ(rational->camera.p2, 4);
  EXPECT_EQ(rational->camera.k3, 5);
  EXPECT_EQ(rational->camera.k6, 8);
}

class BadCamera : public testing::TestWithParam<BadText> {};

TEST_P(BadCamera, IsRefusedWithItsPlace) {
  const TempFolder folder;
  WriteText(folder / "x", Spoiled(GetParam()));
  const auto read = ReadCameraFile(folder / "x", GetParam().text == kKalibrCamchain ? "cam1" : "");
  ASSERT_FALSE(read);
  EXPECT_THAT(read.error().message, NamesTheFault(GetParam()));
}

INSTANTIATE_TEST_SUITE_P(
    All, BadCamera,
    testing::Values(
        BadText{"OmniWithoutXi", kKalibrCamchain, "camera_model: pinhole\n  distortion_coeffs: [-",
                "camera_model: omni\n  distortion_coeffs: [-",
                "x:23: cam1.intrinsics: expected a list of 5 numbers, got a list of 4"},
        BadText{"UnknownModel", kKalibrCamchain, "camera_model: pinhole\n  distortion_coeffs: [-",
                "camera_model: scara\n  distortion_coeffs: [-",
                "x:20: cam1.camera_model: expected one of pinhole, omni, ds, eucm, got scara"},
        BadText{"FovOfFour", kKalibrCamchain, "distortion_model: radtan", "distortion_model: fov",
                "x:21: cam1.distortion_coeffs: expected a list of 1 numbers (w), got 4"},
        BadText{"KalibrThreeCoefficients", kKalibrCamchain, ", 1.76187114e-05]", "]",
                "x:21: cam1.distortion_coeffs: expected a list of 4, 5 or 8 numbers, got 3"},
        BadText{"KalibrIntrinsics", kKalibrCamchain, "[458.654, ", "[",
                "x:23: cam1.intrinsics: expected a list of 4 numbers, got a list of 3"},
        BadText{"KalibrNoResolution", kKalibrCamchain, "resolution: [752, 480]", "nothing: 1",
                "cam1.resolution: expected a value, got none"},
        BadText{"KalibrHalfAPixel", kKalibrCamchain, "[752, 480]", "[752.5, 480]",
                "x:24: cam1.resolution: expected whole numbers"},
        BadText{"KalibrSkewedMount", kKalibrCamchain, "[-1.0, 0.0, 0.0, -0.25]",
                "[-1.0, 0.1, 0.0, -0.25]", "cam1.T_cam_imu: expected a rigid 4 x 4 matrix"},
        BadText{"OpenCvSkew", kOpenCvYaml, "4.58654e+02, 0.,", "4.58654e+02, 0.5,",
                "x:7: camera_matrix: expected [fx, 0, cx, 0, fy, cy, 0, 0, 1], got a skew"},
        BadText{"OpenCvNoSize", kOpenCvYaml, "image_width: 752\n", "",
                "image_width: expected a value, got none"},
        BadText{"OpenCvThinPrism", kOpenCvYaml, "1.76187114e-05, 0. ]",
                "1.76187114e-05, 0., 0., 0., 0., 0.01, 0., 0., 0.  ]",
                "x:12: distortion_coefficients: expected a list of 4, 5 or 8 numbers (calibrate "
                "without thin prism and tilt), got 9"},
        BadText{"OpenCvNoDistortion", kOpenCvYaml, "distortion_coefficients", "nothing",
                "distortion_coefficients: expected a value, got none"},
        BadText{"XmlText", kOpenCvXml, "<image_width>752", "<image_width>wide",
                "x:3: image_width: expected a whole number, got wide"},
        BadText{"XmlTag", kOpenCvXml, "</image_width>", "</image>", "x:3: not valid XML"},
        BadText{"XmlOther", kOpenCvXml, "<opencv_storage>", "<svg>", "x:2: not valid XML"},
        BadText{"RosModel", kRosCameraInfo, "plumb_bob", "thin_prism",
                "x:8: distortion_model: expected one of radtan, radial-tangential, plumb_bob"},
        BadText{"RosZeroSize", kRosCameraInfo, "image_height: 480", "image_height: 0",
                "expected 1..16384, got 0"},
        BadText{"OwnUnknownKey", kOwnCamera,
                "cx:", "centre_x:", "x:6: camera.centre_x: expected one of width"},
        BadText{"OwnWrongLens", kOwnCamera, "radtan\n", "equidistant\n  skew: 0\n",
                "x:9: camera.skew: expected one of "},
        BadText{"OwnNoCoefficients", kOwnCamera, "distortion: [", "# [",
                "camera.distortion: expected a value, got none"}),
    [](const auto& test) { return std::string(test.param.name); });

TEST(CameraFile, OneOfSeveralMustBeNamed) {
  const TempFolder folder;
  const std::string path = folder / "chain.yaml";
  WriteText(path, kKalibrCamchain);
  for (const std::string name : {"", "cam2"}) {
    const auto read = ReadCameraFile(path, name);
    ASSERT_FALSE(read);
    EXPECT_EQ(read.error().message, path + ": camera: expected one of cam0, cam1, got " +
                                        (name.empty() ? "none (all: as a rig)" : name));
  }
  WriteText(path, kRosCameraInfo);
  EXPECT_FALSE(ReadCameraFile(path, "cam0"));
  EXPECT_FALSE(ReadCameraFile(folder / "none.yaml", ""));
}

TEST(CameraFile, IsNamedInAConfigurationBesideIt) {
  const TempFolder folder;
  WriteText(folder / "chain.yaml", kKalibrCamchain);
  WriteText(folder / "config.yaml", "camera: {file: chain.yaml, name: cam1}\n");
  const auto config = LoadConfig(folder / "config.yaml");
  ASSERT_TRUE(config) << config.error().message;
  ExpectSameCamera(config->set_up.rig.front().camera, WideCamera());
  EXPECT_EQ(config->set_up.rig.front().cam_from_body.translation().x(),
            0.5);  // the calibration's mount

  WriteText(folder / "mount.yaml",
            "camera: {file: chain.yaml, name: cam0}\n"
            "cam_from_body: {quaternion_xyzw: [0, 0, 0, 1], translation_m: [7, 8, 9]}\n");
  const ConfigFiles files{folder / "mount.yaml", folder / "chain.yaml", "cam1", {}};
  const auto overridden = LoadConfig(files);
  ASSERT_TRUE(overridden) << overridden.error().message;
  ExpectSameCamera(overridden->set_up.rig.front().camera, WideCamera());
  EXPECT_EQ(overridden->set_up.rig.front().cam_from_body.translation().x(), 7);

  const auto bare = LoadConfig({"", folder / "chain.yaml", "cam0", {}});
  ASSERT_TRUE(bare) << bare.error().message;
  EXPECT_EQ(bare->set_up.rig.front().cam_from_body.params,
            Pose().params);  // the camera is the body
}

}  // namespace
}  // namespace tagtwist::internal::camera_file_test

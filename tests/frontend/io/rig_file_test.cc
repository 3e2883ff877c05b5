// Calibrations of several cameras as their programs write them.
#include "frontend/io/setup/rig/rig_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "frontend/types/so3.h"
#include "tests/support/test_files.h"

namespace tagtwist::internal::rig_file_test {
namespace {

using ::testing::HasSubstr;

constexpr const char* kLens =
    "  camera_model: pinhole\n"
    "  intrinsics: [458, 457, 367, 248]\n"
    "  distortion_model: radtan\n"
    "  distortion_coeffs: [-0.28, 0.07, 0, 0]\n"
    "  resolution: [752, 480]\n";

// A quarter turn about z, and a place.
std::string QuarterTurn(const std::string& key, double x, double y, double z) {
  return "  " + key + ":\n  - [0, -1, 0, " + std::to_string(x) + "]\n  - [1, 0, 0, " +
         std::to_string(y) + "]\n  - [0, 0, 1, " + std::to_string(z) + "]\n  - [0, 0, 0, 1]\n";
}

std::string Camera(const std::string& name, const std::string& more) {
  return name + ":\n" + kLens + more;
}

class RigFile : public ::testing::Test {
 protected:
  Result<std::vector<CameraOfRig>> Read(const std::string& text,
                                        const std::vector<std::string>& names = {}) const {
    WriteText(folder_ / "chain.yaml", text);
    return ReadRigFile(folder_ / "chain.yaml", names, {});
  }
  std::string Fault(const std::string& text, const std::vector<std::string>& names = {}) const {
    const auto read = Read(text, names);
    return read ? "accepted" : read.error().message;
  }
  static void ExpectAt(const CameraOfRig& camera, const Eigen::Vector3d& point_in_body,
                       const Eigen::Vector3d& point_in_cam) {
    ASSERT_TRUE(camera.file.cam_from_body) << camera.name;
    EXPECT_LT((*camera.file.cam_from_body * point_in_body - point_in_cam).norm(), 1e-12)
        << camera.name;
  }
  TempFolder folder_;
};

TEST_F(RigFile, ACamchainWithoutAnImuHasItsFirstCameraForABody) {
  const auto rig = Read(Camera("cam0", "  rostopic: /a\n") +
                        Camera("cam1", QuarterTurn("T_cn_cnm1", 1, 0, 0) + "  rostopic: /b\n") +
                        Camera("cam2", QuarterTurn("T_cn_cnm1", 0, 0, 5)));
  ASSERT_TRUE(rig) << rig.error().message;
  ASSERT_EQ(rig->size(), 3U);
  ExpectAt((*rig)[0], {1, 2, 3}, {1, 2, 3});
  ExpectAt((*rig)[1], {1, 2, 3}, {-2 + 1, 1, 3});
  ExpectAt((*rig)[2], {1, 2, 3}, {-1, -1, 3 + 5});  // of cam1's point, turned once more
  EXPECT_EQ((*rig)[1].topic, "/b");
  EXPECT_TRUE((*rig)[1].file.notes.empty());  // its tie is used
}

TEST_F(RigFile, TheImuIsTheBodyWhereTheCamchainKnowsIt) {
  const std::string text =
      Camera("cam0", QuarterTurn("T_cam_imu", 0, 0, 1) + "  timeshift_cam_imu: 0.005\n") +
      Camera("cam1", QuarterTurn("T_cn_cnm1", 1, 0, 0) + "  timeshift_cam_imu: 0.002\n");
  const auto rig = Read(text);
  ASSERT_TRUE(rig) << rig.error().message;
  ExpectAt((*rig)[0], {1, 2, 3}, {-2, 1, 4});
  ExpectAt((*rig)[1], {1, 2, 3}, {-1 + 1, -2, 4});
  // The IMU's time less both shifts: what cam1 stamps 3 ms later cam0 sees at the same time.
  EXPECT_EQ((*rig)[0].clock_offset_s, 0);
  EXPECT_NEAR((*rig)[1].clock_offset_s, -0.003, 1e-15);
  const auto other = Read(text, {"cam1"});
  ASSERT_TRUE(other) << other.error().message;
  ExpectAt(other->front(), {1, 2, 3}, {0, -2, 4});  // by the camera that is not asked for
  EXPECT_EQ(other->front().clock_offset_s, 0);
}

TEST_F(RigFile, TagSlamsCamerasHaveTheirPosesBesideThem) {
  const std::string text = Camera("cam0", "  rig_body: rig\n  tagtopic: /a/tags\n") +
                           Camera("cam1", "  rig_body: rig\n");
  EXPECT_THAT(Fault(text), HasSubstr("chain.yaml: cam1: expected T_cn_cnm1 or T_cam_imu, or "
                                     "camera_poses.yaml beside it"));
  WriteText(folder_ / "camera_poses.yaml",
            "cam0:\n  position: {x: 0, y: 0, z: 0}\n  rotvec: {x: 0, y: 0, z: 0}\n"
            "cam1:\n  pose:\n    position: {x: 0.2, y: 0, z: 0}\n"
            "    rotation: {x: 0, y: 0, z: 1.5707963267948966}\n    R: [1, 2, 3]\n");
  const auto rig = Read(text);
  ASSERT_TRUE(rig) << rig.error().message;
  ExpectAt((*rig)[0], {1, 2, 3}, {1, 2, 3});
  ExpectAt((*rig)[1], {0.2, 1, 0}, {1, 0, 0});  // the pose is the camera's in the body
}

TEST_F(RigFile, CamerasOfAnotherBodyOrThatStandAreRefused) {
  const std::string other = Camera("cam0", "  rig_body: a\n") + Camera("cam1", "  rig_body: b\n") +
                            Camera("cam2", QuarterTurn("T_cn_cnm1", 0, 0, 0) + "  rig_body: b\n");
  EXPECT_THAT(Fault(other), HasSubstr("chain.yaml:8: cam1: expected a camera of the same body"));
  EXPECT_THAT(Fault(other, {"cam1", "cam2"}), HasSubstr("got no place on the rig"));
  EXPECT_THAT(Fault(Camera("cam0", "  rig_body: a\n  is_static: true\n")),
              HasSubstr("mounted_on: world"));
}

TEST_F(RigFile, FaultsAreToldWithTheFile) {
  const std::string two = Camera("cam0", "") + Camera("cam1", QuarterTurn("T_cn_cnm1", 1, 0, 0));
  EXPECT_EQ(Fault(two), "accepted");
  EXPECT_EQ(Fault(two, {"cam1", "cam0"}), "accepted");
  EXPECT_THAT(Fault(two, {"cam0", "cam7"}),
              HasSubstr("chain.yaml: camera: expected some of cam0, cam1, got cam7"));
  EXPECT_THAT(Fault(two, {"cam0", "cam0"}), HasSubstr("got cam0 twice"));
  EXPECT_THAT(Fault("width: 3\n"), HasSubstr("expected several cameras"));
  EXPECT_THAT(Fault(two + "  timeshift_cam_imu: 0.1\n"),
              HasSubstr("cam1: expected timeshift_cam_imu of all cameras or of none"));
  EXPECT_THAT(
      Fault(Camera("cam0", "  timeshift_cam_imu: -1e308\n") +
            Camera("cam1", QuarterTurn("T_cn_cnm1", 1, 0, 0) + "  timeshift_cam_imu: 1e308\n")),
      HasSubstr("cam1: timeshift_cam_imu: expected at most 2e9 s"));
  EXPECT_THAT(Fault(two + "  rostopic: [1]\n"), HasSubstr("rostopic"));
  EXPECT_THAT(Fault(Camera("cam0", "") + Camera("cam1", "")), HasSubstr("got no place"));
}

TEST_F(RigFile, AFolderOfEurocsHasASensorFileForEach) {
  EXPECT_THAT(ReadRigFile(folder_.path(), {}, {}).error().message,
              HasSubstr("expected cam0/sensor.yaml, cam1/sensor.yaml, ... (EuRoC), got none"));
  for (const char* name : {"cam0", "cam1"}) {
    const std::string camera = folder_ / "mav0/" + name;
    std::filesystem::create_directories(camera);
    const double x = name[3] == '0' ? 0 : 0.1;
    WriteText(camera + "/sensor.yaml",
              "sensor_type: camera\nT_BS:\n  cols: 4\n  rows: 4\n  data: [0, -1, 0, " +
                  std::to_string(x) +
                  ", 1, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]\n"
                  "resolution: [752, 480]\ncamera_model: pinhole\nintrinsics: [458, 457, 367, "
                  "248]\ndistortion_model: radial-tangential\n"
                  "distortion_coefficients: [-0.28, 0.07, 0, 0]\n");
  }
  for (const std::string& path : {folder_.path(), folder_ / "mav0"}) {
    const auto rig = ReadRigFile(path, {}, {});
    ASSERT_TRUE(rig) << rig.error().message;
    ASSERT_EQ(rig->size(), 2U);
    ExpectAt((*rig)[1], {0.1, 1, 0}, {1, 0, 0});
  }
}

}  // namespace
}  // namespace tagtwist::internal::rig_file_test

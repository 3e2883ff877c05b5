#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "estimator/online/config.h"
#include "estimator/online/config_text.h"
#include "estimator/online/recording_options.h"
#include "tests/support/config_of_text.h"
#include "tests/support/test_files.h"

namespace tagtwist::internal::cameras_config_test {
namespace {

using testing::HasSubstr;
using testing::Not;

constexpr const char* kLens =
    "    camera: {width: 376, height: 240, fx: 311, fy: 312, cx: 201, cy: 113}\n";
constexpr const char* kMount =
    "    cam_from_body: {quaternion_xyzw: [0, 0, 0, 1], translation_m: [0.1, 0, 0.2]}\n";

std::string Two() {
  return std::string("cameras:\n  - name: left\n") + kLens + kMount + "  - name: right\n" + kLens +
         kMount + "    clock_offset_s: -0.007\n    recording: sub/r\n    topic: /r/image\n";
}

TEST(CamerasSection, SaysWhereEachCameraIsAndWhereItsRecording) {
  const auto config = ConfigOfText(Two());
  ASSERT_TRUE(config) << config.error().message;
  ASSERT_EQ(config->set_up.rig.cameras.size(), 2U);
  EXPECT_TRUE(config->set_up.rig.IsOfSeveral());
  const RigCamera& right = config->set_up.rig.cameras[1];
  EXPECT_EQ(right.name, "right");
  EXPECT_EQ(right.clock_offset_s, -0.007);
  EXPECT_EQ(right.camera.fy, 312);
  EXPECT_EQ(right.cam_from_body.translation().z(), 0.2);
  ASSERT_EQ(config->recordings.size(), 2U);
  EXPECT_EQ(config->recordings[0].path, "left");
  EXPECT_EQ(config->recordings[1].path, "sub/r");
  EXPECT_EQ(config->recordings[1].topic, "/r/image");
}

TEST(CamerasSection, IsWrittenAsItIsRead) {
  const auto config = ConfigOfText(Two());
  ASSERT_TRUE(config) << config.error().message;
  const std::string text = CamerasSectionText(*config);
  const auto again = ConfigOfText(text);
  ASSERT_TRUE(again) << again.error().message;
  EXPECT_EQ(CamerasSectionText(*again), text);
  EXPECT_EQ(again->set_up.rig.cameras[1].cam_from_body.params,
            config->set_up.rig.cameras[1].cam_from_body.params);
}

TEST(CamerasSection, FaultsAreToldWithTheirLine) {
  EXPECT_THAT(FaultOfText("cameras: 3\n"),
              HasSubstr("x.yaml:1: cameras: expected a list of cameras"));
  EXPECT_THAT(FaultOfText("cameras: []\n"), HasSubstr("expected a list of cameras"));
  EXPECT_THAT(FaultOfText(std::string("cameras:\n  - name: a\n") + kLens),
              HasSubstr("expected cam_from_body, or a calibration with a mount"));
  EXPECT_THAT(FaultOfText(std::string("cameras:\n  - name: a\n") + kMount), HasSubstr("camera"));
  EXPECT_THAT(FaultOfText(std::string("cameras:\n  - name: a\n") + kLens + kMount +
                          "  - name: a\n" + kLens + kMount),
              HasSubstr("expected a name that no other camera has"));
  EXPECT_THAT(FaultOfText(Two() + "    lens: 3\n"), HasSubstr("lens"));
  EXPECT_THAT(
      FaultOfText(Two() + "camera: {width: 376, height: 240, fx: 1, fy: 1, cx: 1, cy: 1}\n"),
      HasSubstr("beside several cameras"));
  EXPECT_THAT(FaultOfText(std::string("cameras:\n  - name: a\n") + kLens + kMount +
                          "    clock_offset_s: 3e9\n"),
              HasSubstr("from -2e9 to 2e9 s"));
}

TEST(CamerasSection, OneRecordingForTwoCamerasIsRefused) {
  const TempFolder folder;
  const auto config = ConfigOfText(std::string("cameras:\n  - name: left\n") + kLens + kMount +
                                   "  - name: right\n" + kLens + kMount + "    recording: left\n");
  ASSERT_TRUE(config) << config.error().message;
  EXPECT_THAT(OpenRecording(folder.path(), *config, {}).error().message,
              HasSubstr("got one for left and right"));
}

TEST(CamerasSection, ARecordingOfEurocsLiesInMav0) {
  const TempFolder folder;
  std::filesystem::create_directories(folder / "mav0/right");
  const auto config = ConfigOfText(std::string("cameras:\n  - name: right\n") + kLens + kMount);
  ASSERT_TRUE(config) << config.error().message;
  EXPECT_THAT(OpenRecording(folder.path(), *config, {}).error().message,
              HasSubstr("mav0/right: expected a data set"));
  std::filesystem::create_directories(folder / "right");
  EXPECT_THAT(OpenRecording(folder.path(), *config, {}).error().message,
              Not(HasSubstr("mav0/right: expected")));
}

TEST(CamerasSection, SeveralOfACameraFileAreARig) {
  const TempFolder folder;
  const std::string lens =
      ":\n  camera_model: pinhole\n  intrinsics: [311, 311, 187, 119]\n  distortion_model: none\n"
      "  resolution: [376, 240]\n  T_cam_imu: [[1, 0, 0, 0.5], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, "
      "0, 1]]\n";
  WriteText(folder / "chain.yaml", "cam0" + lens + "cam1" + lens + "cam2" + lens);
  ConfigFiles files;
  files.camera_file = folder / "chain.yaml";
  for (const auto& [names, count] :
       {std::pair("all", 3U), std::pair("cam2,cam0", 2U), std::pair("cam1", 0U)}) {
    files.camera_name = names;
    const auto config = LoadConfig(files);
    ASSERT_TRUE(config) << config.error().message;
    EXPECT_EQ(config->recordings.size(), count) << names;
    EXPECT_EQ(config->set_up.rig.cameras.back().cam_from_body.translation().x(), 0.5);
  }
  files.camera_name = "cam2,cam0";
  EXPECT_EQ(LoadConfig(files)->set_up.rig.cameras.front().name, "cam2");
  WriteText(folder / "x.yaml", kMount + 4);  // without its indentation
  files.config = folder / "x.yaml";
  EXPECT_THAT(LoadConfig(files).error().message, HasSubstr("beside several cameras"));
  EXPECT_THAT(FaultOfText("cameras: {file: none.yaml, name: cam0}\n"), HasSubstr("name"));
  EXPECT_THAT(FaultOfText("cameras: {file: none.yaml, names: []}\n"),
              HasSubstr("expected a list of names"));
}

TEST(CamerasSection, ACameraFileBesideItIsRefused) {
  const TempFolder folder;
  WriteText(folder / "x.yaml", Two());
  ConfigFiles files;
  files.config = folder / "x.yaml";
  files.camera_file = folder / "lens.yaml";
  const auto config = LoadConfig(files);
  ASSERT_FALSE(config);
  EXPECT_THAT(config.error().message, HasSubstr("--camera_file is of one camera"));
}

}  // namespace
}  // namespace tagtwist::internal::cameras_config_test

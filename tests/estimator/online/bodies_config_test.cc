#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "estimator/online/config.h"
#include "estimator/online/config_text.h"
#include "tests/support/config_of_text.h"
#include "tests/support/test_files.h"

namespace tagtwist::internal::bodies_config_test {
namespace {

using testing::HasSubstr;

const std::string kCamera =
    "  - name: left\n"
    "    camera: {width: 376, height: 240, fx: 311, fy: 312, cx: 201, cy: 113}\n";
const std::string kPose = "{quaternion_xyzw: [0, 0, 0, 1], translation_m: [0.1, 0, 0.2]}\n";
const std::string kStands = "    mounted_on: world\n    cam_from_world: " + kPose;

std::string Tags(int id) {
  return "tags: [{id: " + std::to_string(id) + ", size_m: 0.1, position_m: [0, 0, 0]}]";
}
std::string Bodies(const std::string& more = "") {
  return "tag_map: {" + more + "bodies: [{name: a, " + Tags(1) + "}, {name: b, " + Tags(2) +
         "}]}\n";
}

TEST(Bodies, BeforeCamerasThatStandTheFirstIsTheOneThatIsReported) {
  const auto config = ConfigOfText("cameras:\n" + kCamera + kStands + Bodies());
  ASSERT_TRUE(config) << config.error().message;
  EXPECT_EQ(config->set_up.rig.mounted_on, MountedOn::kWorld);
  EXPECT_EQ(config->body, "a");
  EXPECT_NE(config->set_up.map.Find(1), nullptr);
  ASSERT_EQ(config->bodies.size(), 1U);
  EXPECT_EQ(config->bodies[0].name, "b");
  EXPECT_NE(config->bodies[0].map.Find(2), nullptr);
  EXPECT_EQ(config->AllTags().tags().size(), 2U);
  EXPECT_EQ(config->SetUps().size(), 2U);
  EXPECT_EQ(config->estimator.clock, ClockChoice::kStamps);
}

TEST(Bodies, BeforeACameraThatMovesAllAreBesidesTheTagsThatStand) {
  const auto config = ConfigOfText(Bodies(Tags(7) + ", "));
  ASSERT_TRUE(config) << config.error().message;
  EXPECT_EQ(config->body, "");
  EXPECT_NE(config->set_up.map.Find(7), nullptr);
  EXPECT_EQ(config->bodies.size(), 2U);
}

TEST(Bodies, OneCameraThatStandsNeedsNoList) {
  const auto config = ConfigOfText("cam_from_world: " + kPose + "tag_map: {" + Tags(3) + "}\n");
  ASSERT_TRUE(config) << config.error().message;
  EXPECT_EQ(config->set_up.rig.mounted_on, MountedOn::kWorld);
  EXPECT_TRUE(config->recordings.empty());
  EXPECT_THAT(MountSectionText(*config), HasSubstr("cam_from_world"));
}

TEST(Bodies, CamerasThatStandAreWrittenAsTheyAreRead) {
  const auto config = ConfigOfText("cameras:\n" + kCamera + kStands);
  ASSERT_TRUE(config) << config.error().message;
  const auto again = ConfigOfText(CamerasSectionText(*config));
  ASSERT_TRUE(again) << again.error().message;
  EXPECT_EQ(again->set_up.rig.mounted_on, MountedOn::kWorld);
  EXPECT_EQ(CamerasSectionText(*again), CamerasSectionText(*config));
}

TEST(Bodies, FaultsAreToldWithTheirLine) {
  const std::string cameras = "cameras:\n" + kCamera + kStands;
  const auto map = [&](const std::string& text) {
    return FaultOfText(cameras + "tag_map: " + text + "\n");
  };
  EXPECT_THAT(map("{bodies: 3}"), HasSubstr("x.yaml:6: tag_map.bodies: expected a list of bodies"));
  EXPECT_THAT(map("{bodies: [3]}"), HasSubstr("expected a body's keys"));
  EXPECT_THAT(map("{bodies: [{" + Tags(1) + "}]}"), HasSubstr("expected name"));
  EXPECT_THAT(map("{bodies: [{name: \"../x\", " + Tags(1) + "}]}"), HasSubstr("letters, digits"));
  EXPECT_THAT(map("{bodies: [{name: lagged, " + Tags(1) + "}]}"), HasSubstr("letters, digits"));
  EXPECT_THAT(map("{bodies: [{name: a, " + Tags(1) + "}, {name: a, " + Tags(2) + "}]}"),
              HasSubstr("a name that no other body has"));
  EXPECT_THAT(map("{bodies: [{name: a, " + Tags(1) + "}, {name: b, " + Tags(1) + "}]}"),
              HasSubstr("each id once, got 1 of a again"));
  EXPECT_THAT(FaultOfText(cameras + Bodies(Tags(7) + ", ")), HasSubstr("no tags beside them"));
  EXPECT_THAT(FaultOfText(Bodies()), HasSubstr("tags that stand beside them"));
  EXPECT_THAT(FaultOfText(Bodies(Tags(2) + ", ")), HasSubstr("each id once, got 2 of b again"));
  EXPECT_THAT(
      FaultOfText("cameras:\n" + kCamera + "    mounted_on: roof\n    cam_from_world: " + kPose),
      HasSubstr("mounted_on: expected body or world"));
  EXPECT_THAT(FaultOfText("cameras:\n" + kCamera + "    mounted_on: world\n"),
              HasSubstr("cam_from_world, where the camera stands"));
  EXPECT_THAT(
      FaultOfText("cameras:\n" + kCamera + kStands + "  - name: right\n" +
                  kCamera.substr(kCamera.find("    camera")) + "    cam_from_body: " + kPose),
      HasSubstr("all cameras on the body, or all in the world"));
  EXPECT_THAT(FaultOfText("cameras:\n" + kCamera + "    cam_from_world: " + kPose),
              HasSubstr("expected cam_from_body, or mounted_on: world beside it"));
  EXPECT_THAT(FaultOfText("cam_from_body: " + kPose + "cam_from_world: " + kPose),
              HasSubstr("beside cam_from_body"));
}

}  // namespace
}  // namespace tagtwist::internal::bodies_config_test

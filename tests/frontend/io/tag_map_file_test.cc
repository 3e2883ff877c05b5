#include "frontend/io/setup/tag_map_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <string>

#include "estimator/online/config.h"
#include "frontend/front_end.h"
#include "frontend/io/setup/tag_map_text.h"
#include "frontend/simulation/renderer.h"
#include "frontend/simulation/simulator.h"
#include "frontend/tags/find_tags.h"
#include "tests/support/formats/map_formats.h"
#include "tests/support/formats/spoiled_text.h"
#include "tests/support/test_files.h"

namespace tagtwist::internal::tag_map_file_test {
namespace {

using ::testing::HasSubstr;

Result<TagMap> Read(const std::string& text, std::optional<double> tag_size_m = {},
                    const std::string& family = "") {
  const TempFolder folder;
  WriteText(folder / "x", text);
  return ReadTagMapFile({folder / "x", tag_size_m, family});
}

void ExpectSameMap(const TagMap& a, const TagMap& b) {
  EXPECT_EQ(a.family(), b.family());
  ASSERT_EQ(a.tags().size(), b.tags().size());
  for (const Tag& tag : a.tags()) {
    ASSERT_NE(b.Find(tag.id), nullptr) << tag.id;
    for (size_t c = 0; c < 4; ++c) {
      EXPECT_LT((a.CornersInWorld(tag.id)[c] - b.CornersInWorld(tag.id)[c]).norm(), 1e-12);
    }
  }
}

TEST(TagMapFile, WpilibAndTagSlamGiveTheSameMapAsOurOwn) {
  const auto own = Read(kOwnMap);
  ASSERT_TRUE(own) << own.error().message;
  // The wall's tag: bottom-left as printed is to the left of who looks along +x, at the bottom.
  EXPECT_LT((own->CornersInWorld(4)[0] - Eigen::Vector3d(1, 0.3, 0.2)).norm(), 1e-12);
  const auto wpilib = Read(kWpilibField, 0.2);
  ASSERT_TRUE(wpilib) << wpilib.error().message;
  ExpectSameMap(*wpilib, *own);
  const auto tagslam = Read(kTagSlam);
  ASSERT_TRUE(tagslam) << tagslam.error().message;
  ExpectSameMap(*tagslam, *own);
}

// TagSLAM's board: row by row from the centre of its first tag, and where that is in the body.
TEST(TagMapFile, TagSlamBoardIsItsTags) {
  const auto with = [](const std::string& board) {
    return Read(
        "bodies:\n- sheet:\n    is_static: true\n    pose:\n      position: {x: 1, y: 2, z: "
        "3}\n      rotation: {x: 0, y: 0, z: 1.5707963267948966}\n    board: {" +
        board + "}\n");
  };
  const std::string numbers =
      "tag_start_id: 6, tag_size: 0.2, tag_spacing: 0.5, tag_rows: 2, tag_columns: 3";
  const auto map = with(numbers);
  ASSERT_TRUE(map) << map.error().message;
  ASSERT_EQ(map->tags().size(), 6u);
  EXPECT_LT((map->Find(6)->world_from_tag.translation() - Eigen::Vector3d(1, 2, 3)).norm(), 1e-12);
  EXPECT_LT((map->Find(11)->world_from_tag.translation() - Eigen::Vector3d(0.7, 2.6, 3)).norm(),
            1e-12);
  const auto placed =
      with(numbers + ", pose: {position: {x: 0.1, y: 0, z: 0}, rotation: {x: 0, y: 0, z: 0}}");
  ASSERT_TRUE(placed) << placed.error().message;
  EXPECT_LT((placed->Find(6)->world_from_tag.translation() - Eigen::Vector3d(1, 1.9, 3)).norm(),
            1e-12);
  EXPECT_THAT(with("tag_size: 0.2").error().message, HasSubstr("board.tag_start_id: expected a"));
  for (const auto& [good, bad] : std::vector<std::pair<std::string, std::string>>{
           {"tag_rows: 2", "tag_rows: 0"},
           {"tag_columns: 3", "tag_columns: 99999999"},
           {"tag_size: 0.2", "tag_size: -1"},
           {"tag_start_id: 6", "tag_start_id: 2147483647"}}) {
    EXPECT_FALSE(with(Replaced(numbers, good, bad))) << bad;
  }
}

TEST(TagMapFile, BendLiftsTwoCornersAndIsWrittenWhereThereIsOne) {
  const auto bent = Read(Replaced(kOwnMap, "[0.1, 0.1, 0]}", "[0.1, 0.1, 0], bend_m: -0.0123}"));
  ASSERT_TRUE(bent) << bent.error().message;
  EXPECT_LT((bent->CornersInWorld(1)[0] - Eigen::Vector3d(0, 0, -0.0123)).norm(), 1e-12);
  EXPECT_LT((bent->CornersInWorld(1)[1] - Eigen::Vector3d(0.2, 0, 0.0123)).norm(), 1e-12);
  EXPECT_LT((bent->CornersInWorld(1)[2] - Eigen::Vector3d(0.2, 0.2, -0.0123)).norm(), 1e-12);
  EXPECT_LT((bent->CornersInWorld(1)[3] - Eigen::Vector3d(0, 0.2, 0.0123)).norm(), 1e-12);
  const std::string text = FormatTagMap(*bent);
  EXPECT_EQ(text.find("bend_m"), text.rfind("bend_m")) << text;
  EXPECT_THAT(text, HasSubstr(", bend_m: -0.0123}"));
  const auto read = Read(text);
  ASSERT_TRUE(read) << read.error().message;
  ExpectSameMap(*read, *bent);
}

TEST(TagMapFile, AprilGridRunsFromTheBottomLeft) {
  const auto map = Read(Replaced(kKalibrGrid, "tagRows: 1", "tagRows: 3"));
  ASSERT_TRUE(map) << map.error().message;
  EXPECT_EQ(map->family(), "tag36h11b2");
  ASSERT_EQ(map->tags().size(), 6u);
  EXPECT_LT(map->CornersInWorld(0)[0].norm(), 1e-12);
  EXPECT_LT((map->CornersInWorld(3)[0] - Eigen::Vector3d(0.25, 0.25, 0)).norm(), 1e-12);
  EXPECT_LT((map->CornersInWorld(4)[2] - Eigen::Vector3d(0.2, 0.7, 0)).norm(), 1e-12);
  const auto plain = Read(kKalibrGrid, {}, "tag36h11");
  ASSERT_TRUE(plain);
  EXPECT_EQ(plain->family(), "tag36h11");
}

// A 6 x 6 grid seen by a radtan camera of 752 x 480: tags found, corners fitted.
TEST(TagMapFile, AprilGridIsDetectedAndRefined) {
  const auto map =
      Read("{target_type: aprilgrid, tagCols: 6, tagRows: 6, tagSize: 0.088, tagSpacing: 0.3}");
  ASSERT_TRUE(map) << map.error().message;
  Camera camera;
  camera.width = 752, camera.height = 480, camera.fx = 458.6, camera.fy = 457.3;
  camera.cx = 367.2, camera.cy = 248.4;
  camera.k1 = -0.2834, camera.k2 = 0.0739, camera.p1 = 1.9e-4, camera.p2 = 1.8e-5;
  RendererOptions look;
  look.scene.scribbles_per_m2 = 0;
  const auto renderer = Renderer::Make(camera, *map, look);
  ASSERT_TRUE(renderer) << renderer.error().message;
  const TagDetectorOptions options;
  const auto detector = TagDetector::Create(map->family(), options);
  const auto refiner = CornerRefiner::Create(*map, camera);
  ASSERT_TRUE(detector && refiner);
  size_t visible = 0, found = 0;
  for (int i = 0; i < 4; ++i) {
    const Pose world_from_cam =
        MakePose(Eigen::Quaterniond(Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitX()) *
                                    Eigen::AngleAxisd(0.3 * i - 0.4, Eigen::Vector3d::UnitY())),
                 {0.35 + 0.2 * (0.3 * i - 0.4), 0.35, 0.62 + 0.04 * i});
    const cv::Mat image = renderer->Render({world_from_cam}, 0, static_cast<uint64_t>(i));
    for (const Tag& tag : map->tags()) {
      const auto& corners = map->CornersInWorld(tag.id);
      visible += std::all_of(corners.begin(), corners.end(), [&](const Eigen::Vector3d& corner) {
        Eigen::Vector2d pixel;
        return camera.Project(Inverse(world_from_cam) * corner, &pixel) &&
               camera.Contains(pixel, options.border_px);
      });
    }
    for (const TagDetection& tag : FindTags(image, *detector, *refiner, *map, camera, options)) {
      ++found;
      double worst_px = 0;
      for (size_t c = 0; c < 4; ++c) {
        Eigen::Vector2d truth;
        ASSERT_TRUE(
            camera.Project(Inverse(world_from_cam) * map->CornersInWorld(tag.id)[c], &truth));
        worst_px = std::max(worst_px, (tag.corners[c] - truth).norm());
      }
      EXPECT_LT(worst_px, 0.08) << tag.id;
    }
  }
  EXPECT_EQ(found, visible);
  EXPECT_GE(found, 100u);
}

class BadMapFile : public testing::TestWithParam<BadText> {};

TEST_P(BadMapFile, IsRefusedWithItsPlace) {
  const auto map = Read(Spoiled(GetParam()), 0.2);
  ASSERT_FALSE(map);
  EXPECT_THAT(map.error().message, NamesTheFault(GetParam()));
}

INSTANTIATE_TEST_SUITE_P(
    All, BadMapFile,
    testing::Values(
        BadText{"Checkerboard", kKalibrGrid, "aprilgrid", "checkerboard",
                "x:1: target_type: expected aprilgrid (a board without ids cannot be a map), got "
                "checkerboard"},
        BadText{"NoSpacing", kKalibrGrid, "tagSpacing", "spacing",
                "x:1: tagSpacing: expected a value, got none"},
        BadText{"ZeroSize", kKalibrGrid, "tagSize: 0.2", "tagSize: 0",
                "x:4: tagSize: expected > 0 [m], got 0"},
        BadText{"NegativeColumns", kKalibrGrid, "tagCols: 2", "tagCols: -2",
                "x:2: tagCols: expected >= 1, got -2"},
        BadText{"GridBeyondTheFamily", kKalibrGrid, "tagCols: 2", "tagCols: 600",
                "x: tag 587: expected ids 0..586 of tag36h11b2"},
        BadText{"HugeGrid", kKalibrGrid, "tagRows: 1", "tagRows: 2000000000", "x:3: tagRows: "},
        BadText{"WpilibNoId", kWpilibField, "\"ID\": 4", "\"id\": 4",
                "x:10: tags[1].ID: expected a value, got none"},
        BadText{"WpilibRepeatedId", kWpilibField, "\"ID\": 4", "\"ID\": 1",
                "x: tag 1: listed twice"},
        BadText{"WpilibQuaternion", kWpilibField, "\"Z\": 1.0", "\"Z\": 1.1",
                "x:14: tags[1].pose.rotation.quaternion: expected a unit quaternion, got another"},
        BadText{"WpilibCut", kWpilibField,
                "  \"field\": { \"length\": 16.54175, \"width\": 8.0137 }\n}", "",
                "not valid YAML"},
        BadText{"Overlap", kTagSlam,
                "x: 1.0, y: 0.2, z: 0.3}\n            rotation: {x: 1.2091995761561452, y: "
                "-1.2091995761561452, z: -1.2091995761561452}",
                "x: 0.25, y: 0.2, z: 0}\n            rotation: {x: 0, y: 0, z: 0.5}",
                "x: tags 1 and 4 overlap"},
        BadText{"TagSlamNothingStatic", kTagSlam, "is_static: true", "is_static: false",
                "bodies: expected a static body with tags, got none"},
        BadText{"TagSlamNoRotation", kTagSlam, "rotation: {x: 0, y: 0, z: 0}\n        - id",
                "turn: 0\n        - id", "tags[0].pose.rotation: expected a value, got none"},
        BadText{"Other", "tags: []\n", "tags", "points", "x:1: points: expected one of family"}),
    [](const auto& test) { return std::string(test.param.name); });

TEST(TagMapFile, WpilibNeedsTheTagSize) {
  const auto map = Read(kWpilibField);
  ASSERT_FALSE(map);
  EXPECT_THAT(map.error().message, HasSubstr("x: the size of the tags is not in such a file"));
  EXPECT_FALSE(Read(kWpilibField, -1));
  EXPECT_FALSE(Read(kWpilibField, 0.2, "tag99"));
}

TEST(TagMapFile, IsNamedInAConfigurationBesideIt) {
  const TempFolder folder;
  WriteText(folder / "field.json", kWpilibField);
  WriteText(folder / "config.yaml", "tag_map: {file: field.json, tag_size_m: 0.2}\n");
  const auto config = LoadConfig(folder / "config.yaml");
  ASSERT_TRUE(config) << config.error().message;
  ExpectSameMap(config->set_up.map, *Read(kOwnMap));
  WriteText(folder / "grid.yaml", kKalibrGrid);
  const auto other = LoadConfig({folder / "config.yaml", "", "", {folder / "grid.yaml", {}, ""}});
  ASSERT_TRUE(other) << other.error().message;
  EXPECT_EQ(other->set_up.map.family(), "tag36h11b2");
}

}  // namespace
}  // namespace tagtwist::internal::tag_map_file_test

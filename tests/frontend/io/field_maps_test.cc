// Maps as other programs write them, and those that would be read wrongly.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "frontend/io/setup/tag_map_file.h"
#include "tests/support/temp_folder.h"
#include "tests/support/test_files.h"

namespace tagtwist::internal::field_maps_test {
namespace {

using ::testing::HasSubstr;

class FieldMaps : public ::testing::Test {
 protected:
  Result<TagMap> Read(const std::string& text) {
    const std::string path = folder_.path() + "/map.yaml";
    WriteText(path, text);
    return ReadTagMapFile({path, {}, ""});
  }
  const TempFolder folder_;
};

const std::string kGrid =
    "target_type: 'aprilgrid'\ntagCols: 2\ntagRows: 2\ntagSize: 0.1\ntagSpacing: 0.3\n";

TEST_F(FieldMaps, KalibrsGridMayBeginAtAnotherId) {
  for (const char* key : {"tagStartId", "startId", "low_id"}) {
    const auto map = Read(kGrid + key + ": 36\n");
    ASSERT_TRUE(map) << map.error().message;
    EXPECT_EQ(map->tags().front().id, 36) << key;
  }
}

TEST_F(FieldMaps, KalibrsBorderDecidesOnTheFamily) {
  EXPECT_EQ(Read(kGrid)->family(), "tag36h11b2");
  EXPECT_EQ(Read(kGrid + "borderBits: 1\n")->family(), "tag36h11");
}

TEST_F(FieldMaps, LimelightsFieldIsReadInMillimetres) {
  const auto map = Read(
      "{\"fiducials\":[{\"family\":\"apriltag3_36h11_classic\",\"id\":1,\"size\":165.1,"
      "\"transform\":[1,0,0,6.8, 0,1,0,-3.86, 0,0,1,1.355, 0,0,0,1]}],\"type\":\"frc\"}");
  ASSERT_TRUE(map) << map.error().message;
  const Tag& tag = map->tags().front();
  EXPECT_NEAR(tag.size_m, 0.1651, 1e-12);
  EXPECT_EQ(Eigen::Vector3d(tag.world_from_tag.translation()), Eigen::Vector3d(6.8, -3.86, 1.355));
  // Out of its face is the field's x, up as printed its z.
  EXPECT_TRUE((tag.world_from_tag.rotation() * Eigen::Vector3d::UnitZ())
                  .isApprox(Eigen::Vector3d::UnitX(), 1e-9));
  EXPECT_TRUE((tag.world_from_tag.rotation() * Eigen::Vector3d::UnitY())
                  .isApprox(Eigen::Vector3d::UnitZ(), 1e-9));
}

TEST_F(FieldMaps, TheOnlyBundleOfApriltagRosIsRead) {
  const std::string layout =
      "layout: [{id: 3, size: 0.1, x: 0.5, y: 0.2, z: 0, qw: 1, qx: 0, qy: 0, qz: 0}]";
  const auto map = Read("tag_bundles: [{name: a, " + layout + "}]\n");
  ASSERT_TRUE(map) << map.error().message;
  EXPECT_EQ(map->tags().front().id, 3);
  const auto two = Read("tag_bundles: [{name: a, " + layout + "}, {name: b, " + layout + "}]\n");
  ASSERT_FALSE(two);
  EXPECT_THAT(two.error().message, HasSubstr("one bundle"));
}

TEST_F(FieldMaps, TagSlamsBodiesAndBoardsWithoutAPoseAreRefused) {
  const std::string tags =
      "tags: [{id: 1, size: 0.1, pose: {position: {x: 0, y: 0, z: 0}, rotation: {x: 0, y: 0, z: "
      "0}}}]";
  const auto body = Read("bodies:\n - wall: {is_static: true, " + tags + "}\n");
  ASSERT_FALSE(body);
  EXPECT_THAT(body.error().message, HasSubstr("TagSLAM would estimate it"));
  const auto board = Read("bodies:\n - b: {is_static: true, board: {tag_start_id: 6}}\n");
  ASSERT_FALSE(board);
  EXPECT_THAT(board.error().message, HasSubstr("TagSLAM would estimate it"));
}

// The season's table: inches, and the last column a turn about the tag's own y axis.
TEST_F(FieldMaps, WpilibsTableIsReadInInches) {
  const std::string path = folder_.path() + "/field.csv";
  WriteText(path, "ID,X,Y,Z,Z-Rotation,X-Rotation\n1,657.37,25.8,58.5,126,0\n4,100,50,10,0,30\n");
  const auto map = ReadTagMapFile({path, 0.1651, ""});
  ASSERT_TRUE(map) << map.error().message;
  const Tag &first = map->tags()[0], &tilted = map->tags()[1];
  EXPECT_NEAR(first.world_from_tag.translation().x(), 657.37 * 0.0254, 1e-12);
  EXPECT_EQ(tilted.size_m, 0.1651);
  const Eigen::Vector3d out = first.world_from_tag.rotation() * Eigen::Vector3d::UnitZ();
  EXPECT_NEAR(std::atan2(out.y(), out.x()), 126 * M_PI / 180, 1e-12);
  const Eigen::Vector3d down = tilted.world_from_tag.rotation() * Eigen::Vector3d::UnitZ();
  EXPECT_TRUE(down.isApprox(Eigen::Vector3d(std::sqrt(0.75), 0, -0.5), 1e-12)) << down.transpose();
  EXPECT_THAT(ReadTagMapFile({path, {}, ""}).error().message, HasSubstr("--tag_size_m"));
  WriteText(path, "ID,X,Y,Z,Z-Rotation,X-Rotation\n1,657.37,25.8,58.5,126\n");
  EXPECT_THAT(ReadTagMapFile({path, 0.1651, ""}).error().message, HasSubstr("field.csv:2"));
  WriteText(path, "ID,X,Y,Z,Rotation\n1,2,3,4,5\n");
  EXPECT_THAT(ReadTagMapFile({path, 0.1651, ""}).error().message, HasSubstr("5 columns"));
}

}  // namespace
}  // namespace tagtwist::internal::field_maps_test

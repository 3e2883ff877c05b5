// tagtwist_map as it is run: what it says of a map, what it draws, what it refuses.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>
#include <sstream>

#include "frontend/io/setup/tag_map_file.h"
#include "frontend/tags/tag_detector.h"
#include "tests/support/formats/map_formats.h"
#include "tests/support/program_test_util.h"
#include "tests/support/test_files.h"

namespace tagtwist::internal::map_program_test {
namespace {

using ::testing::HasSubstr;

// Draws the groups of an SVG: the black runs "Mc r h n v1Hcz" under the group's matrix.
cv::Mat Rasterise(const std::string& svg, double px_per_mm, int width, int height) {
  cv::Mat image(height, width, CV_8UC1, cv::Scalar(255));
  size_t at = 0;
  while ((at = svg.find("matrix(", at)) != std::string::npos) {
    double m[6];
    std::istringstream(svg.substr(at + 7)) >> m[0] >> m[1] >> m[2] >> m[3] >> m[4] >> m[5];
    size_t path = svg.find("path d=\"", at) + 8;
    const size_t end = svg.find('"', path);
    for (; path < end; path = svg.find('z', path) + 1) {
      int column = 0, row = 0, run = 0;
      EXPECT_EQ(std::sscanf(svg.c_str() + path, "M%d %dh%d", &column, &row, &run), 3);
      std::vector<cv::Point> quad;
      for (const auto& [u, v] : {std::pair(column, row), std::pair(column + run, row),
                                 std::pair(column + run, row + 1), std::pair(column, row + 1)}) {
        quad.emplace_back(cvRound(px_per_mm * (m[0] * u + m[2] * v + m[4])),
                          cvRound(px_per_mm * (m[1] * u + m[3] * v + m[5])));
      }
      cv::fillConvexPoly(image, quad, cv::Scalar(0));
    }
    at = end;
  }
  return image;
}

class MapProgram : public testing::Test {
 protected:
  ProgramRun Run(const std::vector<std::string>& arguments) {
    return RunProgram(folder_.path(), "tagtwist_map", arguments);
  }
  TempFolder folder_;
};

TEST_F(MapProgram, DescribesAMap) {
  WriteText(folder_ / "grid.yaml", kKalibrGrid);
  const ProgramRun run = Run({"--check", "grid.yaml"});
  EXPECT_EQ(run.status, 0) << run.err;
  EXPECT_EQ(run.out,
            "grid.yaml: 2 tags of tag36h11b2, ids 0 to 1, 200 mm, on 1 plane, 0.45 x 0.20 x 0.00 "
            "m\n");
  EXPECT_EQ(Run({"--check", std::string(TAGTWIST_SOURCE_DIR) + "/configs/course.yaml"}).status, 0);
}

TEST_F(MapProgram, RefusesInOneLine) {
  WriteText(folder_ / "grid.yaml", std::string(kKalibrGrid) + "tagCols: 3\n");
  const ProgramRun repeated = Run({"--check", "grid.yaml", "--render", "map.svg"});
  EXPECT_EQ(repeated.status, 1);
  EXPECT_TRUE(IsOneLine(repeated.err)) << repeated.err;
  EXPECT_THAT(repeated.err, HasSubstr("grid.yaml:6: tagCols: expected the key once"));
  EXPECT_EQ(Run({"--check", "nothing.yaml"}).status, 1);
  EXPECT_EQ(Run({}).status, 2);
  EXPECT_EQ(Run({"--map", "grid.yaml"}).status, 2);
  EXPECT_EQ(ListTree(folder_.path()), std::vector<std::string>{"grid.yaml"});
}

// What is drawn is detected where the map has it.
TEST_F(MapProgram, DrawsTagsInTrueSize) {
  WriteText(folder_ / "map.yaml",
            "tags:\n  - {id: 3, size_m: 0.08, position_m: [0, 0, 0]}\n"
            "  - {id: 5, size_m: 0.08, position_m: [0.2, 0.05, 0], yaw_rad: 0.3}\n");
  const ProgramRun run = Run({"--map", "map.yaml", "--render", "map.svg"});
  ASSERT_EQ(run.status, 0) << run.err;
  const std::string svg = ReadText(folder_ / "map.svg");
  EXPECT_THAT(svg, HasSubstr("mm\" height=\""));
  constexpr double kPxPerMm = 3;
  const cv::Mat image = Rasterise(svg, kPxPerMm, 1200, 700);
  const auto detector = TagDetector::Create("tag36h11", {});
  ASSERT_TRUE(detector);
  const auto tags = detector->Detect(image);
  ASSERT_EQ(tags.size(), 2u);
  EXPECT_EQ(tags[0].id, 3);
  EXPECT_EQ(tags[1].id, 5);
  const auto centre = [](const TagDetection& tag) {
    return Eigen::Vector2d((tag.corners[0] + tag.corners[1] + tag.corners[2] + tag.corners[3]) / 4);
  };
  const Eigen::Vector2d apart = (centre(tags[1]) - centre(tags[0])) / kPxPerMm;
  EXPECT_LT((apart - Eigen::Vector2d(200, -50)).norm(), 0.5) << apart.transpose();
  EXPECT_NEAR((tags[0].corners[1] - tags[0].corners[0]).norm() / kPxPerMm, 80, 0.7);
  const Eigen::Vector2d bottom = tags[1].corners[1] - tags[1].corners[0];
  EXPECT_NEAR(std::atan2(-bottom.y(), bottom.x()), 0.3, 0.02);
}

TEST_F(MapProgram, MakesAMapFromARecording) {
  MakeRecording(folder_.path(), "flight", DatasetFormat::kFolder, false);
  const ProgramRun run = Run(
      {"--from", "flight", "--use_detections", "--tag_size_m", "0.152", "--output", "made.yaml"});
  ASSERT_EQ(run.status, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("9 tags mapped, 3 seen and not placed"));
  const auto made = ReadTagMapFile({folder_ / "made.yaml", {}, ""});
  ASSERT_TRUE(made) << made.error().message;
  const TagMap mat = MakeTagMap(TagGrid());
  ASSERT_GE(made->tags().size(), 4u);
  const auto apart = [](const TagMap& map, int a, int b) {
    return (map.Find(a)->world_from_tag.translation() - map.Find(b)->world_from_tag.translation())
        .norm();
  };
  const int first = made->tags()[0].id;
  for (const Tag& tag : made->tags()) {
    EXPECT_NEAR(apart(*made, first, tag.id), apart(mat, first, tag.id), 0.01) << "tag " << tag.id;
  }
}

TEST_F(MapProgram, RefusesToMakeAMapFromNothing) {
  EXPECT_EQ(Run({"--from", "flight"}).status, 2);
  EXPECT_EQ(Run({"--from", "flight", "--tag_size_m", "0.1"}).status, 2);
  const ProgramRun run = Run({"--from", "no", "--tag_size_m", "0.1", "--output", "made.yaml"});
  EXPECT_EQ(run.status, 1);
  EXPECT_TRUE(IsOneLine(run.err)) << run.err;
  EXPECT_TRUE(ListTree(folder_.path()).empty());
}

TEST_F(MapProgram, EveryPlaneIsASheetOfItsOwn) {
  WriteText(folder_ / "map.yaml", kOwnMap);
  const ProgramRun run = Run({"--check", "map.yaml", "--render", "map.svg"});
  ASSERT_EQ(run.status, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("on 2 planes"));
  const auto tags = TagDetector::Create("tag36h11", {})
                        ->Detect(Rasterise(ReadText(folder_ / "map.svg"), 2, 1200, 700));
  ASSERT_EQ(tags.size(), 2u);
  EXPECT_EQ(tags[1].id, 4);
}

}  // namespace
}  // namespace tagtwist::internal::map_program_test

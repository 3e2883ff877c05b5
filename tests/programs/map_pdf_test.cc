// Maps as PDF pages: turned into images at 300 dots an inch, their tags lie where the map has them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <opencv2/imgcodecs.hpp>

#include "frontend/io/setup/tag_map_file.h"
#include "frontend/tags/tag_detector.h"
#include "tests/support/program_test_util.h"
#include "tests/support/test_files.h"

namespace tagtwist::internal::map_pdf_test {
namespace {

using ::testing::HasSubstr;

constexpr double kPxPerMm = 300 / 25.4;

class MapPdf : public testing::Test {
 protected:
  void SetUp() override {
    if (std::system("command -v pdftoppm >/dev/null") != 0) {
      GTEST_SKIP() << "pdftoppm is not installed";
    }
  }

  // The pages of a map's PDF as images.
  std::vector<cv::Mat> Pages(const std::string& map, const std::vector<std::string>& more) {
    WriteText(folder_ / "map.yaml", map);
    std::vector<std::string> arguments = {"--map", "map.yaml", "--render", "map.pdf"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const ProgramRun run = RunProgram(folder_.path(), "tagtwist_map", arguments);
    EXPECT_EQ(run.status, 0) << run.err;
    const std::string command = "cd '" + folder_.path() +
                                "' && rm -f page-*.png && pdftoppm -r 300 -gray -png map.pdf page";
    EXPECT_EQ(std::system(command.c_str()), 0);
    std::vector<cv::Mat> out;
    for (const std::string& name : ListTree(folder_.path())) {
      if (name.find("page-") == std::string::npos) continue;
      out.push_back(cv::imread(folder_ / name, cv::IMREAD_GRAYSCALE));
    }
    return out;
  }

  // Lays the page's tags over the map's by a turn and a shift in the plane, no scale; counts them.
  void ExpectInPlace(const cv::Mat& page, const TagMap& map, std::map<int, int>* seen) {
    const auto tags = TagDetector::Create(map.family(), {})->Detect(page);
    Eigen::Matrix2Xd on_page(2, 4 * tags.size()), in_map(2, 4 * tags.size());
    Eigen::Index n = 0;
    for (const TagDetection& tag : tags) {
      ASSERT_NE(map.Find(tag.id), nullptr) << tag.id;
      ++(*seen)[tag.id];
      const auto& corners = map.CornersInWorld(tag.id);
      for (size_t i = 0; i < 4; ++i, ++n) {
        on_page.col(n) << tag.corners[i].x() / kPxPerMm, -tag.corners[i].y() / kPxPerMm;
        in_map.col(n) = 1000 * corners[i].head<2>();
      }
    }
    if (n == 0) return;
    const Eigen::Vector2d page_centre = on_page.rowwise().mean();
    const Eigen::Vector2d map_centre = in_map.rowwise().mean();
    on_page.colwise() -= page_centre;
    in_map.colwise() -= map_centre;
    const double dot = in_map.cwiseProduct(on_page).sum();
    const double cross =
        (in_map.row(0).cwiseProduct(on_page.row(1)) - in_map.row(1).cwiseProduct(on_page.row(0)))
            .sum();
    const double turn = std::atan2(cross, dot);
    const Eigen::Matrix2Xd off = Eigen::Rotation2Dd(turn).toRotationMatrix() * in_map - on_page;
    EXPECT_LT(off.colwise().norm().maxCoeff(), 0.1) << "mm";
    EXPECT_NEAR(turn, 0, 1e-3) << "pages stand upright";
  }

  const TempFolder folder_;
};

const std::string kGrid =
    "family: tag36h11\ngrid: {rows: 4, columns: 3, tag_size_m: 0.08, row_gaps_m: 0.024, "
    "column_gaps_m: 0.03}\n";

TEST_F(MapPdf, TagsAreWhereTheMapHasThemOnEveryPaper) {
  for (const auto& [paper, width_mm, height_mm] :
       {std::tuple("a4", 210.0, 297.0), std::tuple("letter", 215.9, 279.4)}) {
    const auto pages = Pages(kGrid, {"--paper", paper});
    ASSERT_GT(pages.size(), 1u);
    const auto map = ReadTagMapFile({folder_ / "map.yaml", {}, ""});
    ASSERT_TRUE(map) << map.error().message;
    std::map<int, int> seen;
    for (const cv::Mat& page : pages) {
      EXPECT_NEAR(page.cols, width_mm * kPxPerMm, 1.5) << paper;
      EXPECT_NEAR(page.rows, height_mm * kPxPerMm, 1.5) << paper;
      ExpectInPlace(page, *map, &seen);
    }
    EXPECT_EQ(seen.size(), map->tags().size()) << "no tag is cut by a page's end";
    for (const auto& [id, count] : seen) EXPECT_EQ(count, 1) << id;
  }
}

// 2 m from tag to tag: pages of white paper help no one.
TEST_F(MapPdf, ALargeFieldHasAPageATag) {
  const auto pages = Pages(
      "tags:\n  - {id: 3, size_m: 0.1, position_m: [0, 0, 0], yaw_rad: 0.3}\n"
      "  - {id: 5, size_m: 0.1, position_m: [2, 1.5, 0]}\n"
      "  - {id: 6, size_m: 0.1, position_m: [4, 0, 0]}\n",
      {});
  EXPECT_EQ(pages.size(), 3u);
  const auto map = ReadTagMapFile({folder_ / "map.yaml", {}, ""});
  std::map<int, int> seen;
  for (const cv::Mat& page : pages) ExpectInPlace(page, *map, &seen);
  EXPECT_EQ(seen.size(), 3u);
}

TEST_F(MapPdf, SlowTheSameMapGivesTheSameBytes) {
  Pages(kGrid, {});
  const std::string first = ReadText(folder_ / "map.pdf");
  Pages(kGrid, {});
  EXPECT_EQ(ReadText(folder_ / "map.pdf"), first);
  const ProgramRun wrong = RunProgram(folder_.path(), "tagtwist_map",
                                      {"--map", "map.yaml", "--render", "x.pdf", "--paper", "a3"});
  EXPECT_EQ(wrong.status, 2);
  EXPECT_THAT(wrong.err, HasSubstr("--paper: expected a4 or letter, got a3"));
}

}  // namespace
}  // namespace tagtwist::internal::map_pdf_test

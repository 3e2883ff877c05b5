#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <iomanip>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgcodecs.hpp>
#include <sstream>

#include "frontend/front_end.h"
#include "frontend/pattern/corner_refiner.h"
#include "frontend/tags/find_tags.h"
#include "frontend/tags/tag_detector.h"

namespace tagtwist::internal::real_data_corners_test {
namespace {

using Corners = std::array<Eigen::Vector2d, 4>;

const std::filesystem::path kFloorMat =
    std::filesystem::path(TAGTWIST_REAL_DATA_DIR) / "umd-floor-mat";

// How far the corners lie from the best view of a square [px], coordinate by coordinate.
void AddSquareResiduals(const Camera& camera, const Corners& corners, std::vector<double>* out) {
  const std::vector<cv::Point3d> square = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
  std::vector<cv::Point2d> pixels;
  for (const auto& corner : corners) pixels.emplace_back(corner.x(), corner.y());
  const cv::Mat k =
      (cv::Mat_<double>(3, 3) << camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1);
  std::vector<cv::Mat> turns, places;
  cv::solvePnPGeneric(square, pixels, k, {}, turns, places, false, cv::SOLVEPNP_IPPE);
  double best = 1e9;
  std::vector<cv::Point2d> nearest;
  for (size_t i = 0; i < turns.size(); ++i) {
    cv::solvePnPRefineLM(square, pixels, k, {}, turns[i], places[i]);
    std::vector<cv::Point2d> projected;
    cv::projectPoints(square, turns[i], places[i], k, {}, projected);
    double sum = 0;
    for (size_t c = 0; c < 4; ++c) sum += cv::norm(projected[c] - pixels[c]);
    if (!(sum < best)) continue;
    best = sum;
    nearest = projected;
  }
  for (size_t c = 0; c < nearest.size(); ++c) {
    out->push_back(std::abs(nearest[c].x - pixels[c].x));
    out->push_back(std::abs(nearest[c].y - pixels[c].y));
  }
}

double Median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
  return values[values.size() / 2];
}

TEST(RealDataCornerRefiner, TagsOfTheFloorMatAreMoreNearlySquare) {
  if (!std::filesystem::exists(kFloorMat)) GTEST_SKIP() << "no real data at " << kFloorMat;
  Camera camera;
  camera.width = camera.height = 576;
  camera.fx = 364.06504946;
  camera.fy = 363.91295096;
  camera.cx = 289.08170258;
  camera.cy = 290.63061762;
  std::vector<Tag> tags;
  for (int id = 0; id < 120; ++id) tags.push_back({id, Pose(), 0.193});
  const TagMap map("tag36h11", tags);
  const auto refiner = CornerRefiner::Create(map, camera);
  ASSERT_TRUE(refiner);
  TagDetectorOptions options;
  options.upscale = 1;
  options.decimate = 1;
  const auto detector = TagDetector::Create("tag36h11", options);
  std::vector<double> plain, refined;
  size_t refused = 0;
  for (int i = 1; i <= 450; i += 18) {
    std::ostringstream name;
    name << std::setw(4) << std::setfill('0') << i << ".jpg";
    const cv::Mat image =
        cv::imread((kFloorMat / "images" / name.str()).string(), cv::IMREAD_GRAYSCALE);
    ASSERT_FALSE(image.empty()) << name.str();
    for (const TagDetection& tag : FilterTags(detector->Detect(image), map, camera, 1.5)) {
      const auto better = refiner->Refine(image, tag);
      if (!better) {
        ++refused;
        continue;
      }
      AddSquareResiduals(camera, tag.corners, &plain);
      AddSquareResiduals(camera, better->corners, &refined);
    }
  }
  RecordProperty("plain_px", std::to_string(2 * 1.4826 * Median(plain)));
  RecordProperty("refined_px", std::to_string(2 * 1.4826 * Median(refined)));
  EXPECT_GT(refined.size(), 8 * 500U);
  EXPECT_LT(refused, refined.size() / 8 / 20);
  EXPECT_LT(Median(refined), 0.85 * Median(plain));
}

}  // namespace
}  // namespace tagtwist::internal::real_data_corners_test

#include "frontend/simulation/renderer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <thread>

#include "frontend/base/statistics/random_stream.h"
#include "frontend/types/so3.h"
#include "tests/support/edge_fit.h"

namespace tagtwist::internal::renderer_test {
namespace {

using ::testing::HasSubstr;

// No noise, no shading, no scribble.
RendererOptions Plain(double blur_px = 0, int supersampling = 4) {
  RendererOptions out;
  out.blur_px = blur_px;
  out.supersampling = supersampling;
  out.vignetting = out.gradient = out.noise_grey = 0;
  out.scene.scribbles_per_m2 = 0;
  return out;
}

Renderer MustMake(const Camera& camera, const TagMap& map, const RendererOptions& options) {
  auto made = Renderer::Make(camera, map, options);
  EXPECT_TRUE(made) << made.error().message;
  return *made;
}

Camera DistortedCamera() {
  Camera out;
  out.k1 = -0.28;
  out.k2 = 0.08;
  out.p1 = 1e-3;
  out.p2 = -5e-4;
  return out;
}

// A camera above (x, y) that looks down, turned and tilted.
Pose Above(double x, double y, double height, const Eigen::Vector3d& turn = {0, 0, 0}) {
  const Eigen::Quaterniond down(0, 1, 0, 0);
  return MakePose(down * ExpSo3(turn), {x, y, height});
}

TagMap OneTag(double size_m = 0.2) {
  return TagMap("tag36h11", {{5, MakePose(Eigen::Quaterniond::Identity(), {0, 0, 0}), size_m}});
}

cv::Mat Render(const Renderer& renderer, const Pose& world_from_cam, uint64_t index = 0) {
  return renderer.Render({world_from_cam}, 0.0, index);
}

struct ExactnessCase {
  const char* name;
  double blur_px;
  int supersampling;
  bool distorted;
};
std::ostream& operator<<(std::ostream& out, const ExactnessCase& c) { return out << c.name; }
class RendererExactness : public ::testing::TestWithParam<ExactnessCase> {};

TEST_P(RendererExactness, EdgesLieWhereTheyProjectTo) {
  const ExactnessCase& c = GetParam();
  const Camera camera = c.distorted ? DistortedCamera() : Camera();
  const TagMap map = OneTag();
  const Renderer renderer = MustMake(camera, map, Plain(c.blur_px, c.supersampling));
  RandomStream random(3);
  double worst = 0;
  for (int i = 0; i < 12; ++i) {
    Eigen::Vector3d turn(0, 0, 0);  // the first ones see the sides along rows and columns
    if (i >= 4) turn << random.Uniform(-0.4, 0.4), random.Uniform(-0.4, 0.4), random.Uniform(-3, 3);
    const double height = random.Uniform(0.5, 0.7);
    const double y = random.Uniform(-0.05, 0.05), x = random.Uniform(-0.05, 0.05);
    const Pose world_from_cam = Above(x, y, height, turn);
    const cv::Mat image = Render(renderer, world_from_cam);
    for (size_t side = 0; side < 4; ++side) {
      const double bias =
          EdgeBias(image, camera, Inverse(world_from_cam), map.CornersInWorld(5), side);
      if (!std::isfinite(bias)) continue;  // out of the image
      EXPECT_LT(std::abs(bias), 0.01) << "view " << i << " side " << side;
      worst = std::max(worst, std::abs(bias));
    }
  }
  RecordProperty("worst_px", std::to_string(worst));
  EXPECT_GT(worst, 0);
}

INSTANTIATE_TEST_SUITE_P(All, RendererExactness,
                         ::testing::Values(ExactnessCase{"Sharp", 0, 4, false},
                                           ExactnessCase{"Coarse", 0, 2, false},
                                           ExactnessCase{"Blurred", 0.5, 4, false},
                                           ExactnessCase{"Distorted", 0.5, 4, true}),
                         [](const auto& test) { return test.param.name; });

TEST(Renderer, BytesDependOnSeedAndFrameAlone) {
  RendererOptions options;
  options.scene.occluders = 3;
  const TagMap map = MakeTagMap({});
  const Renderer a = MustMake({}, map, options), b = MustMake({}, map, options);
  options.scene.random_seed = 2;
  const Renderer other = MustMake({}, map, options);
  const Pose pose = Above(1.5, 1.2, 1.2, {0.1, 0.1, 0.3});
  const cv::Mat image = Render(a, pose, 7);
  EXPECT_EQ(cv::norm(image, Render(b, pose, 7), cv::NORM_INF), 0);
  EXPECT_GT(cv::norm(image, Render(a, pose, 8), cv::NORM_INF), 0);
  EXPECT_GT(cv::norm(image, Render(other, pose, 7), cv::NORM_INF), 0);
  std::vector<cv::Mat> threaded(4);
  std::vector<std::thread> threads;
  for (cv::Mat& out : threaded) threads.emplace_back([&] { out = Render(a, pose, 7); });
  for (std::thread& thread : threads) thread.join();
  for (const cv::Mat& out : threaded) EXPECT_EQ(cv::norm(image, out, cv::NORM_INF), 0);
}

TEST(Renderer, NoiseHasItsSigmaAndNoBias) {
  RendererOptions options = Plain();
  options.noise_grey = 3;
  options.scene.floor_grey = 120.3;
  const Renderer renderer = MustMake({}, OneTag(), options);
  const cv::Mat first = Render(renderer, Above(50, 50, 1), 0);
  const cv::Mat second = Render(renderer, Above(50, 50, 1), 1);
  cv::Scalar mean, deviation;
  cv::meanStdDev(first, mean, deviation);
  EXPECT_NEAR(mean[0], 120.3, 5 * 3 / 300.0);
  EXPECT_NEAR(deviation[0], std::sqrt(9 + 1.0 / 12), 0.05);
  cv::Mat a, b;
  first.convertTo(a, CV_64F, 1, -mean[0]);
  second.convertTo(b, CV_64F, 1, -mean[0]);
  EXPECT_LT(std::abs(a.dot(b)) / (9.0 * static_cast<double>(a.total())), 0.02);  // independent
}

TEST(Renderer, DefocusHasItsWidth) {
  for (const double sigma : {0.0, 0.5, 1.0, 2.0}) {
    TagMap map = OneTag(0.6);
    const Renderer renderer = MustMake({}, map, Plain(sigma));
    const cv::Mat image = Render(renderer, Above(0.30, 0.01, 0.5));  // its right side, amid
    double sum = 0, mean = 0, square = 0;
    for (int u = 190; u < 214; ++u) {
      const double step =
          static_cast<double>(image.at<uint8_t>(120, u + 1)) - image.at<uint8_t>(120, u);
      sum += step;
      mean += step * u;
      square += step * u * u;
    }
    ASSERT_NEAR(sum, 200, 2);
    mean /= sum;
    // Twice a pixel's own square: once in the camera, once in the difference of two pixels. Without
    // blur the edge's place within its pixel counts, too.
    const double variance = square / sum - mean * mean, expected = sigma * sigma + 1.0 / 6;
    EXPECT_NEAR(variance, expected, sigma > 0 ? 0.02 * expected : 0.17) << sigma;
  }
}

TEST(Renderer, ShadingIsOfTheGivenStrength) {
  RendererOptions options = Plain();
  options.scene.floor_grey = 200;
  options.vignetting = 0.4;
  cv::Mat image = Render(MustMake({}, OneTag(), options), Above(50, 50, 1));
  EXPECT_NEAR(image.at<uint8_t>(0, 0), 120, 1);
  EXPECT_NEAR(image.at<uint8_t>(120, 188), 200, 1);
  options.vignetting = 0;
  options.gradient = 0.2;
  options.gradient_direction_rad = M_PI / 2;
  image = Render(MustMake({}, OneTag(), options), Above(50, 50, 1));
  EXPECT_NEAR(image.at<uint8_t>(0, 100), 180, 1);
  EXPECT_NEAR(image.at<uint8_t>(239, 300), 220, 1);
}

// Of the papers' pixels that the camera sees, those where the images differ.
int DifferencesOnPapers(const std::vector<Patch>& papers, const Pose& world_from_cam,
                        const cv::Mat& a, const cv::Mat& b) {
  int out = 0;
  for (const Patch& paper : papers) {
    // Nearest pixel; it must lie on the paper itself, so stay half a pixel inside.
    for (double u = -0.95; u <= 0.95; u += 0.05) {
      for (double v = -0.95; v <= 0.95; v += 0.05) {
        Eigen::Vector2d pixel;
        const Eigen::Vector3d point = paper.centre + u * paper.half_u + v * paper.half_v;
        if (!Camera().Project(Inverse(world_from_cam) * point, &pixel)) continue;
        if (!Camera().Contains(pixel, 1)) continue;
        const cv::Point at(static_cast<int>(std::lround(pixel.x())),
                           static_cast<int>(std::lround(pixel.y())));
        out += a.at<uint8_t>(at) != b.at<uint8_t>(at);
      }
    }
  }
  return out;
}

// Of the drawn patches' centres; what is drawn lies in the plane of the papers.
int CentresOnPapers(const std::vector<Patch>& drawn, const std::vector<Patch>& papers) {
  int out = 0;
  for (const Patch& patch : drawn) {
    for (const Patch& paper : papers) {
      const Eigen::Vector3d offset = patch.centre - paper.centre;
      EXPECT_NEAR(offset.dot(paper.half_u.cross(paper.half_v)), 0, 1e-9);
      out += std::abs(offset.dot(paper.half_u)) < paper.half_u.squaredNorm() &&
             std::abs(offset.dot(paper.half_v)) < paper.half_v.squaredNorm();
    }
  }
  return out;
}

// On the floor, and on a wall where there is no floor.
TEST(Renderer, ScribbleStaysOffThePapers) {
  TagGrid grid;
  grid.rows = grid.columns = 3;
  grid.row_gaps_m = grid.column_gaps_m = {0.152, 0.152};
  for (const bool on_wall : {false, true}) {
    RendererOptions options = Plain();
    options.scene.floor = !on_wall;
    options.scene.walls = on_wall;
    const Pose world_from_mat = on_wall ? MakePose(ExpSo3({1.5, 0.2, 0}), {1, 2, 1}) : Pose();
    std::vector<Tag> tags = MakeTagMap(grid).tags();
    for (Tag& tag : tags) tag.world_from_tag = world_from_mat * tag.world_from_tag;
    const TagMap map("tag36h11", tags);
    options.scene.scribbles_per_m2 = 400;
    const Renderer with = MustMake({}, map, options);
    options.scene.scribbles_per_m2 = 0;
    const Renderer without = MustMake({}, map, options);
    const Pose pose = world_from_mat * Above(0.35, 0.35, 0.8, {0.2, 0.1, 0.5});
    const cv::Mat scribbled = Render(with, pose), clean = Render(without, pose);
    EXPECT_GT(cv::countNonZero(scribbled != clean), 1000);
    const Scene& scene = with.scene();
    const auto& drawn = on_wall ? scene.walls().front().scribbles : scene.scribbles();
    EXPECT_GT(drawn.size(), 300u);
    EXPECT_EQ(CentresOnPapers(drawn, scene.tags()), 0);
    EXPECT_EQ(DifferencesOnPapers(with.scene().tags(), pose, scribbled, clean), 0);
  }
}

TEST(Renderer, MotionBlurIsTheMeanOverTheExposure) {
  const TagMap map = OneTag();
  const Renderer renderer = MustMake({}, map, Plain());
  std::vector<Pose> poses;  // 3 px of motion along x
  for (int i = 0; i < 12; ++i) poses.push_back(Above(0.006 * ((i + 0.5) / 12 - 0.5), 0, 0.6));
  const cv::Mat image = renderer.Render(poses, 0, 0);
  const Pose middle = Inverse(Above(0, 0, 0.6));
  for (size_t side = 0; side < 4; ++side) {
    EXPECT_NEAR(EdgeBias(image, {}, middle, map.CornersInWorld(5), side), 0, 0.01);
  }
  EXPECT_GT(cv::norm(image, Render(renderer, Above(0, 0, 0.6)), cv::NORM_INF), 50);
}

TEST(Renderer, RefusesBadOptions) {
  const auto message = [](const RendererOptions& options, const TagMap& map = OneTag()) {
    const auto made = Renderer::Make({}, map, options);
    return made ? "" : made.error().message;
  };
  RendererOptions options;
  options.noise_grey = NAN;
  EXPECT_THAT(message(options), HasSubstr("noise_grey: expected in [0, 255]"));
  options = {};
  options.supersampling = 0;
  EXPECT_THAT(message(options), HasSubstr("supersampling"));
  options = {};
  options.scene.occluder_radius_m = 0;
  EXPECT_THAT(message(options), HasSubstr("occluder_radius_m"));
  const Tag tag{587, Pose(), 0.1};
  EXPECT_THAT(message({}, TagMap("tag36h11", {tag})),
              HasSubstr("tag 587: tag36h11 has ids 0..586"));
  EXPECT_THAT(message({}, TagMap("tag1", {tag})), HasSubstr("expected one of tag36h11, "));
}

}  // namespace
}  // namespace tagtwist::internal::renderer_test

#include "frontend/pattern/corner_refiner.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "frontend/front_end.h"
#include "frontend/pattern/pattern_state.h"
#include "frontend/tags/find_tags.h"
#include "tests/support/flights/corner_flight.h"

namespace tagtwist::internal::corner_refiner_test {
namespace {

Corners TrueCorners(const SimulatedFrame& frame, const Camera& camera, int id) {
  Corners out;
  const Pose cam_from_world = CourseCamFromBody() * Inverse(frame.truth.world_from_body);
  const TagMap map = MakeTagMap(TagGrid());
  for (size_t c = 0; c < 4; ++c) {
    EXPECT_TRUE(camera.Project(cam_from_world * map.CornersInWorld(id)[c], &out[c]));
  }
  return out;
}

// libapriltag's corners on the image as it is.
std::vector<TagDetection> DetectPlainly(const cv::Mat& image, const Camera& camera) {
  TagDetectorOptions options;
  options.upscale = 1;
  options.decimate = 1;
  return FilterTags(TagDetector::Create("tag36h11", options)->Detect(image), MakeTagMap(TagGrid()),
                    camera, 2);
}

struct Score {
  double plain_px = 0, refined_px = 0;  // root mean squares of a coordinate
  double nees = 0, corner_nees = 0;     // per degree of freedom
  Eigen::Vector2d bias_px = Eigen::Vector2d::Zero();
  int tags = 0, refused = 0;
};

Score Measure(const Setting& setting, int frames) {
  const Flight flight = MakeFlightOf(setting);
  const CornerRefiner refiner = MakeRefiner(setting.camera);
  Score out;
  for (int i = 0; i < frames; ++i) {
    SimulatedFrame frame = MakeFrame(flight, (i + 0.5) / frames);
    if (setting.jpeg_quality > 0) {
      std::vector<uint8_t> bytes;
      cv::imencode(".jpg", frame.image, bytes, {cv::IMWRITE_JPEG_QUALITY, setting.jpeg_quality});
      frame.image = cv::imdecode(bytes, cv::IMREAD_GRAYSCALE);
    }
    for (const TagDetection& tag : DetectPlainly(frame.image, setting.camera)) {
      const auto refined = refiner.Refine(frame.image, tag);
      if (!refined) {
        ++out.refused;
        continue;
      }
      const Corners truth = TrueCorners(frame, setting.camera, tag.id);
      const auto error = Difference(refined->corners, truth);
      ++out.tags;
      out.plain_px += Difference(tag.corners, truth).squaredNorm() / 8;
      out.refined_px += error.squaredNorm() / 8;
      out.nees += error.dot(refined->covariance.inverse() * error) / 8;
      for (int c = 0; c < 4; ++c) {
        const Eigen::Vector2d e = error.segment<2>(2 * c);
        const Eigen::Matrix2d p = refined->covariance.block<2, 2>(2 * c, 2 * c);
        out.corner_nees += e.dot(p.inverse() * e) / 8;
        out.bias_px += e / 4;
      }
    }
  }
  out.plain_px = std::sqrt(out.plain_px / out.tags);
  out.refined_px = std::sqrt(out.refined_px / out.tags);
  out.nees /= out.tags;
  out.corner_nees /= out.tags;
  out.bias_px /= out.tags;
  return out;
}

void ExpectHonest(const Score& score, double ratio, double most_px) {
  EXPECT_GT(score.tags, 60);
  EXPECT_LE(score.refused, 1 + score.tags / 50);
  EXPECT_GT(score.plain_px / score.refined_px, ratio);
  EXPECT_LT(score.refined_px, most_px);
  EXPECT_GT(score.nees, 0.8);
  EXPECT_LT(score.nees, 1.25);
  EXPECT_GT(score.corner_nees, 0.8);
  EXPECT_LT(score.corner_nees, 1.25);
  EXPECT_LT(score.bias_px.norm(), 0.005);
}

TEST(CornerRefiner, SharpImages) { ExpectHonest(Measure({3, 0.5}, 10), 5, 0.012); }
TEST(CornerRefiner, BlurredImages) { ExpectHonest(Measure({3, 1.0}, 10), 4, 0.016); }
TEST(CornerRefiner, NoisyImages) { ExpectHonest(Measure({8, 0.8}, 10), 2.5, 0.026); }
TEST(CornerRefiner, MotionBlurAndVignetting) {
  ExpectHonest(Measure({3, 0.5, 0.004, 0.4, "agile"}, 10), 3, 0.02);
}

// Noise that goes together over several pixels: enlarged and compressed images.
TEST(CornerRefiner, CorrelatedNoiseWidensTheCovariance) {
  const Flight flight = MakeFlightOf({0, 0.7});
  const CornerRefiner refiner = MakeRefiner();
  double nees = 0;
  int tags = 0;
  for (int i = 0; i < 8; ++i) {
    const SimulatedFrame frame = MakeFrame(flight, (i + 0.5) / 8);
    cv::Mat noise(frame.image.size(), CV_32F), image;
    cv::RNG random(static_cast<uint64_t>(i + 1));
    random.fill(noise, cv::RNG::NORMAL, 0, 15);
    cv::GaussianBlur(noise, noise, {0, 0}, 0.7);
    frame.image.convertTo(image, CV_32F);
    image += noise;
    image.convertTo(image, CV_8U);
    for (const TagDetection& tag : DetectPlainly(image, {})) {
      const auto refined = refiner.Refine(image, tag);
      if (!refined) continue;
      const auto error = Difference(refined->corners, TrueCorners(frame, {}, tag.id));
      nees += error.dot(refined->covariance.inverse() * error) / 8;
      ++tags;
    }
  }
  EXPECT_GT(tags, 50);
  EXPECT_GT(nees / tags, 0.6);
  EXPECT_LT(nees / tags, 1.5);
}

TEST(CornerRefiner, CompressedImages) {
  Setting setting;
  setting.jpeg_quality = 40;
  const Score score = Measure(setting, 10);
  EXPECT_GT(score.plain_px / score.refined_px, 2);
  EXPECT_GT(score.nees, 0.6);
  EXPECT_LT(score.nees, 1.5);
  RecordProperty("nees", std::to_string(score.nees));
}

TEST(CornerRefiner, ADistortedCameraLeavesNoBias) {
  Setting setting;
  setting.camera.k1 = -0.28;
  setting.camera.k2 = 0.07;
  setting.camera.p1 = 0.0005;
  setting.height_m = 1.0;  // large tags, on which the distortion bends the sides
  const Score score = Measure(setting, 12);
  EXPECT_GT(score.tags, 60);
  EXPECT_LT(score.refined_px, 0.012);
  EXPECT_LT(score.nees, 1.3);
  EXPECT_GT(score.nees, 0.7);
}

// Up to 80 degrees off the axis, where a picture without the distortion would be many times as
// wide.
TEST(CornerRefiner, AnEquidistantCameraIsRefinedToItsBorder) {
  Setting setting;
  setting.camera.lens = LensModel::kEquidistant;
  setting.camera.fx = setting.camera.fy = 130;
  setting.height_m = 0.6;
  const Score score = Measure(setting, 12);
  EXPECT_GT(score.tags, 60);
  EXPECT_LT(score.refined_px, 0.04);
  EXPECT_LE(score.refused, score.tags / 50);
}

}  // namespace
}  // namespace tagtwist::internal::corner_refiner_test

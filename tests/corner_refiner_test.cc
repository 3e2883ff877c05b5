#include "frontend/corner_refiner.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "frontend/front_end.h"
#include "frontend/named_flights.h"
#include "frontend/pattern_state.h"
#include "frontend/simulator.h"
#include "tests/tag_scene.h"

namespace tagtwist {
namespace {

using Corners = std::array<Eigen::Vector2d, 4>;

struct Setting {
  double noise_grey = 3, blur_px = 0.5, exposure_s = 0, vignetting = 0.2;
  std::string flight = "figure8";
  Camera camera = {};
  double height_m = 1.5;
  int jpeg_quality = 0;  // 0: none
};

struct Flight {
  SplineTrajectory trajectory;
  Simulator simulator;
};

Flight MakeFlightOf(const Setting& setting) {
  const TagMap map = MakeTagMap(TagGrid());
  FlightOptions flight;
  flight.height_m = setting.height_m;
  const auto trajectory = FlightPath(setting.flight, map, flight);
  SimulatorOptions options;
  options.seed = 77;
  options.corner_noise_px = 0;
  options.exposure_s = setting.exposure_s;
  options.renderer.noise_grey = setting.noise_grey;
  options.renderer.blur_px = setting.blur_px;
  options.renderer.vignetting = setting.vignetting;
  auto simulator = Simulator::Make(setting.camera, CourseCamFromBody(), map, *trajectory, options);
  EXPECT_TRUE(simulator);
  return {*trajectory, std::move(*simulator)};
}

SimulatedFrame MakeFrame(const Flight& flight, double share) {
  const auto length =
      static_cast<double>(flight.trajectory.last_ns() - flight.trajectory.first_ns());
  const auto t_ns = flight.trajectory.first_ns() + static_cast<int64_t>(share * length);
  return flight.simulator.MakeFrame(static_cast<uint64_t>(1000 * share), t_ns);
}

Corners TrueCorners(const SimulatedFrame& frame, const Camera& camera, int id) {
  Corners out;
  const Pose cam_from_world = CourseCamFromBody() * Inverse(frame.truth.world_from_body);
  const TagMap map = MakeTagMap(TagGrid());
  for (size_t c = 0; c < 4; ++c) {
    EXPECT_TRUE(camera.Project(cam_from_world * map.CornersInWorld(id)[c], &out[c]));
  }
  return out;
}

Eigen::Matrix<double, 8, 1> Difference(const Corners& a, const Corners& b) {
  Eigen::Matrix<double, 8, 1> out;
  for (int c = 0; c < 4; ++c) {
    out.segment<2>(2 * c) = a[static_cast<size_t>(c)] - b[static_cast<size_t>(c)];
  }
  return out;
}

CornerRefiner MakeRefiner(const Camera& camera = {}) {
  auto refiner = CornerRefiner::Create(MakeTagMap(TagGrid()), camera);
  EXPECT_TRUE(refiner);
  return std::move(*refiner);
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

// A frame's tags well inside of the image, with their true corners.
struct View {
  SimulatedFrame frame;
  std::vector<TagDetection> tags;
};

View MakeView(const Setting& setting = {}) {
  View out{MakeFrame(MakeFlightOf(setting), 0.4), {}};
  for (const TagDetection& tag : out.frame.detections) {
    const bool inside = std::all_of(tag.corners.begin(), tag.corners.end(),
                                    [&](const auto& c) { return setting.camera.Contains(c, 12); });
    if (inside) out.tags.push_back(tag);
  }
  EXPECT_GE(out.tags.size(), 5U);
  return out;
}

TEST(CornerRefiner, AnotherTagsPatternIsRefused) {
  const View view = MakeView();
  const CornerRefiner refiner = MakeRefiner();
  for (TagDetection tag : view.tags) {
    ASSERT_TRUE(refiner.Refine(view.frame.image, tag)) << tag.id;
    for (int wrong = 1; wrong < 12; ++wrong) {
      TagDetection other = tag;
      other.id = (tag.id + wrong) % 108;
      EXPECT_FALSE(refiner.Refine(view.frame.image, other)) << tag.id << " as " << other.id;
      EXPECT_FALSE(refiner.Refine(view.frame.image, other, 2)) << tag.id << " as " << other.id;
    }
    std::rotate(tag.corners.begin(), tag.corners.begin() + 1, tag.corners.end());
    EXPECT_FALSE(refiner.Refine(view.frame.image, tag)) << tag.id << " turned";
  }
  TagDetection strange = view.tags[0];
  strange.id = 400;
  EXPECT_FALSE(refiner.Refine(view.frame.image, strange)) << "not in the map";
}

TEST(CornerRefiner, AStartTwoPixelsOffConverges) {
  const View view = MakeView();
  const CornerRefiner refiner = MakeRefiner();
  const Eigen::Vector2d shifts[] = {{2, 0.3}, {-1.4, 1.4}, {0.2, -2}, {1.5, 2}};
  for (const TagDetection& tag : view.tags) {
    for (const Eigen::Vector2d& shift : shifts) {
      TagDetection start = tag;
      for (size_t c = 0; c < 4; ++c) {
        start.corners[c] += shift + 0.3 * Eigen::Vector2d(c % 2 == 0 ? 1 : -1, c < 2 ? 1 : -1);
      }
      const auto refined = refiner.Refine(view.frame.image, start, 3);
      ASSERT_TRUE(refined) << tag.id << " from " << shift.transpose();
      EXPECT_LT(Difference(refined->corners, tag.corners).norm() / std::sqrt(8), 0.05) << tag.id;
    }
  }
}

// Covers a share of every tag from one side with a grey.
TEST(CornerRefiner, PartlyCoveredTagsAreHonestOrRefused) {
  const CornerRefiner refiner = MakeRefiner();
  for (const int grey : {0, 120, 255}) {
    for (const double share : {0.12, 0.25, 0.5, 0.7}) {
      const View view = MakeView();
      double nees = 0;
      int refined_tags = 0;
      for (const TagDetection& tag : view.tags) {
        cv::Mat image = view.frame.image.clone();
        Eigen::Vector2d low = tag.corners[0], high = tag.corners[0];
        for (const auto& corner : tag.corners) {
          low = low.cwiseMin(corner);
          high = high.cwiseMax(corner);
        }
        const int width = static_cast<int>(share * (high.x() - low.x()) + 4);
        const cv::Rect cover(static_cast<int>(low.x()) - 4, static_cast<int>(low.y()) - 6, width,
                             static_cast<int>(high.y() - low.y()) + 12);
        image(cover & cv::Rect(0, 0, image.cols, image.rows)) = grey;
        const auto refined = refiner.Refine(image, tag);
        if (!refined) continue;
        ++refined_tags;
        const auto error = Difference(refined->corners, tag.corners);
        nees += error.dot(refined->covariance.inverse() * error) / 8;
      }
      if (refined_tags > 0) {
        EXPECT_LT(nees / refined_tags, 2.5) << grey << " over " << share;
      }
      if (share > 0.4) {
        EXPECT_EQ(refined_tags, 0) << grey << " over " << share;
      }
    }
  }
}

TEST(CornerRefiner, BlankTinyAndCutPatchesAreRefused) {
  const CornerRefiner refiner = MakeRefiner();
  TagDetection tag;
  tag.id = 5;
  tag.corners = {{{100, 140}, {140, 140}, {140, 100}, {100, 100}}};
  for (const int grey : {0, 128, 255}) {
    EXPECT_FALSE(refiner.Refine(cv::Mat(240, 376, CV_8UC1, cv::Scalar(grey)), tag, 2));
  }
  EXPECT_FALSE(refiner.Refine(cv::Mat(), tag));
  EXPECT_FALSE(refiner.Refine(cv::Mat(10, 10, CV_8UC1, cv::Scalar(9)), tag, 3));
  EXPECT_FALSE(refiner.Refine(cv::Mat(240, 376, CV_8UC3, cv::Scalar::all(9)), tag));
  const View view = MakeView();
  for (const Eigen::Vector2d& place :
       {Eigen::Vector2d(-15, -15), {-120, 0}, {240, 60}, {1e9, 0}, {NAN, 0}, {255, 110}}) {
    TagDetection moved = tag;
    for (auto& corner : moved.corners) corner += place;
    EXPECT_FALSE(refiner.Refine(view.frame.image, moved, 2)) << place.transpose();
  }
  for (const double side : {0.0, 1.0, 5.0}) {
    TagDetection tiny = tag;
    tiny.corners = {{{100, 100 + side}, {100 + side, 100 + side}, {100 + side, 100}, {100, 100}}};
    EXPECT_FALSE(refiner.Refine(view.frame.image, tiny, 2)) << side;
  }
}

TEST(CornerRefiner, AllTagsKeepTheirPlacesAndGetACovariance) {
  const View view = MakeView();
  std::vector<TagDetection> tags = view.tags;
  tags[1].id = (tags[1].id + 50) % 108;  // will not be believed
  const CornerRefiner refiner = MakeRefiner();
  const auto all = refiner.RefineAll(view.frame.image, tags);
  const auto again = MakeRefiner().RefineAll(view.frame.image, tags);
  ASSERT_EQ(all.size(), tags.size());
  for (size_t i = 0; i < all.size(); ++i) {
    EXPECT_EQ(all[i].id, tags[i].id);
    ASSERT_TRUE(all[i].covariance);
    EXPECT_EQ(all[i].corners, again[i].corners);
    EXPECT_EQ(*all[i].covariance, *again[i].covariance);
  }
  EXPECT_EQ(all[1].corners, tags[1].corners);
  EXPECT_GT((*all[1].covariance)(0, 0), 0.5);
  EXPECT_LT((*all[0].covariance)(0, 0), 0.01);
}

}  // namespace
}  // namespace tagtwist

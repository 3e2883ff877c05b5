#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <set>

#include "frontend/simulation/named_flights.h"
#include "frontend/simulation/simulator.h"
#include "frontend/tags/tag_detector.h"
#include "frontend/types/so3.h"
#include "tests/support/edge_fit.h"

namespace tagtwist::internal::simulated_images_test {
namespace {

constexpr int64_t kSecond = 1000000000;

Pose CourseCamFromBody() {
  const double c = std::sqrt(0.5);
  Eigen::Matrix3d rotation;
  rotation << c, -c, 0, -c, -c, 0, 0, 0, -1;
  return MakePose(Eigen::Quaterniond(rotation), {-0.04, 0, -0.03});
}

SplineTrajectory Flight(const std::string& name, const TagMap& map = MakeTagMap({})) {
  return *FlightPath(name, map, {});
}

Simulator MustMake(const SimulatorOptions& options, const std::string& flight = "figure8",
                   const TagMap& map = MakeTagMap({})) {
  auto made =
      Simulator::Make(MakeSetUp({}, CourseCamFromBody(), map), Flight(flight, map), options);
  EXPECT_TRUE(made) << made.error().message;
  return *made;
}

TEST(SimulatedImages, TagsAreGoneWhileTheyAreHidden) {
  SimulatorOptions options;
  options.hide_tags_from_s = 2;
  options.hide_tags_to_s = 3;
  const Simulator simulator = MustMake(options);
  const auto detector = TagDetector::Create("tag36h11", {});
  for (const int64_t t_ns : {kSecond, 2 * kSecond, 3 * kSecond - 1, 3 * kSecond}) {
    const bool hidden = t_ns >= 2 * kSecond && t_ns < 3 * kSecond;
    const SimulatedFrame frame = simulator.MakeFrame(0, t_ns);
    EXPECT_EQ(frame.detections.empty(), hidden) << t_ns;
    EXPECT_EQ(detector->Detect(frame.image).empty(), hidden) << t_ns;
  }
}

// What the simulator calls visible, libapriltag sees, with corner order and pixel convention.
TEST(SimulatedImages, TagsInTheImagesAreDetectedWhereTheyAre) {
  const TagMap map = MakeTagMap({});
  SimulatorOptions options;
  options.corner_noise_px = 0;
  options.min_tag_side_px = 20;
  options.renderer.noise_grey = 1;
  options.exposure_s = 0;
  const Simulator simulator = MustMake(options);
  const auto detector = TagDetector::Create("tag36h11", {});
  int visible = 0, found = 0;
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  double worst = 0, square = 0;
  for (int i = 0; i < 8; ++i) {
    const SimulatedFrame frame = simulator.MakeFrame(i, (2 * i + 1) * kSecond);
    std::map<int, TagDetection> seen;
    for (const TagDetection& tag : detector->Detect(frame.image)) seen[tag.id] = tag;
    for (const auto& [id, tag] : seen) EXPECT_NE(map.Find(id), nullptr) << "false tag " << id;
    for (const TagDetection& truth : frame.detections) {
      const bool inside = std::all_of(truth.corners.begin(), truth.corners.end(),
                                      [](const auto& c) { return Camera().Contains(c, 6); });
      if (!inside) continue;
      ++visible;
      if (seen.count(truth.id) == 0) continue;
      ++found;
      for (size_t c = 0; c < 4; ++c) {
        const Eigen::Vector2d error = seen[truth.id].corners[c] - truth.corners[c];
        sum += error;
        square += error.squaredNorm();
        worst = std::max(worst, error.norm());
      }
    }
  }
  EXPECT_GT(visible, 60);
  EXPECT_EQ(found, visible);
  EXPECT_LT(worst, 0.2);
  EXPECT_LT(std::sqrt(square / (4 * found)), 0.06);
  EXPECT_LT((sum / (4 * found)).norm(), 0.01);
  RecordProperty("rms_px", std::to_string(std::sqrt(square / (4 * found))));
  RecordProperty("worst_px", std::to_string(worst));
  RecordProperty("bias_px", std::to_string((sum / (4 * found)).norm()));
}

TEST(SimulatedImages, StampsAreTheMiddleOfTheExposure) {
  SimulatorOptions options;
  options.exposure_s = 0.02;
  options.renderer.blur_px = 0;
  options.renderer.noise_grey = options.renderer.vignetting = options.renderer.gradient = 0;
  options.renderer.scene.scribbles_per_m2 = 0;
  const TagMap map = MakeTagMap({});
  const Simulator simulator = MustMake(options, "straight");
  const SimulatedFrame frame = simulator.MakeFrame(0, 10 * kSecond);
  ASSERT_GT(frame.truth.twist.v_world.norm(), 0.05);
  const Pose cam_from_world = CourseCamFromBody() * Inverse(frame.truth.world_from_body);
  int sides = 0;
  for (const TagDetection& tag : frame.detections) {
    for (size_t side = 0; side < 4; ++side) {
      const double bias =
          EdgeBias(frame.image, {}, cam_from_world, map.CornersInWorld(tag.id), side, 3);
      if (!std::isfinite(bias)) continue;
      EXPECT_LT(std::abs(bias), 0.02) << tag.id;
      ++sides;
    }
  }
  EXPECT_GT(sides, 10);
}

TEST(SimulatedImages, TagsUnderOccludersAreNotDetected) {
  SimulatorOptions options;
  options.corner_noise_px = 0;
  options.min_tag_side_px = 20;
  const Simulator clear = MustMake(options);
  options.renderer.scene.occluders = 60;
  options.renderer.scene.occluder_speed_mps = 0.2;
  const Simulator covered = MustMake(options);
  const auto detector = TagDetector::Create("tag36h11", {});
  size_t in_clear = 0, in_covered = 0, missing = 0;
  for (int i = 0; i < 6; ++i) {
    const SimulatedFrame frame = covered.MakeFrame(i, 3 * i * kSecond);
    in_clear += clear.MakeFrame(i, 3 * i * kSecond).detections.size();
    in_covered += frame.detections.size();
    std::set<int> seen;
    for (const TagDetection& tag : detector->Detect(frame.image)) seen.insert(tag.id);
    for (const TagDetection& tag : frame.detections) {
      const bool inside = std::all_of(tag.corners.begin(), tag.corners.end(),
                                      [](const auto& c) { return Camera().Contains(c, 6); });
      missing += inside && seen.count(tag.id) == 0;
    }
  }
  EXPECT_LT(in_covered, in_clear * 9 / 10);
  EXPECT_GT(in_covered, in_clear / 4);
  EXPECT_LE(missing, 1U) << "called visible, but under an occluder";
}

TEST(SimulatedImages, EveryFamilyThatIsQuickToLoadIsReadBack) {
  for (const char* family :
       {"tag36h11", "tag36h10", "tag25h9", "tag16h5", "tagCircle21h7", "tagStandard41h12"}) {
    TagDetectorOptions detector_options;
    detector_options.max_hamming = 0;
    const auto detector = TagDetector::Create(family, detector_options);
    ASSERT_TRUE(detector) << detector.error().message;
    const TagMap map(family, {{7, MakePose(ExpSo3({0, 0, 0.3}), {0, 0, 0}), 0.3}});
    SimulatorOptions options;
    options.corner_noise_px = 0;
    std::vector<TruthSample> poses(2);
    poses[1].t_ns = kSecond;
    for (TruthSample& pose : poses) {
      pose.world_from_body = MakePose(Eigen::Quaterniond::Identity(), {0, 0, 1.0});
    }
    const auto simulator = Simulator::Make(MakeSetUp({}, CourseCamFromBody(), map),
                                           *SplineTrajectory::Fit(poses, {}), options);
    ASSERT_TRUE(simulator) << simulator.error().message;
    const SimulatedFrame frame = simulator->MakeFrame(0, 0);
    const auto seen = detector->Detect(frame.image);
    const auto tag =
        std::find_if(seen.begin(), seen.end(), [](const auto& t) { return t.id == 7; });
    ASSERT_NE(tag, seen.end()) << family;
    ASSERT_EQ(frame.detections.size(), 1U) << family;
    for (size_t c = 0; c < 4; ++c) {
      EXPECT_LT((tag->corners[c] - frame.detections[0].corners[c]).norm(), 0.3) << family << c;
    }
  }
}

}  // namespace
}  // namespace tagtwist::internal::simulated_images_test

#include "frontend/simulation/simulator.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <set>

#include "frontend/simulation/named_flights.h"
#include "frontend/types/so3.h"

namespace tagtwist::internal::simulator_test {
namespace {

using ::testing::HasSubstr;

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

SimulatorOptions DetectionsOnly(double corner_noise_px = 0) {
  SimulatorOptions out;
  out.images = false;
  out.corner_noise_px = corner_noise_px;
  return out;
}

TEST(Simulator, DetectionsAreTheProjectedCornersOfWholeTags) {
  const TagMap map = MakeTagMap({});
  const Simulator simulator = MustMake(DetectionsOnly());
  const Camera camera;
  for (int i = 0; i < 20; ++i) {
    const SimulatedFrame frame = simulator.MakeFrame(i, i * kSecond);
    EXPECT_TRUE(frame.image.empty());
    const Pose cam_from_world = CourseCamFromBody() * Inverse(frame.truth.world_from_body);
    std::set<int> expected, seen;
    for (const Tag& tag : map.tags()) {
      bool whole = true;
      for (const Eigen::Vector3d& corner : map.CornersInWorld(tag.id)) {
        Eigen::Vector2d pixel;
        whole &= camera.Project(cam_from_world * corner, &pixel) && camera.Contains(pixel);
      }
      if (whole) expected.insert(tag.id);
    }
    for (const TagDetection& tag : frame.detections) {
      seen.insert(tag.id);
      for (size_t c = 0; c < 4; ++c) {
        Eigen::Vector2d pixel;
        ASSERT_TRUE(camera.Project(cam_from_world * map.CornersInWorld(tag.id)[c], &pixel));
        EXPECT_LT((pixel - tag.corners[c]).norm(), 1e-9);
      }
    }
    EXPECT_EQ(seen, expected);
    EXPECT_GE(seen.size(), 6U);
  }
}

// Every corner is where the camera sees it when its own row is taken, and elsewhere at the stamp.
TEST(Simulator, ARollingShutterTakesEachCornerAtItsRow) {
  SimulatorOptions options = DetectionsOnly();
  options.line_time_s = -5e-5;
  const Simulator simulator = MustMake(options);
  const Camera camera;
  const TagMap map = MakeTagMap({});
  double farthest_px = 0;
  for (int i = 1; i < 10; ++i) {
    const int64_t t_ns = i * kSecond;
    for (const TagDetection& tag : simulator.MakeFrame(i, t_ns).detections) {
      for (size_t c = 0; c < 4; ++c) {
        const Eigen::Vector3d corner = map.CornersInWorld(tag.id)[c];
        const auto pixel_at = [&](int64_t at_ns) {
          const Pose body = simulator.trajectory().At(at_ns).world_from_body;
          Eigen::Vector2d pixel(0, 0);
          EXPECT_TRUE(camera.Project(CourseCamFromBody() * (Inverse(body) * corner), &pixel));
          return pixel;
        };
        const int64_t of_row_ns = std::llround(1e9 * options.line_time_s * tag.corners[c].y());
        EXPECT_LT((pixel_at(t_ns + of_row_ns) - tag.corners[c]).norm(), 1e-6);
        farthest_px = std::max(farthest_px, (pixel_at(t_ns) - tag.corners[c]).norm());
      }
    }
  }
  EXPECT_GT(farthest_px, 1);
  options.images = true;
  EXPECT_THAT(*options.Problem(), HasSubstr("line_time_s: expected 0 with images"));
}

TEST(Simulator, BentTagsAreSeenByTheirCornersAndNotDrawn) {
  std::vector<Tag> tags = MakeTagMap({}).tags();
  for (Tag& tag : tags) tag.bend_m = 0.01;
  const TagMap map("tag36h11", tags);
  const Simulator simulator = MustMake(DetectionsOnly(), "figure8", map);
  const SimulatedFrame frame = simulator.MakeFrame(0, kSecond);
  const Pose cam_from_world = CourseCamFromBody() * Inverse(frame.truth.world_from_body);
  ASSERT_GT(frame.detections.size(), 3u);
  for (const TagDetection& tag : frame.detections) {
    for (size_t c = 0; c < 4; ++c) {
      Eigen::Vector2d pixel(0, 0);
      ASSERT_TRUE(Camera().Project(cam_from_world * map.CornersInWorld(tag.id)[c], &pixel));
      EXPECT_LT((pixel - tag.corners[c]).norm(), 1e-9);
    }
  }
  const auto drawn =
      Simulator::Make(MakeSetUp({}, CourseCamFromBody(), map), Flight("figure8", map), {});
  ASSERT_FALSE(drawn);
  EXPECT_EQ(drawn.error().message,
            "tag 0: bend_m: expected 0 with images, which are drawn of plane tags");
}

TEST(Simulator, CornerNoiseHasItsSigma) {
  const Simulator noisy = MustMake(DetectionsOnly(0.3)), clean = MustMake(DetectionsOnly());
  double sum = 0, square = 0;
  int count = 0;
  for (int i = 0; i < 100; ++i) {
    const auto a = noisy.MakeFrame(i, i * kSecond / 5).detections;
    const auto b = clean.MakeFrame(i, i * kSecond / 5).detections;
    ASSERT_EQ(a.size(), b.size());
    for (size_t k = 0; k < a.size(); ++k) {
      for (size_t c = 0; c < 4; ++c) {
        const Eigen::Vector2d error = a[k].corners[c] - b[k].corners[c];
        sum += error.sum();
        square += error.squaredNorm();
        count += 2;
      }
    }
  }
  EXPECT_GT(count, 5000);
  EXPECT_NEAR(std::sqrt(square / count), 0.3, 0.01);
  EXPECT_NEAR(sum / count, 0, 4 * 0.3 / std::sqrt(count));
}

TEST(Simulator, FaultsComeInTheirShares) {
  SimulatorOptions options = DetectionsOnly();
  const Simulator clean = MustMake(options);
  options.hidden_fraction = 0.3;
  options.wrong_id_fraction = 0.1;
  const Simulator faulty = MustMake(options);
  double visible = 0, detected = 0, wrong = 0;
  for (int i = 0; i < 200; ++i) {
    std::map<double, int> id_of_corner;
    for (const TagDetection& tag : clean.MakeFrame(i, i * kSecond / 10).detections) {
      id_of_corner[tag.corners[0].x()] = tag.id;
    }
    std::set<int> ids;
    for (const TagDetection& tag : faulty.MakeFrame(i, i * kSecond / 10).detections) {
      EXPECT_TRUE(ids.insert(tag.id).second) << "an id twice in a frame";
      wrong += id_of_corner.at(tag.corners[0].x()) != tag.id;
      ++detected;
    }
    visible += static_cast<double>(id_of_corner.size());
  }
  EXPECT_NEAR(detected / visible, 0.7, 0.03);
  EXPECT_NEAR(wrong / detected, 0.1, 0.03);
}

// On a wall in front of another: the one behind is hidden, the ones seen from their back, too, and
// with walls those behind the sheets that carry the others.
TEST(Simulator, TagsBehindTagsAndWallsAreNotDetected) {
  const Eigen::Quaterniond flat = Eigen::Quaterniond::Identity();
  const TagMap map("tag36h11",
                   {{0, MakePose(flat, {0, 0, 0}), 0.15},
                    {1, MakePose(flat, {0.02, 0, 0.3}), 0.15},
                    {2, MakePose(flat, {0.35, 0, 0}), 0.15},
                    {3, MakePose(Eigen::Quaterniond(0, 1, 0, 0), {0, 0.3, 0.01}), 0.1}});
  std::vector<TruthSample> poses(2);
  poses[1].t_ns = kSecond;
  for (TruthSample& pose : poses) pose.world_from_body = MakePose(flat, {0.1, 0.1, 1.2});
  SimulatorOptions options = DetectionsOnly();
  const auto ids = [&] {
    const auto simulator = Simulator::Make(MakeSetUp({}, CourseCamFromBody(), map),
                                           *SplineTrajectory::Fit(poses, {}), options);
    std::vector<int> out;
    for (const TagDetection& tag : simulator->MakeFrame(0, 0).detections) out.push_back(tag.id);
    return out;
  };
  EXPECT_THAT(ids(), ::testing::ElementsAre(1, 2));
  options.renderer.scene.walls = true;
  EXPECT_THAT(ids(), ::testing::ElementsAre(1));
}

TEST(Simulator, ImuIsTheDerivativeOfThePath) {
  SimulatorOptions options = DetectionsOnly();
  options.gyro_noise_radps = options.accel_noise_mps2 = 0;
  const Simulator simulator = MustMake(options, "agile");
  const auto imu = simulator.MakeImu(kSecond, 3 * kSecond);
  ASSERT_EQ(imu.size(), 401U);
  EXPECT_EQ(imu[1].t_ns - imu[0].t_ns, 5000000);
  constexpr int64_t kStep = 1000000;
  for (size_t i = 0; i < imu.size(); i += 50) {
    const BodyState state = simulator.trajectory().At(imu[i].t_ns);
    const Eigen::Vector3d accel = (simulator.trajectory().At(imu[i].t_ns + kStep).twist.v_world -
                                   simulator.trajectory().At(imu[i].t_ns - kStep).twist.v_world) /
                                  (2e-9 * kStep);
    const Eigen::Vector3d force = accel + Eigen::Vector3d(0, 0, 9.81);
    EXPECT_LT((imu[i].gyro_radps - state.twist.omega_body).norm(), 1e-12);
    EXPECT_LT((state.world_from_body.rotation() * imu[i].accel_mps2 - force).norm(), 1e-3);
  }
  options.imu_rate_hz = 0;
  EXPECT_TRUE(MustMake(options).MakeImu(0, kSecond).empty());
}

TEST(Simulator, StampsGrowAndStayInside) {
  const auto even = MakeStamps(kSecond, 2 * kSecond, {50, 0, 1});
  ASSERT_EQ(even->size(), 51U);
  EXPECT_EQ(even->back(), 2 * kSecond);
  const auto uneven = MakeStamps(0, 100 * kSecond, {50, 0.008, 1});
  int64_t shortest = kSecond, longest = 0;
  for (size_t i = 1; i < uneven->size(); ++i) {
    shortest = std::min(shortest, (*uneven)[i] - (*uneven)[i - 1]);
    longest = std::max(longest, (*uneven)[i] - (*uneven)[i - 1]);
  }
  EXPECT_GT(shortest, 0);
  EXPECT_LT(shortest, 8000000);
  EXPECT_GT(longest, 32000000);
  EXPECT_GE(uneven->front(), 0);
  EXPECT_LE(uneven->back(), 100 * kSecond);
  EXPECT_THAT(MakeStamps(0, 1, {50, 0.02, 1}).error().message, HasSubstr("jitter_s"));
  EXPECT_THAT(MakeStamps(0, 1, {NAN, 0, 1}).error().message, HasSubstr("rate_hz"));
}

}  // namespace
}  // namespace tagtwist::internal::simulator_test

#include "estimator/graph/track_planes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <random>

#include "estimator/batch/batch.h"
#include "frontend/types/so3.h"
#include "tests/support/flights/exact_model.h"
#include "tests/support/flights/window_run.h"

namespace tagtwist::internal::track_planes_test {
namespace {

using testing::IsEmpty;

// Tags of 0.2 m every half metre on a floor of 3 x 3 m and on the walls x = 3 and y = 3.
TagMap Room() {
  Eigen::Matrix3d wall_x, wall_y;
  wall_x << 0, 0, -1, -1, 0, 0, 0, 1, 0;
  wall_y << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  std::vector<Tag> tags;
  const auto add = [&](const Eigen::Matrix3d& rotation, const Eigen::Vector3d& centre) {
    tags.push_back(
        {static_cast<int>(tags.size()), MakePose(Eigen::Quaterniond(rotation), centre), 0.2});
  };
  for (int i = 0; i < 36; ++i) {
    const double u = 0.25 + 0.5 * (i % 6), v = 0.25 + 0.5 * (i / 6);
    add(Eigen::Matrix3d::Identity(), {u, v, 0});
    add(wall_x, {3, u, v});
    add(wall_y, {u, 3, v});
  }
  return TagMap("tag36h11", tags);
}

EstimatorSetup RoomSetup(const EstimatorOptions& options) {
  Camera camera;
  camera.width = 640, camera.height = 480;
  camera.fx = camera.fy = 400;
  camera.cx = 320, camera.cy = 240;
  return MakeEstimatorSetup(MakeSetUp(camera, Pose(), Room()), options);
}

// In the middle of the room, looking into its corner.
Pose WorldFromBody() {
  Eigen::Matrix3d rotation;
  rotation.col(2) = Eigen::Vector3d(1, 1, -0.8).normalized();
  rotation.col(0) = Eigen::Vector3d(1, -1, 0).normalized();
  rotation.col(1) = rotation.col(2).cross(rotation.col(0));
  return MakePose(Eigen::Quaterniond(rotation), {1.1, 1.1, 1.4});
}

size_t PlaneAt(const std::vector<TrackPlane>& planes, const Eigen::Vector3d& from,
               const Eigen::Vector3d& through) {
  return PlaneOfRay(planes, {from, through - from}).value_or(99);
}

TEST(PlaneOfRay, IsTheNearestSurfaceThatFacesTheCameraWithinItsRegion) {
  const auto planes = FindTrackPlanes(Room());
  ASSERT_EQ(planes.size(), 3u);
  const Eigen::Vector3d from(1.1, 1.1, 1.4);
  EXPECT_EQ(PlaneAt(planes, from, {2.99, 1, 0}), 0u) << "the wall is a centimetre behind it";
  EXPECT_EQ(PlaneAt(planes, from, {3, 1, 0.01}), 1u) << "the floor goes on behind the wall";
  EXPECT_EQ(PlaneAt(planes, from, {1, 3, 1}), 2u);
  EXPECT_EQ(PlaneAt(planes, from, {1, 3, 3.4}), 99u) << "over the wall's tags";
  EXPECT_EQ(PlaneAt(planes, from, {-0.5, 1, 0}), 99u) << "beyond the floor's";
  EXPECT_EQ(PlaneAt(planes, {1, 1, -1}, {1, 1, 0}), 99u) << "from below";
  EXPECT_EQ(PlaneAt(planes, from, {1.1, 1.1, 3}), 99u) << "upwards";
  EXPECT_EQ(PlaneAt(planes, from, {std::nan(""), 1, 1}), 99u);
}

// Neighbours' boxes overlap; which of both is a millimetre nearer says nothing.
TEST(PlaneOfRay, OnAnUnevenMatIsThatOfTheNearestTag) {
  for (const double height_m : {-0.005, 0.005}) {
    const auto planes = FindTrackPlanes(
        TagMap("tag36h11", {{0, MakePose(ExpSo3({0, 0, 0}), {0, 0, 0}), 0.2},
                            {1, MakePose(ExpSo3({0, 0.03, 0}), {0.3, 0, height_m}), 0.2}}));
    ASSERT_EQ(planes.size(), 2u);
    for (const double x : {0.02, 0.12, 0.14}) EXPECT_EQ(PlaneAt(planes, {1, 0, 1}, {x, 0, 0}), 0u);
    for (const double x : {0.16, 0.18, 0.28}) EXPECT_EQ(PlaneAt(planes, {1, 0, 1}, {x, 0, 0}), 1u);
  }
}

TEST(PlaneOfRay, AWallInFrontOfAnotherIsNotTheSameSurface) {
  const auto planes =
      FindTrackPlanes(TagMap("tag36h11", {{0, MakePose(ExpSo3({0, 0, 0}), {0, 0, 0}), 0.2},
                                          {1, MakePose(ExpSo3({0, 0, 0}), {0.3, 0, 0.1}), 0.2}}));
  EXPECT_EQ(PlaneAt(planes, {0.1, 0, 1}, {0.05, 0, 0.1}), 1u) << "nearer to tag 0";
}

// Where to find something to track, in W.
using Points = std::vector<Eigen::Vector3d>;

class Scatter {
 public:
  double operator()(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(rng_);
  }
  Eigen::Vector2d Normal2() { return {normal_(rng_), normal_(rng_)}; }

 private:
  std::mt19937_64 rng_{7};
  std::normal_distribution<double> normal_;
};

// On the floor and the walls, between the tags.
Points RoomPoints() {
  Scatter scatter;
  const auto near_tag = [](double x) { return std::abs(std::remainder(x - 0.25, 0.5)) < 0.13; };
  Points out;
  while (out.size() < 600) {
    const double u = scatter(0, 3), v = scatter(0, 3);
    if (near_tag(u) && near_tag(v)) continue;
    out.insert(out.end(), {{u, v, 0}, {3, u, v}, {u, 3, v}});
  }
  return out;
}

constexpr int kFrames = 38, kFirstHidden = 10, kShownAgain = 28;

// The flight with the points tracked, and without tags for a while in its middle.
void AddTracksAndGap(const EstimatorSetup& setup, const Points& points, ExactModelFlight* flight) {
  Scatter scatter;
  for (size_t i = 0; i < flight->truth.size(); ++i) {
    FrameMeasurements& m = flight->measurements[i];
    if (i >= kFirstHidden && i < kShownAgain) m.tags.clear();
    const Pose cam_from_world = setup.cam_from_body * Inverse(flight->truth[i].world_from_body);
    for (size_t k = 0; k < points.size(); ++k) {
      TrackObservation track;
      track.track_id = static_cast<int64_t>(k);
      if (!setup.camera.Project(cam_from_world * points[k], &track.pixel)) continue;
      if (!setup.camera.Contains(track.pixel, 2)) continue;
      track.pixel += *setup.options.track_sigma_px * scatter.Normal2();
      m.tracks.push_back(track);
    }
  }
}

// Root mean square errors [m, rad] and the mean NEES, of all frames and of those without tags.
struct Errors {
  double position_m = 0, gap_position_m = 0, gap_rotation_rad = 0, nees = 0, gap_nees = 0;
};

class ErrorSums {
 public:
  void Add(const std::vector<FrameEstimate>& estimates, const std::vector<BodyState>& truth) {
    ASSERT_EQ(estimates.size(), truth.size());
    // States far apart in time are nearly independent draws.
    for (size_t i = 2; i < truth.size(); i += 5) {
      const bool in_gap = i >= kFirstHidden && i < kShownAgain;
      const StateVector e = Difference(estimates[i].state, truth[i]);
      const double nees = e.dot(estimates[i].covariance.llt().solve(e));
      all_.position_m += e.segment<3>(3).squaredNorm(), all_.nees += nees, ++n_;
      if (!in_gap) continue;
      all_.gap_position_m += e.segment<3>(3).squaredNorm();
      all_.gap_rotation_rad += e.head<3>().squaredNorm();
      all_.gap_nees += nees, ++n_gap_;
    }
  }
  Errors Rms() const {
    return {std::sqrt(all_.position_m / n_), std::sqrt(all_.gap_position_m / n_gap_),
            std::sqrt(all_.gap_rotation_rad / n_gap_), all_.nees / n_, all_.gap_nees / n_gap_};
  }

 private:
  Errors all_;
  int n_ = 0, n_gap_ = 0;
};

struct Runs {
  Errors batch, window;
  std::vector<std::string> warnings;
};

ExactModelOptions Model(unsigned seed) {
  ExactModelOptions model;
  model.random_seed = seed;
  model.frames = kFrames;
  model.linear.psd = model.angular.psd = 3;
  model.max_tags = 3;
  return model;
}

EstimatorOptions Options(bool use_tracks) {
  EstimatorOptions options = GivenNoise(Model(1));
  options.use_tracks = use_tracks;
  return options;
}

// Flights over a map among the points, estimated with or without their tracks.
Runs Fly(const EstimatorSetup& setup, const Pose& world_from_body, const Points& points,
         unsigned flights) {
  ErrorSums batch, window;
  Runs out;
  for (unsigned seed = 1; seed <= flights; ++seed) {
    ExactModelFlight flight = DrawFlight(Model(seed), setup, world_from_body);
    AddTracksAndGap(setup, points, &flight);
    const auto result = RunBatch(SetUpOf(setup), setup.options, flight.measurements);
    EXPECT_TRUE(result) << result.error().message;
    if (!result) return out;
    batch.Add(result->frames, flight.truth);
    window.Add(RunWindow(setup, flight.measurements).lagged, flight.truth);
    out.warnings.insert(out.warnings.end(), result->warnings.begin(), result->warnings.end());
  }
  out.batch = batch.Rms(), out.window = window.Rms();
  return out;
}

void ExpectBetterInGap(const Errors& with, const Errors& without) {
  EXPECT_LT(with.position_m, without.position_m);
  EXPECT_LT(with.gap_position_m, 0.8 * without.gap_position_m);
  EXPECT_LT(with.gap_rotation_rad, 0.6 * without.gap_rotation_rad);
}

TEST(TracksInARoom, BridgeAGapOfTagsAndTheirCovarianceHolds) {
  constexpr unsigned kFlights = 2;
  const Points points = RoomPoints();
  const Runs without = Fly(RoomSetup(Options(false)), WorldFromBody(), points, kFlights);
  const Runs with = Fly(RoomSetup(Options(true)), WorldFromBody(), points, kFlights);
  ExpectBetterInGap(with.batch, without.batch);
  ExpectBetterInGap(with.window, without.window);
  const double n = kFlights * (kFrames - 2) / 5.0;
  for (const double nees : {with.batch.nees, with.window.nees}) {
    EXPECT_NEAR(nees, 12, 4 * std::sqrt(24 / n));
  }
  EXPECT_THAT(with.warnings, IsEmpty());
}

// What they say is wrong by half a metre of depth, and it is found out.
TEST(TracksInARoom, OnABoxBeforeAWallAreContradicted) {
  Points points = RoomPoints();
  for (Eigen::Vector3d& p : points) {
    const bool behind = std::abs(p.y() - 1.5) < 0.5 && std::abs(p.z() - 0.8) < 0.5;
    if (p.x() == 3 && behind) p.x() = 2.5;
  }
  const Runs without = Fly(RoomSetup(Options(false)), WorldFromBody(), points, 2);
  const Runs with = Fly(RoomSetup(Options(true)), WorldFromBody(), points, 2);
  ExpectBetterInGap(with.batch, without.batch);
  ExpectBetterInGap(with.window, without.window);
  for (const double nees : {with.batch.nees, with.window.nees}) {
    EXPECT_LT(nees, 20) << "23 and 27 where nothing is left out";
  }
}

// Tags and floor up to 4 mm up or down, sloping by up to a degree, as calibrated maps have them.
class TracksOnAnUnevenMat : public testing::Test {
 protected:
  static double HeightAt(double x, double y) { return 4e-3 * std::sin(4 * x) * std::cos(4 * y); }
  static EstimatorSetup Setup(const EstimatorOptions& options) {
    const EstimatorSetup course = CourseSetup();
    std::vector<Tag> tags = course.map.tags();
    for (Tag& tag : tags) {
      const double x = tag.world_from_tag.translation().x(),
                   y = tag.world_from_tag.translation().y();
      const double slope_x = 16e-3 * std::cos(4 * x) * std::cos(4 * y),
                   slope_y = -16e-3 * std::sin(4 * x) * std::sin(4 * y);
      tag.world_from_tag = MakePose(ExpSo3({slope_y, -slope_x, 0}) * tag.world_from_tag.rotation(),
                                    {x, y, HeightAt(x, y)});
    }
    return MakeEstimatorSetup(
        MakeSetUp(course.camera, course.cam_from_body, TagMap(course.map.family(), tags)), options);
  }
};

TEST_F(TracksOnAnUnevenMat, BridgeAGapOfTags) {
  Points points;
  Scatter scatter;
  while (points.size() < 1000) {
    const double x = scatter(0, 3.5), y = scatter(0, 2.8);
    points.emplace_back(x, y, HeightAt(x, y));
  }
  const Pose above = MakePose(ExpSo3({0, 0, 0}), {1.6, 1.3, 1.3});
  const EstimatorSetup setup = Setup(Options(true));
  ASSERT_GT(setup.planes.size(), 20u) << "nearly every tag a plane of its own";
  const Runs without = Fly(Setup(Options(false)), above, points, 1);
  const Runs with = Fly(setup, above, points, 1);
  ExpectBetterInGap(with.batch, without.batch);
  ExpectBetterInGap(with.window, without.window);
  for (const double nees : {with.batch.nees, with.window.nees}) EXPECT_LT(nees, 18);
  EXPECT_THAT(with.warnings, IsEmpty());
}

}  // namespace
}  // namespace tagtwist::internal::track_planes_test

#include "frontend/simulation/spline_trajectory.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <random>
#include <sstream>

#include "frontend/simulation/named_flights.h"
#include "frontend/types/camera.h"
#include "frontend/types/so3.h"

namespace tagtwist::internal::spline_trajectory_test {
namespace {

using ::testing::HasSubstr;

TruthSample Sample(double t_s, const Eigen::Vector3d& position, const Eigen::Vector3d& theta) {
  TruthSample out;
  out.t_ns = std::llround(1e9 * t_s);
  out.world_from_body = MakePose(ExpSo3(theta), position);
  return out;
}

// A tumbling path at uneven stamps, with a gap of half a second.
std::vector<TruthSample> TumblingPoses() {
  std::mt19937_64 rng(1);
  std::vector<TruthSample> out;
  for (double t = 0; t < 5;
       t += 0.003 + 0.017 * static_cast<double>(rng() >> 11) / 9007199254740992.0) {
    if (t > 2.0 && t < 2.5) continue;
    out.push_back(Sample(t, {std::sin(t), std::cos(2 * t), 0.3 * t},
                         {2.0 * t, std::sin(3 * t), 0.5 * std::cos(t)}));
    if (out.size() % 3 == 0) out.back().world_from_body.params.head<4>() *= -1;  // same rotation
  }
  return out;
}

SplineTrajectory MustFit(const std::vector<TruthSample>& poses) {
  auto fit = SplineTrajectory::Fit(poses, {});
  EXPECT_TRUE(fit) << fit.error().message;
  return *fit;
}

TEST(SplineTrajectory, TwistIsTheDerivativeOfThePose) {
  const SplineTrajectory path = MustFit(TumblingPoses());
  constexpr int64_t kStepNs = 100000;
  for (int64_t t = path.first_ns() + kStepNs; t + kStepNs < path.last_ns(); t += 37000000) {
    const StateVector d = Difference(path.At(t + kStepNs), path.At(t - kStepNs));
    const BodyState state = path.At(t);
    EXPECT_LT((d.segment<3>(3) / (2e-9 * kStepNs) - state.twist.v_world).norm(), 1e-6) << t;
    EXPECT_LT((d.head<3>() / (2e-9 * kStepNs) - state.twist.omega_body).norm(), 2e-5) << t;
    EXPECT_LT((d.segment<3>(6) / (2e-9 * kStepNs) - path.AccelerationAt(t)).norm(), 1e-5) << t;
    EXPECT_GT(state.twist.omega_body.norm(), 0.1);
  }
}

TEST(SplineTrajectory, FollowsUnevenPosesAndBridgesAGap) {
  const std::vector<TruthSample> poses = TumblingPoses();
  const SplineTrajectory path = MustFit(poses);
  for (const TruthSample& pose : poses) {
    const StateVector d = Difference(path.At(pose.t_ns), BodyState{pose.world_from_body, Twist()});
    EXPECT_LT(d.head<3>().norm(), 2e-3) << pose.t_ns;
    EXPECT_LT(d.segment<3>(3).norm(), 1e-3) << pose.t_ns;
  }
  const BodyState middle = path.At(2250000000);
  EXPECT_LT(
      (middle.world_from_body.translation() - Eigen::Vector3d(std::sin(2.25), std::cos(4.5), 0.675))
          .norm(),
      0.02);
}

TEST(SplineTrajectory, SparsePosesAreInterpolated) {
  std::vector<TruthSample> poses;
  for (int i = 0; i < 8; ++i)
    poses.push_back(Sample(0.7 * i, {std::sin(i), 0, 1}, {0, 0, 0.1 * i}));
  const SplineTrajectory path = MustFit(poses);
  for (const TruthSample& pose : poses) {
    EXPECT_LT(
        (path.At(pose.t_ns).world_from_body.translation() - pose.world_from_body.translation())
            .norm(),
        1e-4);
  }
  const SplineTrajectory two = MustFit({poses[0], poses[1]});
  EXPECT_TRUE(two.Covers(350000000));
  EXPECT_FALSE(two.Covers(700000001));
  EXPECT_TRUE(two.At(350000000).world_from_body.params.allFinite());
}

TEST(SplineTrajectory, RefusesWhatIsNoPath) {
  const TruthSample a = Sample(0, {0, 0, 1}, {0, 0, 0}), b = Sample(1, {0, 0, 1}, {0, 0, 0});
  TruthSample bad = b;
  bad.world_from_body.params[5] = NAN;
  EXPECT_THAT(SplineTrajectory::Fit({a}, {}).error().message, HasSubstr("at least 2 poses"));
  EXPECT_THAT(SplineTrajectory::Fit({b, a}, {}).error().message, HasSubstr("growing stamps"));
  EXPECT_THAT(SplineTrajectory::Fit({a, bad}, {}).error().message, HasSubstr("finite"));
  SplineOptions options;
  options.knot_spacing_s = NAN;
  EXPECT_THAT(SplineTrajectory::Fit({a, b}, options).error().message, HasSubstr("knot_spacing_s"));
}

Pose CourseCamFromBody() {
  const double c = std::sqrt(0.5);
  Eigen::Matrix3d rotation;
  rotation << c, -c, 0, -c, -c, 0, 0, 0, -1;
  return MakePose(Eigen::Quaterniond(rotation), {-0.04, 0, -0.03});
}

TEST(NamedFlights, StayOverTheMatInViewOfItsTags) {
  const TagMap map = MakeTagMap({});
  const Camera camera;
  for (const std::string& name : FlightNames()) {
    const auto poses = MakeFlight(name, map, {});
    ASSERT_TRUE(poses) << poses.error().message;
    double largest_lean = 0;
    for (const TruthSample& pose : *poses) {
      const Pose cam_from_world = CourseCamFromBody() * Inverse(pose.world_from_body);
      int seen = 0;
      for (const Tag& tag : map.tags()) {
        Eigen::Vector2d pixel;
        seen += camera.Project(cam_from_world * tag.world_from_tag.translation().eval(), &pixel) &&
                camera.Contains(pixel, 20);
      }
      EXPECT_GE(seen, 3) << name << " at " << ToSeconds(pose.t_ns);
      const double up = (pose.world_from_body.rotation() * Eigen::Vector3d::UnitZ()).z();
      largest_lean = std::max(largest_lean, std::acos(std::min(1.0, up)) * 180 / M_PI);
    }
    const double least = name == "agile" ? 25 : 0, most = name == "agile" ? 35 : 15;
    EXPECT_GE(largest_lean, least) << name;
    EXPECT_LE(largest_lean, name == "straight" ? 1e-6 : most) << name;
  }
}

TEST(NamedFlights, BeginAndEndAtRest) {
  for (const std::string& name : FlightNames()) {
    const SplineTrajectory path = MustFit(*MakeFlight(name, MakeTagMap({}), {}));
    for (const int64_t t : {path.first_ns(), path.last_ns()}) {
      EXPECT_LT(path.At(t).twist.v_world.norm(), 0.02) << name;
      EXPECT_LT(path.At(t).twist.omega_body.norm(), 0.02) << name;
    }
    EXPECT_GT(path.At(path.last_ns() / 2).twist.v_world.norm(), 0.005) << name;
  }
}

TEST(NamedFlights, RefusesUnknownNameAndBadOptions) {
  EXPECT_THAT(MakeFlight("loop", MakeTagMap({}), {}).error().message,
              HasSubstr("figure8, hover, circle, agile, straight, got 'loop'"));
  FlightOptions options;
  options.duration_s = -1;
  EXPECT_THAT(MakeFlight("hover", MakeTagMap({}), options).error().message,
              HasSubstr("duration_s"));
}

// t,x,y,z,roll,pitch,yaw,qw,qx,qy,qz,... of the Vicon files.
std::vector<TruthSample> ReadVicon(std::ifstream& file) {
  std::vector<TruthSample> out;
  std::string line;
  std::getline(file, line);
  while (std::getline(file, line)) {
    std::istringstream cells(line);
    std::vector<double> v;
    for (std::string cell; std::getline(cells, cell, ',');) v.push_back(std::stod(cell));
    TruthSample sample;
    sample.t_ns = std::llround(1e9 * v.at(0));
    sample.world_from_body =
        MakePose(Eigen::Quaterniond(v.at(7), v.at(8), v.at(9), v.at(10)), {v[1], v[2], v[3]});
    sample.twist = Twist{{v.at(11), v.at(12), v.at(13)}, {v.at(14), v.at(15), v.at(16)}};
    out.push_back(sample);
  }
  return out;
}

TEST(RealDataSpline, FollowsTheViconPaths) {
  for (const char* name : {"vicon_dataset1.csv", "vicon_dataset4.csv"}) {
    std::ifstream file(std::string(TAGTWIST_REAL_DATA_DIR) + "/course/" + name);
    if (!file) GTEST_SKIP() << "no real data beside the project";
    const std::vector<TruthSample> poses = ReadVicon(file);
    const SplineTrajectory path = MustFit(poses);
    StateVector squares = StateVector::Zero();
    for (const TruthSample& pose : poses) {
      const BodyState measured{pose.world_from_body, *pose.twist};
      squares += Difference(path.At(pose.t_ns), measured).cwiseAbs2();
    }
    const StateVector rms = (squares / static_cast<double>(poses.size())).cwiseSqrt();
    std::printf("%s: rotation %.5f rad, position %.5f m, velocity %.4f m/s, rate %.4f rad/s\n",
                name, rms.head<3>().norm(), rms.segment<3>(3).norm(), rms.segment<3>(6).norm(),
                rms.tail<3>().norm());
    EXPECT_LT(rms.segment<3>(3).norm(), 0.004) << name;
    EXPECT_LT(rms.head<3>().norm(), 0.01) << name;
    EXPECT_LT(rms.segment<3>(6).norm(), 0.1) << name;
  }
}

}  // namespace
}  // namespace tagtwist::internal::spline_trajectory_test

#include "frontend/flow/optical_flow.h"

#include <gtest/gtest.h>

#include "tests/support/flights/tag_scene.h"

namespace tagtwist::internal::optical_flow_test {
namespace {

CameraTwist MakeTwist(double vx, double vy, double vz, double wx, double wy, double wz) {
  CameraTwist twist;
  twist << vx, vy, vz, wx, wy, wz;
  return twist;
}

// A fixed point's normalised coordinates after the camera moved for dt.
Eigen::Vector2d After(const Eigen::Vector3d& point_in_cam, const CameraTwist& twist, double dt_s) {
  const Eigen::Quaterniond now_from_later = ExpSo3(dt_s * twist.tail<3>());
  return (now_from_later.conjugate() * (point_in_cam - dt_s * twist.head<3>())).hnormalized();
}

std::vector<FlowPoint> FlowOf(const CameraTwist& truth, int n) {
  std::mt19937_64 engine(5);
  std::uniform_real_distribution<double> side(-0.6, 0.6), depth(0.8, 2.5);
  std::vector<FlowPoint> flow;
  for (int i = 0; i < n; ++i) {
    FlowPoint point{{side(engine), side(engine)}, {}, depth(engine)};
    point.flow = InteractionMatrix(point.point, point.depth_m) * truth;
    flow.push_back(point);
  }
  return flow;
}

TEST(InteractionMatrix, IsTheDerivativeOfTheProjection) {
  for (const Eigen::Vector2d& point :
       {Eigen::Vector2d(0, 0), Eigen::Vector2d(0.4, -0.3), Eigen::Vector2d(-0.6, 0.5)}) {
    const double depth_m = 1.7, dt_s = 1e-6;
    const Eigen::Vector3d point_in_cam = depth_m * point.homogeneous();
    for (Eigen::Index axis = 0; axis < 6; ++axis) {
      const CameraTwist twist = CameraTwist::Unit(axis);
      const Eigen::Vector2d numeric =
          (After(point_in_cam, twist, dt_s) - After(point_in_cam, twist, -dt_s)) / (2 * dt_s);
      const Eigen::Vector2d analytic = InteractionMatrix(point, depth_m) * twist;
      EXPECT_LT((numeric - analytic).norm(), 1e-9)
          << "axis " << axis << " at " << point.transpose();
    }
  }
}

TEST(DepthOnPlane, MeetsAnyPlaneInFrontOfTheCamera) {
  const Pose cam_from_plane = MakePose(ExpSo3({2.6, 0.4, 0.1}), {0.3, -0.1, 1.8});
  for (const Eigen::Vector3d& point_in_plane :
       {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(0.5, -0.7, 0), Eigen::Vector3d(-1, 0.4, 0)}) {
    const Eigen::Vector3d point_in_cam = cam_from_plane * point_in_plane;
    const auto depth_m = DepthOnPlane(point_in_cam.hnormalized(), cam_from_plane);
    ASSERT_TRUE(depth_m);
    EXPECT_NEAR(*depth_m, point_in_cam.z(), 1e-12);
  }
}

TEST(DepthOnPlane, HasNoAnswerBehindOrAlongThePlane) {
  const Pose behind = MakePose(Eigen::Quaterniond::Identity(), {0, 0, -2});
  EXPECT_FALSE(DepthOnPlane({0.1, 0.1}, behind));
  const Pose edge_on = MakePose(ExpSo3({M_PI / 2, 0, 0}), {0, 1, 0});  // the plane y = 1
  EXPECT_FALSE(DepthOnPlane({0.3, 0}, edge_on));
  EXPECT_FALSE(DepthOnPlane({0.3, -0.2}, edge_on)) << "a ray away from it";
  EXPECT_NEAR(*DepthOnPlane({0.3, 0.5}, edge_on), 2, 1e-12);
}

TEST(SolveTwist, IsExactAndRefusesTooLittle) {
  const CameraTwist truth = MakeTwist(0.3, -0.5, 0.2, 0.4, -0.1, 0.8);
  const auto flow = FlowOf(truth, 12);
  EXPECT_LT((*SolveTwist(flow) - truth).norm(), 1e-11);
  EXPECT_LT((*SolveTwist(flow, {0, 5, 9}) - truth).norm(), 1e-9) << "three points are enough";
  EXPECT_FALSE(SolveTwist(flow, {0, 5}));
  EXPECT_FALSE(SolveTwist(flow, {3, 3, 3})) << "one point three times leaves motions open";
}

// Eq. 11 against numeric differentiation of a body that moves and turns.
TEST(BodyTwist, MatchesAMovingRigidBody) {
  const auto world_from_body = [](double t) {
    return MakePose(ExpSo3({0.3 * std::sin(2 * t), 0.2 * t, 0.5 * t * t}),
                    {std::sin(t), 0.4 * t * t, 1.5 + 0.1 * std::cos(3 * t)});
  };
  const Pose cam_from_body = CourseCamFromBody();
  const double t = 0.8, h = 1e-5;
  const auto numeric = [&](const Pose& body_from_x) {  // v in W and omega in x, of a frame x
    const Pose before = world_from_body(t - h) * body_from_x;
    const Pose after = world_from_body(t + h) * body_from_x;
    return Twist{(after.translation() - before.translation()) / (2 * h),
                 LogSo3(before.rotation().conjugate() * after.rotation()) / (2 * h)};
  };
  const Twist cam = numeric(Inverse(cam_from_body)), body = numeric(Pose());
  const Pose world_from_cam = world_from_body(t) * Inverse(cam_from_body);
  CameraTwist twist_of_cam_in_cam;
  twist_of_cam_in_cam << world_from_cam.rotation().conjugate() * cam.v_world, cam.omega_body;
  const Twist got = BodyTwist(twist_of_cam_in_cam, cam_from_body, world_from_body(t));
  EXPECT_LT((got.v_world - body.v_world).norm(), 1e-8);
  EXPECT_LT((got.omega_body - body.omega_body).norm(), 1e-8);
  EXPECT_GT((cam.v_world - body.v_world).norm(), 0.01) << "the lever arm must matter";
}

// Likewise before a camera that stands, which seems to move about the body.
TEST(TwistSeenFrom, MatchesAMovingRigidBody) {
  const auto world_from_body = [](double t) {
    return MakePose(ExpSo3({0.3 * std::sin(2 * t), 0.2 * t, 0.5 * t * t}),
                    {std::sin(t), 0.4 * t * t, 0.1 * std::cos(3 * t)});
  };
  const Pose cam_from_world = MakePose(ExpSo3({3, 0.2, -0.1}), {0.2, -0.3, 2});
  const auto body_from_cam = [&](double t) { return Inverse(cam_from_world * world_from_body(t)); };
  const auto twist_of = [](const Pose& before, const Pose& after, double dt) {
    return Twist{(after.translation() - before.translation()) / dt,
                 LogSo3(before.rotation().conjugate() * after.rotation()) / dt};
  };
  const double t = 0.8, h = 1e-5;
  const Twist body = twist_of(world_from_body(t - h), world_from_body(t + h), 2 * h);
  const Twist cam = twist_of(body_from_cam(t - h), body_from_cam(t + h), 2 * h);
  CameraTwist twist_of_cam_in_cam;
  twist_of_cam_in_cam << body_from_cam(t).rotation().conjugate() * cam.v_world, cam.omega_body;
  const Twist got = TwistSeenFrom(twist_of_cam_in_cam, cam_from_world, world_from_body(t));
  EXPECT_LT((got.v_world - body.v_world).norm(), 1e-7);
  EXPECT_LT((got.omega_body - body.omega_body).norm(), 1e-7);
}

TEST(LowPass, StepResponseIsGeometric) {
  const Twist step{{1, -2, 3}, {0.5, 0, -1}};
  Twist filtered;
  for (int n = 1; n <= 20; ++n) {
    filtered = LowPass(filtered, step, 0.8);
    const double share = 1 - std::pow(0.8, n);
    EXPECT_LT((filtered.v_world - share * step.v_world).norm(), 1e-12);
    EXPECT_LT((filtered.omega_body - share * step.omega_body).norm(), 1e-12);
  }
}

}  // namespace
}  // namespace tagtwist::internal::optical_flow_test

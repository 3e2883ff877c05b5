#include "tests/support/flights/exact_model.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <random>

#include "estimator/online/config.h"
#include "frontend/types/so3.h"

namespace tagtwist::internal {
namespace {

class Draw {
 public:
  explicit Draw(unsigned seed) : rng_(seed) {}
  Eigen::Vector3d Normal3() { return {normal_(rng_), normal_(rng_), normal_(rng_)}; }
  Eigen::Vector2d Normal2() { return {normal_(rng_), normal_(rng_)}; }

 private:
  std::mt19937_64 rng_;
  std::normal_distribution<double> normal_;
};

struct FullState {
  BodyState body;
  Acceleration acceleration;
};

// Three axes' noise over dt_s: columns for the quantity and its two derivatives.
Eigen::Matrix3d DrawNoise(const MotionPrior& prior, double dt_s, Draw* draw) {
  Eigen::Matrix3d normal;
  for (int i = 0; i < 3; ++i) normal.col(i) = draw->Normal3();
  const Eigen::Matrix3d root = ProcessCovariance(WithDensity(prior, 1.0), dt_s).llt().matrixL();
  Eigen::Matrix3d noise = std::sqrt(prior.psd) * normal * root.transpose();
  if (prior.on == WhiteNoiseOn::kAcceleration) noise.col(2).setZero();  // idle
  return noise;
}

// One step of the motion model; the angular part in the local variable of MotionResidual.
FullState Step(const FullState& state, double dt_s, const ExactModelOptions& options, Draw* draw) {
  const Twist& twist = state.body.twist;
  const Pose& pose = state.body.world_from_body;
  Eigen::Matrix3d linear, angular;
  linear << pose.translation(), twist.v_world, state.acceleration.a_world;
  angular << Eigen::Vector3d::Zero(), twist.omega_body, state.acceleration.alpha_body;
  linear = (linear * Transition(options.linear.on, dt_s).transpose() +
            DrawNoise(options.linear, dt_s, draw))
               .eval();
  angular = (angular * Transition(options.angular.on, dt_s).transpose() +
             DrawNoise(options.angular, dt_s, draw))
                .eval();
  const Eigen::Vector3d phi = angular.col(0);
  const Eigen::Matrix3d jr = RightJacobianSo3(phi);
  FullState next;
  next.body.world_from_body = MakePose(pose.rotation() * ExpSo3(phi), linear.col(0));
  next.body.twist = {linear.col(1), jr * angular.col(1)};
  next.acceleration = {linear.col(2), jr * angular.col(2)};
  return next;
}

std::vector<TagDetection> SeeTags(const EstimatorSetup& setup, const BodyState& state,
                                  const ExactModelOptions& options, Draw* draw) {
  std::vector<TagDetection> tags;
  const Pose cam_from_world = setup.cam_from_body * Inverse(state.world_from_body);
  for (const Tag& tag : setup.map.tags()) {
    if (static_cast<int>(tags.size()) == options.max_tags) break;
    TagDetection seen;
    seen.id = tag.id;
    bool visible = true;
    for (size_t c = 0; c < 4; ++c) {
      visible = visible &&
                setup.camera.Project(cam_from_world * setup.map.CornersInWorld(tag.id)[c],
                                     &seen.corners[c]) &&
                setup.camera.Contains(seen.corners[c], 2);
    }
    if (!visible) continue;
    for (auto& corner : seen.corners) corner += options.corner_sigma_px * draw->Normal2();
    tags.push_back(seen);
  }
  return tags;
}

}  // namespace

SetUp CourseSetUp() { return DefaultConfig().set_up; }

EstimatorSetup CourseSetup(const EstimatorOptions& options) {
  return MakeEstimatorSetup(CourseSetUp(), options);
}

SetUp SetUpOf(const EstimatorSetup& setup) {
  SetUp out = MakeSetUp(setup.camera, setup.cam_from_body, setup.map);
  out.rig.front().covariance = setup.camera_covariance;
  out.rig.front().line_time_s = setup.line_time_s;
  out.rig.mounted_on = setup.mounted_on;
  out.rig.cameras.insert(out.rig.cameras.end(), setup.others.begin(), setup.others.end());
  return out;
}

ExactModelOptions ModelUnder(WhiteNoiseOn prior, unsigned seed) {
  ExactModelOptions options;
  options.random_seed = seed;
  if (prior == WhiteNoiseOn::kAcceleration) options.linear = options.angular = {prior, 0.05};
  return options;
}

EstimatorOptions GivenNoise(const ExactModelOptions& model) {
  EstimatorOptions options;
  options.corner_sigma_px = model.corner_sigma_px;
  options.track_sigma_px = 0.3;
  const auto give = [](const MotionPrior& prior, std::optional<double>* accel,
                       std::optional<double>* jerk) {
    *(prior.on == WhiteNoiseOn::kJerk ? jerk : accel) = prior.psd;
  };
  give(model.linear, &options.accel_psd, &options.jerk_psd);
  give(model.angular, &options.angular_accel_psd, &options.angular_jerk_psd);
  return options;
}

std::string PriorName(const testing::TestParamInfo<WhiteNoiseOn>& prior) {
  return prior.param == WhiteNoiseOn::kJerk ? "Jerk" : "Acceleration";
}

ExactModelFlight DrawFlight(const ExactModelOptions& options) {
  return DrawFlight(options, CourseSetup(), MakePose(ExpSo3({0, 0, 0}), {1.6, 1.3, 1.3}));
}

ExactModelFlight DrawFlight(const ExactModelOptions& options, const EstimatorSetup& setup,
                            const Pose& world_from_body) {
  Draw draw(options.random_seed);
  FullState state;
  state.body.world_from_body = MakePose(world_from_body.rotation() * ExpSo3(0.1 * draw.Normal3()),
                                        world_from_body.translation());
  state.body.twist = {0.3 * draw.Normal3(), 0.2 * draw.Normal3()};
  ExactModelFlight flight;
  const double dt_s = 1 / options.rate_hz;
  for (int i = 0; i < options.frames; ++i) {
    if (i > 0) state = Step(state, dt_s, options, &draw);
    FrameMeasurements m;
    m.t_ns = static_cast<int64_t>(std::llround(1e9 * dt_s * i));
    m.tags = SeeTags(setup, state.body, options, &draw);
    flight.truth.push_back(state.body);
    flight.measurements.push_back(std::move(m));
  }
  return flight;
}

}  // namespace tagtwist::internal

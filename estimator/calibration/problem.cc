#include "estimator/calibration/problem.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "residuals/corner_whitener.h"
#include "residuals/lens.h"
#include "residuals/tag_calibration_residual.h"

namespace tagtwist::internal {
namespace {

// Appends the six entries of a pose.
void AddPose(CalibrationGroup group, const std::string& name, const std::string& kind,
             double rotation_sigma, double position_sigma, std::vector<CalibrationParameter>* out) {
  for (const char* axis : {" tilt x", " tilt y", " tilt z"}) {
    out->push_back({group, name + axis, kind + axis, "rad", rotation_sigma});
  }
  for (const char* axis : {" x", " y", " z"}) {
    out->push_back({group, name + axis, kind + axis, "m", position_sigma});
  }
}

double DistortionSigma(const std::string& name, const CalibrationOptions& options) {
  if (name == "k1" || name == "k2") return options.radial_sigma;
  if (name == "p1" || name == "p2") return options.tangential_sigma;
  return options.higher_distortion_sigma;
}

}  // namespace

CalibrationLayout LayoutOf(const CalibrationState& state) {
  return {LensSize(state.camera), static_cast<int>(state.tags.size())};
}

CalibrationState Retract(const CalibrationState& state, const Eigen::VectorXd& step) {
  const CalibrationLayout layout = LayoutOf(state);
  CalibrationState out = state;
  out.camera = PerturbLens(state.camera, step.head(layout.lens_size));
  out.log_scale += step(layout.scale());
  out.line_time_s += step(layout.line_time());
  out.cam_from_body = Retract(state.cam_from_body, step.segment<6>(layout.mount()));
  out.truth_from_world = Retract(state.truth_from_world, step.segment<6>(layout.world()));
  out.time_offset_s += step(layout.clock());
  for (int i = 0; i < layout.n_tags; ++i) {
    Tag& tag = out.tags[static_cast<size_t>(i)];
    tag.world_from_tag = Retract(tag.world_from_tag, step.segment<6>(layout.tag(i)));
    tag.bend_m += step(layout.bend(i));
  }
  return out;
}

Eigen::VectorXd Difference(const CalibrationState& state, const CalibrationState& reference) {
  const CalibrationLayout layout = LayoutOf(state);
  Eigen::VectorXd out(layout.size());
  out.head(layout.lens_size) = LensDifference(state.camera, reference.camera);
  out(layout.scale()) = state.log_scale - reference.log_scale;
  out(layout.line_time()) = state.line_time_s - reference.line_time_s;
  out.segment<6>(layout.mount()) = Difference(state.cam_from_body, reference.cam_from_body);
  out.segment<6>(layout.world()) = Difference(state.truth_from_world, reference.truth_from_world);
  out(layout.clock()) = state.time_offset_s - reference.time_offset_s;
  for (int i = 0; i < layout.n_tags; ++i) {
    const auto k = static_cast<size_t>(i);
    out.segment<6>(layout.tag(i)) =
        Difference(state.tags[k].world_from_tag, reference.tags[k].world_from_tag);
    out(layout.bend(i)) = state.tags[k].bend_m - reference.tags[k].bend_m;
  }
  return out;
}

const char* ToString(CalibrationGroup group) {
  switch (group) {
    case CalibrationGroup::kPinhole:
      return "focal length and principal point";
    case CalibrationGroup::kDistortion:
      return "distortion";
    case CalibrationGroup::kShutter:
      return "line time of the rolling shutter";
    case CalibrationGroup::kMap:
      return "tag poses and print scale";
    case CalibrationGroup::kBend:
      return "bends of the tags";
    case CalibrationGroup::kTruth:
      break;
  }
  return "mount, world and clock against the ground truth";
}

std::vector<CalibrationParameter> ParametersOf(const CalibrationState& state,
                                               const CalibrationOptions& options) {
  using Group = CalibrationGroup;
  const double centre_px = options.principal_point_sigma * state.camera.width;
  std::vector<CalibrationParameter> out;
  const auto add = [&out](Group group, const std::string& name, const char* unit, double sigma) {
    out.push_back({group, name, name, unit, sigma});
  };
  add(Group::kPinhole, "focal length", "", options.focal_sigma);
  add(Group::kPinhole, "aspect fy/fx", "", options.aspect_sigma);
  add(Group::kPinhole, "principal point x", "px", centre_px);
  add(Group::kPinhole, "principal point y", "px", centre_px);
  for (const std::string& name : DistortionNames(state.camera)) {
    add(Group::kDistortion, name, "", DistortionSigma(name, options));
  }
  add(Group::kMap, "print scale", "", options.print_scale_sigma);
  add(Group::kShutter, "line time", "s", options.line_time_sigma_s);
  AddPose(Group::kTruth, "mount", "mount", options.mount_rotation_sigma_rad,
          options.mount_position_sigma_m, &out);
  AddPose(Group::kTruth, "world", "world", options.world_rotation_sigma_rad,
          options.world_position_sigma_m, &out);
  add(Group::kTruth, "clock", "s", options.time_offset_sigma_s);
  for (const Tag& tag : state.tags) {
    const std::string name = "tag " + std::to_string(tag.id);
    AddPose(Group::kMap, name, "tags", options.tag_rotation_sigma_rad, options.tag_position_sigma_m,
            &out);
    out.push_back(
        {Group::kBend, name + " bend", "tags bend", "m", options.tag_bend_sigma * tag.size_m});
  }
  return out;
}

void SetCornerNoise(double sigma_px, std::vector<CalibrationFrame>* frames) {
  using Matrix8 = Eigen::Matrix<double, 8, 8>;
  for (CalibrationFrame& frame : *frames) {
    std::vector<CalibrationView> views = frame.views();
    for (CalibrationView& view : views) {
      Matrix8 covariance = sigma_px * sigma_px * Matrix8::Identity();
      if (view.covariance) covariance += *view.covariance;
      view.whitener = CornerWhitener(covariance);
    }
    frame.shared_views = std::make_shared<const std::vector<CalibrationView>>(std::move(views));
  }
}

void UpdateMotion(std::vector<CalibrationFrame>* frames) {
  constexpr double kFarthestS = 0.2;
  for (size_t i = 0; i < frames->size(); ++i) {
    const auto near = [&](size_t k) {
      return std::abs(ToSeconds((*frames)[k].t_ns - (*frames)[i].t_ns)) <= kFarthestS;
    };
    const CalibrationFrame& first = (*frames)[i > 0 && near(i - 1) ? i - 1 : i];
    const CalibrationFrame& last = (*frames)[i + 1 < frames->size() && near(i + 1) ? i + 1 : i];
    (*frames)[i].motion.reset();
    if (first.t_ns == last.t_ns) continue;
    const double dt_s = ToSeconds(last.t_ns - first.t_ns);
    (*frames)[i].motion = TwistBetween(first.world_from_cam, last.world_from_cam, dt_s);
  }
}

CalibrationState OnlyFree(const CalibrationState& state, const CalibrationProblem& problem) {
  Eigen::VectorXd difference = Difference(state, problem.prior);
  difference = (problem.prior_sigmas.array() > 0).select(difference, 0.0);
  return Retract(problem.prior, difference);
}

CalibrationProblem Restrict(const CalibrationProblem& problem,
                            const std::vector<CalibrationParameter>& parameters,
                            const std::vector<CalibrationGroup>& groups,
                            const std::vector<bool>& use) {
  CalibrationProblem out;
  out.prior = problem.prior;
  out.truth = problem.truth;
  out.max_truth_gap_s = problem.max_truth_gap_s;
  out.robust_scale = problem.robust_scale;
  out.prior_sigmas = problem.prior_sigmas;
  for (size_t i = 0; i < parameters.size(); ++i) {
    const bool free = std::count(groups.begin(), groups.end(), parameters[i].group) > 0;
    if (!free) out.prior_sigmas(static_cast<Eigen::Index>(i)) = 0;
  }
  for (size_t i = 0; i < problem.frames.size(); ++i) {
    if (use.empty() || use[i]) out.frames.push_back(problem.frames[i]);
  }
  return out;
}

}  // namespace tagtwist::internal

#include "estimator/report/files/summary_json.h"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "estimator/evaluation/error_bound.h"
#include "estimator/graph/noise_model.h"
#include "estimator/result/imu_left_out.h"
#include "estimator/result/run_tally.h"
#include "frontend/base/statistics/quantile.h"

namespace tagtwist::internal {
namespace {

using Json = nlohmann::ordered_json;

Json QuantileJson(const std::vector<double>& values, double fraction) {
  return values.empty() ? Json(nullptr) : Json(Quantile(values, fraction));
}

Json RelativeJson(const RelativeError& e) {
  return {{"translation_rmse_m", e.translation_m.rmse},
          {"rotation_rmse_rad", e.rotation_rad.rmse},
          {"pairs", e.translation_m.count}};
}

Json NeesJson(const MeanNees& nees) {
  return {{"mean", nees.mean},
          {"dof", nees.dof},
          {"per_dof", nees.per_dof()},
          {"band95", {nees.band_low, nees.band_high}}};
}

// Of times, and of all of them where these are some.
Json WithMost(const std::vector<double>& ms, const TimeTotal* all) {
  Json out = PercentilesJson(ms);
  if (all != nullptr && !ms.empty()) out["max"] = all->max_ms;
  return out;
}

Json TimingJson(const RunFacts& facts) {
  const StageTimes& times = facts.times;
  const auto json = [&](const std::vector<double>& ms, TimeTotal StageTotals::*stage) {
    return WithMost(ms, facts.totals ? &(*facts.totals.*stage) : nullptr);
  };
  return {{"detect", json(times.detect_ms, &StageTotals::detect)},
          {"track", json(times.track_ms, &StageTotals::track)},
          {"seed", json(times.seed_ms, &StageTotals::seed)},
          {"optimise", json(times.optimise_ms, &StageTotals::optimise)},
          {"frame", json(times.frame_ms, &StageTotals::frame)}};
}

const char* Name(WhiteNoiseOn on) {
  return on == WhiteNoiseOn::kJerk ? "white_noise_on_jerk" : "white_noise_on_acceleration";
}

// Density of the white noise on acceleration that makes twists change as much from frame to frame
// as the estimated ones do: sum |change|^2 / (3 sum dt). Of v_world and of omega_body.
std::array<double, 2> AccelerationDensities(const FrameTally& frames) {
  const double time_s = frames.changes_s;
  if (!(time_s > 0)) return {0, 0};
  return {frames.velocity_changes / (3 * time_s), frames.rate_changes / (3 * time_s)};
}

Json NoiseJson(const NoiseModel& noise, const FrameTally& frames) {
  const bool linear_jerk = noise.linear.on == WhiteNoiseOn::kJerk;
  const bool angular_jerk = noise.angular.on == WhiteNoiseOn::kJerk;
  const auto [accel, angular_accel] = AccelerationDensities(frames);
  return {{"corner_sigma_px", noise.corner_sigma_px},
          {"track_sigma_px", noise.track_sigma_px},
          {"accel_psd", linear_jerk ? accel : noise.linear.psd},
          {"angular_accel_psd", angular_jerk ? angular_accel : noise.angular.psd},
          {"source", NameOf(noise.source)},
          {"linear_prior", Name(noise.linear.on)},
          {"angular_prior", Name(noise.angular.on)},
          {"jerk_psd", linear_jerk ? Json(noise.linear.psd) : Json(nullptr)},
          {"angular_jerk_psd", angular_jerk ? Json(noise.angular.psd) : Json(nullptr)},
          {"shake_s", noise.linear.shake_s},
          {"angular_shake_s", noise.angular.shake_s}};
}

// Standard deviations.
Json SystematicJson(const SystematicShare& s) {
  Json out = {{"field_sigma_px", s.field_sigma_px},
              {"tag_sigma_m", s.tag_sigma_m},
              {"bias_sigma_px", s.bias_sigma_px},
              {"position_sigma_m", s.position_m},
              {"rotation_sigma_rad", s.rotation_rad},
              {"common_position_sigma_m", s.common_position_m},
              {"common_rotation_sigma_rad", s.common_rotation_rad}};
  if (s.mount_sigma_m == 0 && s.mount_sigma_rad == 0) return out;
  out["mount_sigma_m"] = s.mount_sigma_m;
  out["mount_sigma_rad"] = s.mount_sigma_rad;
  return out;
}

Json VectorJson(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

Json ImuJson(const ImuResult& imu) {
  return {{"gravity_world_mps2", VectorJson(imu.gravity_world_mps2)},
          {"gravity_sigma_rad", imu.gravity_sigma_rad},
          {"time_offset_s", imu.time_offset_s},
          {"time_offset_sigma_s", imu.time_offset_sigma_s},
          {"body_from_imu_rad", VectorJson(imu.mount_rad)},
          {"body_from_imu_sigma_rad", VectorJson(imu.mount_sigma_rad)},
          {"imu_in_body_m", VectorJson(imu.imu_in_body_m)},
          {"imu_in_body_sigma_m", VectorJson(imu.imu_in_body_sigma_m)},
          {"gyro_bias_radps", VectorJson(imu.gyro_bias_radps)},
          {"gyro_bias_sigma_radps", VectorJson(imu.gyro_bias_sigma_radps)},
          {"accel_bias_mps2", VectorJson(imu.accel_bias_mps2)},
          {"accel_bias_sigma_mps2", VectorJson(imu.accel_bias_sigma_mps2)},
          {"gyroscope_noise_density", imu.gyro_noise},
          {"accelerometer_noise_density", imu.accel_noise},
          {"intervals", imu.intervals}};
}

Json CamerasJson(const std::vector<CameraShare>& cameras) {
  Json out = Json::array();
  for (const CameraShare& camera : cameras) {
    out.push_back({{"name", camera.name},
                   {"frames", camera.frames},
                   {"tags", camera.tags},
                   {"tags_used", camera.used},
                   {"reprojection_rms_px", camera.rms_px}});
  }
  return out;
}

Json BoundJson(const ErrorBound& bound, bool with_twist) {
  const auto figure = [&](double x) { return bound.frames > 0 ? Json(x) : Json(nullptr); };
  Json out = {{"frames", bound.frames},
              {"position_m", figure(bound.position_m)},
              {"rotation_rad", figure(bound.rotation_rad)}};
  if (!with_twist) return out;
  out["velocity_mps"] = figure(bound.velocity_mps);
  out["rate_radps"] = figure(bound.rate_radps);
  return out;
}

Json BoundsJson(const Estimate& e, const std::vector<ComparisonRow>& rows) {
  const EstimateBounds bounds = BoundsOf(e);
  Json out = {{"frame", BoundJson(bounds.frame, false)},
              {"smoothed", BoundJson(bounds.smoothed, true)}};
  for (const ComparisonRow& row : rows) {
    if (row.key != bounds.key || !row.accuracy || !row.accuracy->rmse_over_bound) continue;
    const BoundRatio& ratio = *row.accuracy->rmse_over_bound;
    Json& over = out["rmse_over_bound"];
    over = {{"position", ratio.position}, {"rotation", ratio.rotation}};
    if (ratio.velocity) over["velocity"] = *ratio.velocity;
    if (ratio.rate) over["rate"] = *ratio.rate;
  }
  return out;
}

Json DeadlineJson(const FrameTally& frames, const RunFacts& facts) {
  const auto late = std::count_if(facts.times.frame_ms.begin(), facts.times.frame_ms.end(),
                                  [&](double frame_ms) { return frame_ms > *facts.deadline_ms; });
  return {{"deadline_ms", *facts.deadline_ms},
          {"frames_hurried", frames.count(FrameStatus::kHurried)},
          {"frames_late", facts.totals ? facts.totals->frames_late : static_cast<size_t>(late)}};
}

void AddInputs(const RunFacts& facts, Json* out) {
  Json& inputs = (*out)["inputs"] = Json::array();
  for (const InputFile& file : facts.inputs) {
    inputs.push_back(
        {{"flag", file.flag}, {"file", file.path}, {"bytes", file.bytes}, {"sha256", file.sha256}});
  }
  (*out)["taken"] = facts.taken;
  (*out)["configuration"] = facts.configuration;
}

}  // namespace

std::string FormatJson(const Json& json) {
  return json.dump(2, ' ', /*ensure_ascii=*/false, Json::error_handler_t::replace) + "\n";
}

Json PercentilesJson(const std::vector<double>& values) {
  return {{"p50", QuantileJson(values, 0.5)},
          {"p99", QuantileJson(values, 0.99)},
          {"max", QuantileJson(values, 1.0)}};
}

Json AccuracyJson(const Accuracy& a) {
  Json out = Json::object();
  out["position_rmse_m"] = a.position_m.rmse;
  out["rotation_rmse_rad"] = a.rotation_rad.rmse;
  if (a.velocity_mps) out["velocity_rmse_mps"] = a.velocity_mps->rmse;
  if (a.rate_radps) out["rate_rmse_radps"] = a.rate_radps->rmse;
  if (a.nees) out["nees_mean"] = a.nees->mean;
  out["matched"] = a.matched;
  out["position_median_m"] = a.position_m.median;
  out["rotation_median_rad"] = a.rotation_rad.median;
  if (a.rpe_frames) out["rpe_frames"] = RelativeJson(*a.rpe_frames);
  if (a.rpe_time) out["rpe_time"] = RelativeJson(*a.rpe_time);
  if (a.rpe_distance) out["rpe_distance"] = RelativeJson(*a.rpe_distance);
  if (a.nees) out["nees"] = NeesJson(*a.nees);
  if (a.nees_pose) out["nees_pose"] = NeesJson(*a.nees_pose);
  if (a.nees_twist) out["nees_twist"] = NeesJson(*a.nees_twist);
  return out;
}

Json AlignmentJson(const Alignment& a) {
  const auto pose = [](const Pose& p) {
    const double sign = p.params(3) < 0 ? -1 : 1;
    Json out = Json::array();
    for (const double x : p.translation()) out.push_back(x);
    for (int i = 0; i < 4; ++i) out.push_back(sign * p.params(i));
    return out;
  };
  Json out = {{"truth_from_world", pose(a.truth_from_world)},
              {"body_from_marker", pose(a.body_from_marker)},
              {"time_offset_s", a.time_offset_s}};
  if (!a.sigmas.Any()) return out;
  const auto sigmas = [](const Eigen::Matrix<double, 6, 1>& of_pose) {
    Json list = Json::array();
    for (const int i : {3, 4, 5, 0, 1, 2}) list.push_back(of_pose(i));
    return list;
  };
  out["sigmas"] = {{"truth_from_world", sigmas(a.sigmas.truth_from_world)},
                   {"body_from_marker", sigmas(a.sigmas.body_from_marker)},
                   {"time_offset_s", a.sigmas.time_offset_s}};
  return out;
}

Json FailureJson(const std::string& error, const std::vector<std::string>& warnings,
                 const RunFacts& facts) {
  Json out = Json::object();
  out["status"] = "failed";
  out["error"] = error;
  out["warnings"] = warnings;
  out["dataset"] = facts.dataset;
  AddInputs(facts, &out);
  out["version"] = TAGTWIST_VERSION;
  return out;
}

Json SummaryJson(const Estimate& estimate, const std::vector<ComparisonRow>& rows,
                 const RunFacts& facts) {
  Json out = Json::object();
  out["mode"] = ToString(estimate.mode);
  const FrameTally all = TallyOf(estimate, facts.all.get()).frames;
  out["frames"] = all.frames;
  out["frames_estimated"] = all.with_state;
  if (facts.all) out["frames_kept"] = estimate.frames.size();
  out["reprojection_px"] = {{"median", QuantileJson(estimate.reprojection_px, 0.5)},
                            {"p95", QuantileJson(estimate.reprojection_px, 0.95)}};
  out["noise"] = NoiseJson(estimate.noise, all);
  if (estimate.mode == EstimateMode::kBatch) {
    out["systematic"] = SystematicJson(estimate.systematic);
  }
  if (estimate.imu) out["imu"] = ImuJson(*estimate.imu);
  const auto left_out = WhyImuIsLeftOut(estimate.warnings);
  if (!estimate.imu && left_out) out["imu"] = {{"left_out", *left_out}};
  if (!estimate.cameras.empty()) out["cameras"] = CamerasJson(estimate.cameras);
  out["timing_ms"] = TimingJson(facts);
  if (facts.deadline_ms) out["deadline"] = DeadlineJson(all, facts);
  if (facts.live) {
    const TimeTotal* const latency = facts.live->total ? &*facts.live->total : nullptr;
    out["live"] = {{"frames_dropped", facts.live->frames_dropped},
                   {"latency_ms", WithMost(facts.live->latency_ms, latency)}};
  }
  out["wall_s"] = facts.wall_s;
  out["peak_rss_mib"] = facts.peak_rss_mib;
  out["bound"] = BoundsJson(estimate, rows);
  for (const ComparisonRow& row : rows) {
    if (row.key == ComparisonKey::kNone || !row.accuracy) continue;
    if (!out.contains("accuracy")) out["accuracy"] = Json::object();
    out["accuracy"][NameOf(row.key)] = AccuracyJson(*row.accuracy);
  }
  out["dataset"] = facts.dataset;
  AddInputs(facts, &out);
  out["status"] = "done";
  out["warnings"] = estimate.warnings;
  out["version"] = TAGTWIST_VERSION;
  return out;
}

}  // namespace tagtwist::internal

#include "estimator/summary_json.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "estimator/quantile.h"

namespace tagtwist {
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

Json NeesJson(const Nees& nees) {
  return {{"mean", nees.mean},
          {"dof", nees.dof},
          {"per_dof", nees.per_dof()},
          {"band95", {nees.band_low, nees.band_high}}};
}

Json TimingJson(const StageTimes& times) {
  return {{"detect", PercentilesJson(times.detect_ms)},
          {"track", PercentilesJson(times.track_ms)},
          {"seed", PercentilesJson(times.seed_ms)},
          {"optimise", PercentilesJson(times.optimise_ms)},
          {"frame", PercentilesJson(times.frame_ms)}};
}

Json NoiseJson(const NoiseModel& noise) {
  return {{"corner_sigma_px", noise.corner_sigma_px},
          {"track_sigma_px", noise.track_sigma_px},
          {"accel_psd", noise.accel_psd},
          {"angular_accel_psd", noise.angular_accel_psd},
          {"source", noise.source}};
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
  Json out;
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
  return {{"truth_from_world", pose(a.truth_from_world)},
          {"body_from_marker", pose(a.body_from_marker)},
          {"time_offset_s", a.time_offset_s}};
}

Json SummaryJson(const Estimate& estimate, const std::vector<ComparisonRow>& rows,
                 const RunFacts& facts) {
  Json out;
  out["mode"] = estimate.mode;
  out["frames"] = estimate.frames.size();
  out["frames_estimated"] =
      std::count_if(estimate.frames.begin(), estimate.frames.end(),
                    [](const FrameEstimate& f) { return f.status != FrameStatus::kNoFix; });
  out["reprojection_px"] = {{"median", QuantileJson(estimate.reprojection_px, 0.5)},
                            {"p95", QuantileJson(estimate.reprojection_px, 0.95)}};
  out["noise"] = NoiseJson(estimate.noise);
  out["timing_ms"] = TimingJson(estimate.times);
  out["wall_s"] = facts.wall_s;
  out["peak_rss_mib"] = facts.peak_rss_mib;
  for (const ComparisonRow& row : rows) {
    if (!row.key.empty() && row.accuracy) out["accuracy"][row.key] = AccuracyJson(*row.accuracy);
  }
  out["dataset"] = facts.dataset;
  out["warnings"] = estimate.warnings;
  out["version"] = TAGTWIST_VERSION;
  return out;
}

}  // namespace tagtwist

#include "estimator/report/files/calibration_json.h"

#include <nlohmann/json.hpp>

#include "estimator/report/files/calibration_text.h"

namespace tagtwist::internal {
namespace {

using Json = nlohmann::ordered_json;

Json ParametersJson(const Calibration& c) {
  Json out = Json::object();
  for (int i = 0; i < LayoutOf(c.given).tag(0); ++i) {
    if (!(c.prior_sigmas(i) > 0)) continue;
    const CalibrationParameter& parameter = c.parameters[static_cast<size_t>(i)];
    out[parameter.name] = {{"change", c.change(i)},
                           {"sigma", c.sigma(i)},
                           {"prior_sigma", parameter.prior_sigma},
                           {"unit", parameter.unit},
                           {"applied", static_cast<bool>(c.applied[static_cast<size_t>(i)])}};
  }
  return out;
}

Json HeldOutJson(const HeldOutJudgement& judgement, bool has_truth) {
  Json out = {{"corner_sigma_px", judgement.corner_sigma_px}};
  if (!has_truth) return out;
  out["truth_median_m"] = judgement.truth_median_m;
  out["truth_median_rad"] = judgement.truth_median_rad;
  return out;
}

Json UnseenJson(const Calibration& c) {
  Json out = Json::array();
  for (const UnseenDirection& direction : c.unseen) {
    Json parts = Json::object();
    for (const auto& part : direction.parts) parts[part.kind] = part.share;
    out.push_back({{"variance_over_prior", direction.variance_ratio}, {"parts", parts}});
  }
  return out;
}

}  // namespace

Json CalibrationJson(const Calibration& c) {
  Json out = {{"frames", c.frames},
              {"tags_seen", c.views},
              {"corner_sigma_px", c.noise.corner_sigma_px},
              {"held_out",
               {{"given", HeldOutJson(c.validation.given, c.has_truth)},
                {"refined", HeldOutJson(c.validation.refined, c.has_truth)}}},
              {"parameters", ParametersJson(c)}};
  const ScaleAndFocal both = CompareScaleAndFocal(c);
  out["map_scale"] = {{"change", both.scale},
                      {"sigma", both.scale_sigma},
                      {"correlation_with_focal_length", both.correlation}};
  out["tags"] = Json::array();
  for (const TagMove& move : TagMoves(c)) {
    out["tags"].push_back({{"id", move.id},
                           {"up_m", move.up_m},
                           {"up_sigma_m", move.up_sigma_m},
                           {"within_m", move.within_m},
                           {"turn_rad", move.turn_rad}});
  }
  out["bends"] = Json::array();
  for (const TagBend& bend : TagBends(c)) {
    out["bends"].push_back({{"id", bend.id}, {"bend_m", bend.bend_m}, {"sigma_m", bend.sigma_m}});
  }
  out["unseen"] = UnseenJson(c);
  out["text"] = CalibrationText(c);
  return out;
}

}  // namespace tagtwist::internal

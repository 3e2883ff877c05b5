#include "estimator/report/result_writer.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <utility>

#include "estimator/calibration/calibration.h"
#include "estimator/calibration/gyro_alignment.h"
#include "estimator/calibration/mapping.h"
#include "estimator/report/files/calibration_config.h"
#include "estimator/report/files/calibration_json.h"
#include "estimator/report/files/mapping_text.h"
#include "estimator/report/files/rig/rig_config.h"
#include "estimator/report/files/states_csv.h"
#include "estimator/report/files/summary_json.h"
#include "estimator/report/findings/findings.h"
#include "estimator/report/findings/verdict.h"
#include "estimator/report/html/report.h"
#include "estimator/report/result_set.h"
#include "frontend/base/files/file_set.h"
#include "frontend/io/trajectories/trajectory_file.h"

namespace tagtwist {

using namespace internal;
namespace {

Pose WithPositiveW(const Pose& pose) {
  Pose out = pose;
  if (out.params(3) < 0) out.params.head<4>() *= -1;
  return out;
}

std::string FormatSeriesTum(const PoseSeries& series) {
  std::vector<TruthSample> samples;
  samples.reserve(series.size());
  for (const PoseSample& s : series)
    samples.push_back({s.t_ns, WithPositiveW(s.world_from_body), {}});
  return FormatTum(samples);
}

PoseSeries ToSeries(const std::vector<TruthSample>& truth) {
  PoseSeries out;
  for (const TruthSample& s : truth) out.push_back({s.t_ns, s.world_from_body, {}, {}});
  return out;
}

nlohmann::ordered_json MappingJson(const Mapping& mapping) {
  nlohmann::ordered_json out = nlohmann::ordered_json::object();
  out["corner_sigma_px"] = mapping.corner_sigma_px;
  out["added"] = nlohmann::ordered_json::array();
  for (size_t i = 0; i < mapping.map.tags().size(); ++i) {
    if (mapping.covariances[i].isZero(0)) continue;
    const Eigen::Vector3d variances = mapping.covariances[i].diagonal().tail<3>();
    out["added"].push_back(
        {{"id", mapping.map.tags()[i].id}, {"position_sigma_m", std::sqrt(variances.sum())}});
  }
  out["not_placed"] = mapping.left_out;
  return out;
}

nlohmann::ordered_json GyroJson(const GyroAlignment& gyro) {
  const auto vector = [](const Eigen::Vector3d& v) { return std::vector{v.x(), v.y(), v.z()}; };
  const Eigen::Matrix<double, 7, 1> sigmas = gyro.covariance.diagonal().cwiseSqrt();
  const Eigen::Quaterniond& q = gyro.cam_from_imu;
  return {{"cam_from_imu_xyzw", {q.x(), q.y(), q.z(), q.w()}},
          {"rotation_sigma_rad", vector(sigmas.head<3>())},
          {"bias_radps", vector(gyro.bias_radps)},
          {"bias_sigma_radps", vector(sigmas.segment<3>(3))},
          {"time_offset_s", gyro.time_offset_s},
          {"time_offset_sigma_s", sigmas(6)},
          {"turn_sigma_rad", gyro.turn_sigma_rad},
          {"turns", gyro.turns}};
}

nlohmann::ordered_json BodyJson(const std::string& name, const Estimate& estimate) {
  size_t with_state = 0, with_tags = 0;
  for (const FrameEstimate& frame : estimate.frames) {
    if (frame.status != FrameStatus::kNoFix) ++with_state;
    if (frame.n_tags > 0) ++with_tags;
  }
  return {{"name", name},
          {"frames", estimate.frames.size()},
          {"frames_with_state", with_state},
          {"frames_with_tags", with_tags},
          {"warnings", estimate.warnings}};
}

nlohmann::ordered_json BodiesJson(const Estimate& first, const ResultContext& context) {
  auto out = nlohmann::ordered_json::array();
  if (!context.body.empty()) out.push_back(BodyJson(context.body, first));
  for (const BodyEstimate& other : context.of_others) {
    out.push_back(BodyJson(other.name, other.estimate));
  }
  return out;
}

std::string SummaryText(const Estimate& estimate, const ResultContext& context) {
  nlohmann::ordered_json json = SummaryJson(estimate, context.rows, context.facts);
  const std::vector<Finding> findings =
      Findings(estimate, context.facts, context.map, context.truth);
  json["verdict"] = VerdictText(estimate, findings, context.truth, context.facts.doubts);
  json["findings"] = nlohmann::ordered_json::array();
  for (const Finding& finding : findings) {
    json["findings"].push_back({{"fact", finding.fact}, {"advice", finding.advice}});
  }
  if (!context.movable_tags.empty()) json["movable_tags"] = context.movable_tags;
  if (!context.body.empty() || !context.of_others.empty())
    json["bodies"] = BodiesJson(estimate, context);
  if (context.mapping) json["mapping"] = MappingJson(*context.mapping);
  if (context.calibration) json["calibration"] = CalibrationJson(*context.calibration);
  if (context.rig) json["calibration"] = RigJson(*context.rig);
  if (context.gyro) json["gyro"] = GyroJson(*context.gyro);
  return FormatJson(json);
}

// Name and text of each file; texts are made one at a time.
using Writer = std::pair<std::string, std::string (*)(const Estimate&, const ResultContext&)>;

void AddCalibration(const ResultContext& context, std::vector<Writer>* out) {
  if (context.calibration) {
    out->push_back({"calibration.yaml", [](const Estimate&, const ResultContext& c) {
                      return FormatCalibrationConfig(*c.calibration, c.options_text);
                    }});
  }
  if (context.rig) {
    out->push_back({"calibration.yaml", [](const Estimate&, const ResultContext& c) {
                      return FormatRigConfig(*c.rig, c.options_text);
                    }});
  }
}

std::vector<Writer> Writers(const Estimate& estimate, const ResultContext& context) {
  std::vector<Writer> out = {
      {"closed_form.tum",
       [](const Estimate& e, const ResultContext&) {
         return FormatSeriesTum(ClosedFormSeries(e.frames, ClosedFormVariant::kLowPass));
       }},
      {"optimised.tum",
       [](const Estimate& e, const ResultContext&) {
         return FormatSeriesTum(EstimatedSeries(e.frames));
       }},
      {"states.csv",
       [](const Estimate& e, const ResultContext&) { return FormatStatesCsv(e.frames); }},
      {"summary.json", [](const Estimate& e, const ResultContext& c) { return SummaryText(e, c); }},
      {"report.html", [](const Estimate& e, const ResultContext& c) {
         return FormatReport(e,
                             {c.facts, c.map, c.truth, c.rows, c.calibration, c.rig, c.map_moves});
       }}};
  if (!estimate.lagged.empty()) {
    out.push_back({"states_lagged.csv", [](const Estimate& e, const ResultContext&) {
                     return FormatStatesCsv(e.lagged);
                   }});
  }
  if (context.write_covariance) {
    out.push_back({"covariance.csv", [](const Estimate& e, const ResultContext&) {
                     return FormatCovarianceCsv(e.frames);
                   }});
  }
  if (context.write_covariance && !estimate.lagged.empty()) {
    out.push_back({"covariance_lagged.csv", [](const Estimate& e, const ResultContext&) {
                     return FormatCovarianceCsv(e.lagged);
                   }});
  }
  if (!context.detections_csv.empty()) {
    out.push_back({"detections.csv",
                   [](const Estimate&, const ResultContext& c) { return c.detections_csv; }});
  }
  AddCalibration(context, &out);
  if (context.mapping) {
    out.push_back({"map.yaml", [](const Estimate&, const ResultContext& c) {
                     return MappingText(*c.mapping);
                   }});
  }
  if (!context.truth.empty()) {
    out.push_back({"ground_truth.tum", [](const Estimate&, const ResultContext& c) {
                     return FormatSeriesTum(ToSeries(c.truth));
                   }});
  }
  if (!context.truth.empty() && std::all_of(context.truth.begin(), context.truth.end(),
                                            [](const TruthSample& s) { return s.twist; })) {
    out.push_back({"ground_truth_states.csv", [](const Estimate&, const ResultContext& c) {
                     return FormatGroundTruthCsv(c.truth);
                   }});
  }
  return out;
}

// A body's own files, of several.
Status AddBody(const std::string& body, const Estimate& estimate, const ResultContext& context,
               FileSet* set) {
  const bool lagged = !estimate.lagged.empty();
  for (const std::string& name : BodyFileNames(body, {lagged, context.write_covariance})) {
    const bool of_lagged = name.find("_lagged") != std::string::npos;
    const std::vector<FrameEstimate>& frames = of_lagged ? estimate.lagged : estimate.frames;
    std::string text;
    if (name.rfind("optimised", 0) == 0) text = FormatSeriesTum(EstimatedSeries(frames));
    if (name.rfind("states", 0) == 0) text = FormatStatesCsv(frames);
    if (name.rfind("covariance", 0) == 0) text = FormatCovarianceCsv(frames);
    if (const auto added = set->Add(name, text); !added) return added;
  }
  return Ok();
}

}  // namespace

Status WriteResults(const std::string& folder, const Estimate& estimate,
                    const ResultContext& context) {
  auto set = FileSet::Begin(folder);
  if (!set) return set.error();
  for (const auto& [name, text] : Writers(estimate, context)) {
    if (auto added = (*set)->Add(name, text(estimate, context)); !added) return added;
  }
  if (!context.body.empty()) {
    if (auto added = AddBody(context.body, estimate, context, set->get()); !added) return added;
  }
  for (const BodyEstimate& other : context.of_others) {
    if (auto added = AddBody(other.name, other.estimate, context, set->get()); !added) return added;
  }
  std::vector<std::string> obsolete = ResultNames();
  for (std::string& name : OlderBodyFiles(folder)) obsolete.push_back(std::move(name));
  for (const std::string& name : context.kept) {
    obsolete.erase(std::remove(obsolete.begin(), obsolete.end(), name), obsolete.end());
  }
  return (*set)->Commit(obsolete);
}

Status WriteFailure(const std::string& folder, const std::string& error,
                    const std::vector<std::string>& warnings, const RunFacts& facts) {
  std::error_code unknown;
  const bool has_results =
      std::filesystem::exists(std::filesystem::path(folder) / "states.csv", unknown);
  if (has_results) return Ok();
  auto set = FileSet::Begin(folder);
  if (!set) return set.error();
  const std::string text = FormatJson(FailureJson(error, warnings, facts));
  if (auto added = (*set)->Add("summary.json", text); !added) return added;
  return (*set)->Commit();
}

}  // namespace tagtwist

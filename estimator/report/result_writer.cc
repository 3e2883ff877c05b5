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
#include "estimator/report/files/summary_json.h"
#include "estimator/report/findings/findings.h"
#include "estimator/report/findings/verdict.h"
#include "estimator/report/html/report.h"
#include "estimator/report/result_rows.h"
#include "estimator/report/result_set.h"
#include "estimator/result/run_tally.h"
#include "frontend/base/files/file_set.h"
#include "frontend/io/trajectories/trajectory_file.h"

namespace tagtwist {

using namespace internal;
namespace {

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

nlohmann::ordered_json BodyJson(const std::string& name, const Estimate& estimate,
                                const RunTally* tally) {
  const FrameTally all = TallyOf(estimate, tally).frames;
  return {{"name", name},
          {"frames", all.frames},
          {"frames_with_state", all.with_state},
          {"frames_with_tags", all.with_tags},
          {"warnings", estimate.warnings}};
}

nlohmann::ordered_json BodiesJson(const Estimate& first, const ResultContext& context) {
  auto out = nlohmann::ordered_json::array();
  const RunFacts& facts = context.facts;
  if (!context.body.empty()) out.push_back(BodyJson(context.body, first, facts.all.get()));
  for (size_t i = 0; i < context.of_others.size(); ++i) {
    const auto& [name, estimate] = context.of_others[i];
    const bool is_long = i < facts.all_of_others.size();
    out.push_back(BodyJson(name, estimate, is_long ? facts.all_of_others[i].get() : nullptr));
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

// The truth, piece by piece.
Status AddTruth(const std::vector<TruthSample>& truth, FileSet* set) {
  if (truth.empty()) return Ok();
  Status written = set->Append("ground_truth.tum", FormatTum({}));
  for (const TruthSample& sample : truth) {
    if (!written) return written;
    Pose pose = sample.world_from_body;
    if (pose.params(3) < 0) pose.params.head<4>() *= -1;
    written = set->Append("ground_truth.tum", FormatTumLine(sample.t_ns, pose));
  }
  const bool has_twists = std::all_of(truth.begin(), truth.end(),
                                      [](const TruthSample& s) { return s.twist.has_value(); });
  if (!written || !has_twists) return written;
  return set->Add("ground_truth_states.csv", FormatGroundTruthCsv(truth));
}

// Files of the run as a whole.
Status AddSummaries(const Estimate& estimate, const ResultContext& context, FileSet* set) {
  Status written = set->Add("summary.json", SummaryText(estimate, context));
  if (written) {
    written =
        set->Add("report.html",
                 FormatReport(estimate, {context.facts, context.map, context.truth, context.rows,
                                         context.calibration, context.rig, context.map_moves}));
  }
  if (written && context.calibration) {
    written = set->Add("calibration.yaml",
                       FormatCalibrationConfig(*context.calibration, context.options_text));
  }
  if (written && context.rig) {
    written = set->Add("calibration.yaml", FormatRigConfig(*context.rig, context.options_text));
  }
  if (written && context.mapping) written = set->Add("map.yaml", MappingText(*context.mapping));
  return written ? AddTruth(context.truth, set) : written;
}

std::vector<std::string> BodiesOf(const ResultContext& context) {
  std::vector<std::string> out = {context.body};
  for (const BodyEstimate& other : context.of_others) out.push_back(other.name);
  return out;
}

}  // namespace

Status WriteResults(const std::string& folder, std::unique_ptr<ResultRows> rows,
                    const Estimate& estimate, const ResultContext& context) {
  FileSet& set = rows->set();
  if (!rows->status()) return rows->status();
  if (auto added = AddSummaries(estimate, context, &set); !added) return added;
  std::vector<std::string> obsolete = ResultNames();
  for (std::string& name : OlderBodyFiles(folder)) obsolete.push_back(std::move(name));
  for (const std::string& name : context.kept) {
    obsolete.erase(std::remove(obsolete.begin(), obsolete.end(), name), obsolete.end());
  }
  return set.Commit(obsolete);
}

Status WriteResults(const std::string& folder, const Estimate& estimate,
                    const ResultContext& context) {
  auto rows = ResultRows::Begin(folder, {context.write_covariance, false, BodiesOf(context)});
  if (!rows) return rows.error();
  if (auto added = AddStates(estimate, context.of_others, rows->get()); !added) return added;
  return WriteResults(folder, std::move(*rows), estimate, context);
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

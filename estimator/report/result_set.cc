#include "estimator/report/result_set.h"

#include <filesystem>
#include <nlohmann/json.hpp>

#include "estimator/report/files/read_json.h"
#include "frontend/base/files/plain_name.h"

namespace tagtwist::internal {

const std::vector<std::string>& ResultNames() {
  static const std::vector<std::string> names = {
      "closed_form.tum",  "optimised.tum",           "states.csv",       "states_lagged.csv",
      "ground_truth.tum", "ground_truth_states.csv", "summary.json",     "report.html",
      "covariance.csv",   "covariance_lagged.csv",   "calibration.yaml", "map.yaml",
      "detections.csv"};
  return names;
}

std::vector<std::string> BodyFileNames(const std::string& body, const ResultKinds& kinds) {
  std::vector<std::string> out = {"optimised_" + body + ".tum", "states_" + body + ".csv"};
  if (kinds.window) out.push_back("states_" + body + "_lagged.csv");
  if (kinds.covariance) out.push_back("covariance_" + body + ".csv");
  if (kinds.covariance && kinds.window) out.push_back("covariance_" + body + "_lagged.csv");
  return out;
}

std::vector<std::string> OlderBodyFiles(const std::string& folder) {
  const std::filesystem::path path = std::filesystem::path(folder) / "summary.json";
  std::error_code none;
  if (!std::filesystem::is_regular_file(path, none)) return {};
  const auto summary = ReadJsonObject(path.string());
  if (!summary) return {};
  const auto bodies = summary->find("bodies");
  if (bodies == summary->end() || !bodies->is_array()) return {};
  std::vector<std::string> out;
  for (const auto& body : *bodies) {
    const auto name = body.is_object() ? body.find("name") : body.end();
    if (name == body.end() || !name->is_string()) continue;
    if (!IsPlainName(name->get<std::string>())) continue;
    const auto files = BodyFileNames(name->get<std::string>(), {true, true});
    out.insert(out.end(), files.begin(), files.end());
  }
  return out;
}

OutputSet ResultSet(const std::string& folder, const ResultKinds& kinds) {
  OutputSet out{folder, {}, ResultNames(), {"states.csv", "summary.json", "report.html"}};
  for (std::string& name : OlderBodyFiles(folder)) out.obsolete.push_back(std::move(name));
  for (const std::string& name : ResultNames()) {
    const bool lagged = name.find("_lagged") != std::string::npos;
    const bool covariance = name.rfind("covariance", 0) == 0;
    if ((lagged && !kinds.window) || (covariance && !kinds.covariance)) continue;
    if (name == "calibration.yaml" && !kinds.calibration) continue;
    if (name == "map.yaml" && !kinds.mapping) continue;
    if (name == "detections.csv" && !kinds.detections) continue;
    out.written.push_back(name);
  }
  for (const std::string& body : kinds.bodies) {
    const auto names = BodyFileNames(body, kinds);
    out.written.insert(out.written.end(), names.begin(), names.end());
  }
  return out;
}

}  // namespace tagtwist::internal

#include "estimator/report/result_set.h"

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

OutputSet ResultSet(const std::string& folder, const ResultKinds& kinds) {
  OutputSet out{folder, {}, ResultNames(), {"states.csv", "summary.json", "report.html"}};
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

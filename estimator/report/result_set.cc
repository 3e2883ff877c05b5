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
  return out;
}

}  // namespace tagtwist::internal

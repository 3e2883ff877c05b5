#include "frontend/io/trajectories/trajectory_rows.h"

#include "frontend/io/tables/text_grid.h"
#include "frontend/io/trajectories/truth_parts.h"

namespace tagtwist {

using namespace internal;
Status TrajectoryRows::Add(int line, int64_t t_ns, const std::vector<double>& xyz_qxyzw) {
  ++rows_;
  last_was_taken_ = false;
  const std::vector<double>& n = xyz_qxyzw;
  if (Eigen::Vector4d(n[3], n[4], n[5], n[6]).norm() == 0) {
    --rows_;
    PassOver(line, "with a quaternion of zero");
    return Ok();
  }
  const auto pose = PoseFromNumbers(n);
  if (!pose) return Error{Place(path_, line) + pose.error().message};
  if (!out_.samples.empty()) {
    if (t_ns <= out_.samples.back().t_ns) {
      --rows_;
      PassOver(line, t_ns == out_.samples.back().t_ns ? "whose stamp repeats"
                                                      : "whose stamp runs backwards");
      return Ok();
    }
  }
  out_.samples.push_back({t_ns, *pose, std::nullopt});
  last_was_taken_ = true;
  return Ok();
}

void TrajectoryRows::PassOver(int line, const std::string& why) {
  ++rows_;
  last_was_taken_ = false;
  for (PassedOver& group : passed_over_) {
    if (group.why != why) continue;
    ++group.count;
    return;
  }
  passed_over_.push_back({1, line, why});
}

Result<TrajectoryFile> TrajectoryRows::Finish(const std::string& form) {
  if (rows_ == 0) return Error{path_ + ": no rows"};
  for (const PassedOver& group : passed_over_) {
    const std::string text = std::to_string(group.count) + " of " + std::to_string(rows_) +
                             " rows " + group.why + " (the first on line " +
                             std::to_string(group.first_line) + ")";
    if (out_.samples.size() < 2 || 2 * out_.samples.size() < rows_) {
      return Error{Place(path_, group.first_line) + text + ": too few are left"};
    }
    out_.notes.push_back(path_ + ": passed over " + text);
  }
  out_.form = form;
  return std::move(out_);
}

}  // namespace tagtwist

#include "estimator/report/result_rows.h"

#include <utility>

#include "estimator/report/files/states_csv.h"
#include "frontend/io/tables/detections_csv.h"
#include "frontend/io/trajectories/trajectory_file.h"

namespace tagtwist::internal {
namespace {

std::string TumRow(int64_t t_ns, Pose pose) {
  if (pose.params(3) < 0) pose.params.head<4>() *= -1;
  return FormatTumLine(t_ns, pose);
}

std::string TableName(const char* table, const std::string& suffix, bool lagged,
                      const char* ending) {
  return table + suffix + (lagged ? "_lagged" : "") + ending;
}

}  // namespace

Result<std::unique_ptr<ResultRows>> ResultRows::Begin(const std::string& folder,
                                                      const RowsAsked& asked) {
  auto set = FileSet::Begin(folder);
  if (!set) return set.error();
  std::unique_ptr<ResultRows> out(new ResultRows(std::move(*set), asked));
  if (!out->status_) return out->status_.error();
  return out;
}

ResultRows::ResultRows(std::unique_ptr<FileSet> set, RowsAsked asked)
    : set_(std::move(set)), asked_(std::move(asked)), has_lagged_(asked_.bodies.size(), false) {
  Write("closed_form.tum", FormatTum({}));
  WriteHeaders("", false);
  if (asked_.detections) Write("detections.csv", MeasuredTagsHeader());
  for (const std::string& body : asked_.bodies) {
    if (!body.empty()) WriteHeaders("_" + body, false);
  }
}

void ResultRows::Write(const std::string& name, const std::string& text) {
  if (status_) status_ = set_->Append(name, text);
}

void ResultRows::WriteHeaders(const std::string& suffix, bool lagged) {
  if (!lagged) Write(TableName("optimised", suffix, false, ".tum"), FormatTum({}));
  Write(TableName("states", suffix, lagged, ".csv"), StatesCsvHeader());
  if (asked_.covariance) {
    Write(TableName("covariance", suffix, lagged, ".csv"), FormatCovarianceCsv({}));
  }
}

void ResultRows::WriteRows(const std::string& suffix, bool lagged, const FrameEstimate& frame) {
  Write(TableName("states", suffix, lagged, ".csv"), FormatStatesRow(frame));
  if (frame.status == FrameStatus::kNoFix) return;
  if (!lagged) {
    Write(TableName("optimised", suffix, false, ".tum"),
          TumRow(frame.t_ns, frame.state.world_from_body));
  }
  if (asked_.covariance) {
    Write(TableName("covariance", suffix, lagged, ".csv"), FormatCovarianceRow(frame));
  }
}

Status ResultRows::AddMeasured(const FrameMeasurements& frame) {
  if (asked_.detections) {
    Write("detections.csv", FormatMeasuredTags(frame.t_ns, frame.tags, frame.doubled_ids));
  }
  return status_;
}

Status ResultRows::Add(size_t body, const FrameEstimate& frame) {
  if (body == 0) {
    WriteRows("", false, frame);
    const auto& pose = frame.closed_form.world_from_body;
    if (pose) Write("closed_form.tum", TumRow(frame.t_ns, *pose));
  }
  if (const std::string& name = asked_.bodies[body]; !name.empty()) {
    WriteRows("_" + name, false, frame);
  }
  return status_;
}

Status ResultRows::AddLagged(size_t body, const FrameEstimate& frame) {
  std::vector<std::string> suffixes;
  if (body == 0) suffixes.emplace_back();
  if (const std::string& name = asked_.bodies[body]; !name.empty()) suffixes.push_back("_" + name);
  for (const std::string& suffix : suffixes) {
    if (!has_lagged_[body]) WriteHeaders(suffix, true);
    WriteRows(suffix, true, frame);
  }
  has_lagged_[body] = true;
  return status_;
}

Status AddStates(const Estimate& estimate, const std::vector<BodyEstimate>& of_others,
                 ResultRows* rows) {
  for (size_t body = 0; body <= of_others.size(); ++body) {
    const Estimate& its = body == 0 ? estimate : of_others[body - 1].estimate;
    for (const FrameEstimate& frame : its.frames) {
      if (const Status added = rows->Add(body, frame); !added) return added;
    }
    for (const FrameEstimate& frame : its.lagged) {
      if (const Status added = rows->AddLagged(body, frame); !added) return added;
    }
  }
  return Ok();
}

}  // namespace tagtwist::internal

#include <algorithm>
#include <cmath>

#include "estimator/report/files/states_csv.h"
#include "frontend/io/tables/csv.h"

namespace tagtwist::internal {
namespace {

using Columns = std::vector<size_t>;

const std::vector<std::string> kPose = {"x", "y", "z", "qx", "qy", "qz", "qw"};
const std::vector<std::string> kTwist = {"vx_world", "vy_world", "vz_world",
                                         "wx_body",  "wy_body",  "wz_body"};
const std::vector<std::string> kSigma = {"rx", "ry", "rz", "x",  "y",  "z",
                                         "vx", "vy", "vz", "wx", "wy", "wz"};

// Column numbers; empty when one of them is missing.
Columns FindColumns(const CsvTable& table, const std::string& prefix,
                    const std::vector<std::string>& names) {
  Columns out;
  for (const std::string& name : names) {
    const auto column = table.FindColumn(prefix + name);
    if (!column) return {};
    out.push_back(*column);
  }
  return out;
}

bool AllEmpty(const CsvTable& table, size_t row, const Columns& columns) {
  return std::all_of(columns.begin(), columns.end(),
                     [&](size_t c) { return table.Cell(row, c).empty(); });
}

// nullopt where all cells are empty (or there are no such columns).
Result<std::optional<Pose>> ReadPose(const CsvTable& table, size_t row, const Columns& columns) {
  if (AllEmpty(table, row, columns)) return std::optional<Pose>();
  const auto v = table.Numbers(row, columns);
  if (!v) return v.error();
  const Eigen::Quaterniond q((*v)[6], (*v)[3], (*v)[4], (*v)[5]);
  if (!(std::abs(q.norm() - 1) < 1e-2)) {
    return table.ErrorAt(row, "expected a unit quaternion, got norm " + std::to_string(q.norm()));
  }
  return std::optional<Pose>(MakePose(q, {(*v)[0], (*v)[1], (*v)[2]}));
}

Result<std::optional<Twist>> ReadTwist(const CsvTable& table, size_t row, const Columns& columns) {
  if (AllEmpty(table, row, columns)) return std::optional<Twist>();
  const auto v = table.Numbers(row, columns);
  if (!v) return v.error();
  return std::optional<Twist>(Twist{{(*v)[0], (*v)[1], (*v)[2]}, {(*v)[3], (*v)[4], (*v)[5]}});
}

// Adds the row's pose and twist to the series, if there is a pose.
Result<bool> AppendSample(const CsvTable& table, size_t row, int64_t t_ns,
                          const Columns& pose_columns, const Columns& twist_columns,
                          PoseSeries* out) {
  const auto pose = ReadPose(table, row, pose_columns);
  if (!pose) return pose.error();
  const auto twist = ReadTwist(table, row, twist_columns);
  if (!twist) return twist.error();
  if (*pose) out->push_back({t_ns, **pose, *twist, std::nullopt});
  return pose->has_value();
}

Status AppendRow(const CsvTable& table, size_t row, const std::array<Columns, 5>& columns,
                 size_t t_column, int64_t* last_ns, StatesFile* out) {
  const auto t_ns = table.Seconds(row, t_column);
  if (!t_ns) return t_ns.error();
  if (row > 0 && *t_ns <= *last_ns) {
    return table.ErrorAt(row, "t: expected stamps that grow, got one that does not");
  }
  *last_ns = *t_ns;
  const auto state = AppendSample(table, row, *t_ns, columns[0], columns[1], &out->states);
  if (!state) return state.error();
  const auto closed = AppendSample(table, row, *t_ns, columns[2], columns[3], &out->closed_form);
  if (!closed) return closed.error();
  if (!*state || columns[4].empty()) return Ok();
  const auto sigma = table.Numbers(row, columns[4]);
  if (!sigma) return sigma.error();
  out->sigmas.push_back(Eigen::Map<const StateVector>(sigma->data()));
  return Ok();
}

}  // namespace

Result<StatesFile> ReadStatesCsv(const std::string& path, const Limits& limits) {
  const auto table = CsvTable::Read(path, limits);
  if (!table) return table.error();
  std::vector<std::string> required = {"t"};
  required.insert(required.end(), kPose.begin(), kPose.end());
  required.insert(required.end(), kTwist.begin(), kTwist.end());
  const auto found = table->RequireColumns(required);
  if (!found) return found.error();
  const std::array<Columns, 5> columns = {
      FindColumns(*table, "", kPose), FindColumns(*table, "", kTwist),
      FindColumns(*table, "cf_", kPose), FindColumns(*table, "cf_", kTwist),
      FindColumns(*table, "sigma_", kSigma)};
  StatesFile out;
  int64_t last_ns = 0;
  for (size_t row = 0; row < table->rows(); ++row) {
    if (auto read = AppendRow(*table, row, columns, (*found)[0], &last_ns, &out); !read) {
      return read.error();
    }
  }
  return out;
}

Status ReadCovarianceCsv(const std::string& path, PoseSeries* series, const Limits& limits) {
  const auto table = CsvTable::Read(path, limits);
  if (!table) return table.error();
  std::vector<std::string> names = {"t"};
  for (size_t i = 0; i < 12; ++i) {
    for (size_t j = i; j < 12; ++j) names.push_back(kSigma[i] + "_" + kSigma[j]);
  }
  const auto columns = table->RequireColumns(names);
  if (!columns) return columns.error();
  for (size_t row = 0; row < table->rows(); ++row) {
    const auto t_ns = table->Seconds(row, (*columns)[0]);
    if (!t_ns) return t_ns.error();
    const auto values = table->Numbers(row, {columns->begin() + 1, columns->end()});
    if (!values) return values.error();
    const auto at = std::lower_bound(series->begin(), series->end(), *t_ns,
                                     [](const PoseSample& s, int64_t t) { return s.t_ns < t; });
    if (at == series->end() || at->t_ns != *t_ns) continue;
    StateCovariance covariance;
    size_t k = 0;
    for (int i = 0; i < 12; ++i) {
      for (int j = i; j < 12; ++j) covariance(i, j) = covariance(j, i) = (*values)[k++];
    }
    at->covariance = covariance;
  }
  return Ok();
}

}  // namespace tagtwist::internal

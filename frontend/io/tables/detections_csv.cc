#include "frontend/io/tables/detections_csv.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <limits>

namespace tagtwist::internal {
namespace {

// A row's tag; columns are id, u1, v1, ..., u4, v4.
Result<TagDetection> ReadTag(const CsvTable& table, size_t row,
                             const std::vector<size_t>& columns) {
  const auto id = table.Integer(row, columns[0]);
  if (!id) return id.error();
  if (*id < 0 || *id > std::numeric_limits<int>::max()) {
    return table.ErrorAt(row, "id: expected a tag id >= 0, got " + std::to_string(*id));
  }
  TagDetection tag;
  tag.id = static_cast<int>(*id);
  for (size_t corner = 0; corner < 4; ++corner) {
    const auto u = table.Number(row, columns[1 + 2 * corner]);
    if (!u) return u.error();
    const auto v = table.Number(row, columns[2 + 2 * corner]);
    if (!v) return v.error();
    tag.corners[corner] = {*u, *v};
  }
  return tag;
}

std::vector<std::string> CovarianceNames() {
  std::vector<std::string> out;
  for (int row = 1; row <= 8; ++row) {
    for (int column = row; column <= 8; ++column) {
      out.push_back("c" + std::to_string(row) + std::to_string(column));
    }
  }
  return out;
}

// The columns of a covariance; none where the table has none.
Result<std::vector<size_t>> CovarianceColumns(const CsvTable& table) {
  if (!table.FindColumn("c11")) return std::vector<size_t>{};
  return table.RequireColumns(CovarianceNames());
}

// A covariance that is no positive one would spoil a run.
Status ReadCovariance(const CsvTable& table, size_t row, const std::vector<size_t>& columns,
                      TagDetection* tag) {
  if (columns.empty() || table.Cell(row, columns[0]).empty()) return Ok();
  const auto numbers = table.Numbers(row, columns);
  if (!numbers) return numbers.error();
  Eigen::Matrix<double, 8, 8> covariance;
  size_t next = 0;
  for (int i = 0; i < 8; ++i) {
    for (int j = i; j < 8; ++j) covariance(i, j) = covariance(j, i) = (*numbers)[next++];
  }
  if (covariance.llt().info() != Eigen::Success) {
    return table.ErrorAt(row, "c11 .. c88: expected a positive definite covariance");
  }
  tag->covariance = covariance;
  return Ok();
}

std::string StampColumn(TimeUnit unit) { return unit == TimeUnit::kSeconds ? "t" : "timestamp"; }

}  // namespace

Result<std::vector<StampedDetections>> ReadDetectionsCsv(const std::string& path, TimeUnit unit,
                                                         const std::vector<int>& known_ids,
                                                         std::vector<std::string>* notes) {
  const auto table = CsvTable::Read(path);
  if (!table) return table.error();
  const auto stamp_column = table->RequireColumns({StampColumn(unit)});
  if (!stamp_column) return stamp_column.error();
  const auto columns =
      table->RequireColumns({"id", "u1", "v1", "u2", "v2", "u3", "v3", "u4", "v4"});
  if (!columns) return columns.error();
  const auto covariance_columns = CovarianceColumns(*table);
  if (!covariance_columns) return covariance_columns.error();
  const auto stamps = ReadStamps(*table, stamp_column->front(), unit, true);
  if (!stamps) return stamps.error();
  std::vector<StampedDetections> out;
  size_t without = 0;
  for (size_t i = 0; i < stamps->rows.size(); ++i) {
    const size_t row = stamps->rows[i];
    const int64_t t_ns = stamps->stamps_ns[i];
    if (HasNan(*table, row, *columns)) {
      ++without;
      continue;
    }
    auto tag = ReadTag(*table, row, *columns);
    if (!tag) return tag.error();
    if (const Status read = ReadCovariance(*table, row, *covariance_columns, &*tag); !read) {
      return read.error();
    }
    if (!known_ids.empty() &&
        std::find(known_ids.begin(), known_ids.end(), tag->id) == known_ids.end()) {
      return table->ErrorAt(row, "id: expected a tag of the map, got " + std::to_string(tag->id));
    }
    if (out.empty() || t_ns != out.back().t_ns) out.push_back({t_ns, table->line(row), {}});
    out.back().tags.push_back(*tag);
  }
  if (notes == nullptr) return out;
  notes->insert(notes->end(), stamps->notes.begin(), stamps->notes.end());
  if (without > 0) {
    notes->push_back(path + ": passed over " + std::to_string(without) + " rows without numbers");
  }
  return out;
}

std::string DetectionsWithCovariancesHeader() {
  std::string out = DetectionsCsvHeader(TimeUnit::kSeconds);
  out.pop_back();
  for (const std::string& name : CovarianceNames()) out += "," + name;
  return out + "\n";
}

std::string FormatDetectionsWithCovariances(int64_t t_ns, const std::vector<TagDetection>& tags) {
  std::string out;
  for (const TagDetection& tag : tags) {
    out += FormatDetections(t_ns, {tag}, TimeUnit::kSeconds);
    out.pop_back();
    for (int i = 0; i < 8; ++i) {
      for (int j = i; j < 8; ++j) {
        out += "," + (tag.covariance ? FormatNumber((*tag.covariance)(i, j)) : std::string());
      }
    }
    out += "\n";
  }
  return out;
}

std::string DetectionsCsvHeader(TimeUnit unit) {
  return unit == TimeUnit::kSeconds
             ? "t,id,u1,v1,u2,v2,u3,v3,u4,v4\n"
             : "#timestamp [ns],id,u1 [px],v1 [px],u2 [px],v2 [px],u3 [px],v3 [px],u4 [px],v4 "
               "[px]\n";
}

std::string FormatDetections(int64_t t_ns, const std::vector<TagDetection>& tags, TimeUnit unit) {
  std::string out;
  for (const TagDetection& tag : tags) {
    out += FormatStamp(t_ns, unit) + "," + std::to_string(tag.id);
    for (const Eigen::Vector2d& corner : tag.corners) {
      out += "," + FormatNumber(corner.x()) + "," + FormatNumber(corner.y());
    }
    out += "\n";
  }
  return out;
}

}  // namespace tagtwist::internal

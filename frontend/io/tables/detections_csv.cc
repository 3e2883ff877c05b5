#include "frontend/io/tables/detections_csv.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <limits>
#include <optional>

namespace tagtwist::internal {
namespace {

// Where a table has what.
struct TagColumns {
  std::vector<size_t> tag;         // id, u1, v1, ..., u4, v4
  std::vector<size_t> covariance;  // none where the table has none
  std::optional<size_t> doubled;
};

// A row's id, one of `known_ids` where these have any.
Result<int> ReadId(const CsvTable& table, size_t row, size_t column,
                   const std::vector<int>& known_ids) {
  const auto id = table.Integer(row, column);
  if (!id) return id.error();
  if (*id < 0 || *id > std::numeric_limits<int>::max()) {
    return table.ErrorAt(row, "id: expected a tag id >= 0, got " + std::to_string(*id));
  }
  const int out = static_cast<int>(*id);
  if (!known_ids.empty() && std::find(known_ids.begin(), known_ids.end(), out) == known_ids.end()) {
    return table.ErrorAt(row, "id: expected a tag of the map, got " + std::to_string(out));
  }
  return out;
}

// Whether a row tells of an id that was seen at two places, and nothing else.
Result<bool> IsOfDoubled(const CsvTable& table, size_t row, const TagColumns& columns) {
  if (!columns.doubled) return false;
  const std::string_view cell = table.Cell(row, *columns.doubled);
  if (cell.empty() || cell == "0" || cell == "1") return cell == "1";
  return table.ErrorAt(row, "doubled: expected 1 or nothing, got " + QuoteForMessage(cell));
}

// The corners of a row's tag, whose id is known.
Result<TagDetection> ReadTag(const CsvTable& table, size_t row, int id,
                             const std::vector<size_t>& columns) {
  TagDetection tag;
  tag.id = id;
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

Result<TagColumns> FindTagColumns(const CsvTable& table) {
  auto tag = table.RequireColumns({"id", "u1", "v1", "u2", "v2", "u3", "v3", "u4", "v4"});
  if (!tag) return tag.error();
  TagColumns out{std::move(*tag), {}, table.FindColumn("doubled")};
  if (!table.FindColumn("c11")) return out;
  auto covariance = table.RequireColumns(CovarianceNames());
  if (!covariance) return covariance.error();
  out.covariance = std::move(*covariance);
  return out;
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

// Adds what a row says to what its stamp has.
Status AddRow(const CsvTable& table, size_t row, const TagColumns& columns,
              const std::vector<int>& known_ids, StampedDetections* out) {
  const auto id = ReadId(table, row, columns.tag[0], known_ids);
  if (!id) return id.error();
  const auto is_doubled = IsOfDoubled(table, row, columns);
  if (!is_doubled) return is_doubled.error();
  if (*is_doubled) {
    const auto place = std::lower_bound(out->doubled_ids.begin(), out->doubled_ids.end(), *id);
    if (place == out->doubled_ids.end() || *place != *id) out->doubled_ids.insert(place, *id);
    return Ok();
  }
  auto tag = ReadTag(table, row, *id, columns.tag);
  if (!tag) return tag.error();
  if (const Status read = ReadCovariance(table, row, columns.covariance, &*tag); !read) return read;
  out->tags.push_back(std::move(*tag));
  return Ok();
}

std::string StampColumn(TimeUnit unit) { return unit == TimeUnit::kSeconds ? "t" : "timestamp"; }

}  // namespace

Result<std::vector<StampedDetections>> ReadDetectionsCsv(const std::string& path, TimeUnit unit,
                                                         const std::vector<int>& known_ids,
                                                         std::vector<std::string>* notes,
                                                         const Limits& limits) {
  const auto table = CsvTable::Read(path, limits);
  if (!table) return table.error();
  const auto stamp_column = table->RequireColumns({StampColumn(unit)});
  if (!stamp_column) return stamp_column.error();
  const auto columns = FindTagColumns(*table);
  if (!columns) return columns.error();
  const auto stamps = ReadStamps(*table, stamp_column->front(), unit, true);
  if (!stamps) return stamps.error();
  std::vector<StampedDetections> out;
  size_t without = 0;
  for (size_t i = 0; i < stamps->rows.size(); ++i) {
    const size_t row = stamps->rows[i];
    const int64_t t_ns = stamps->stamps_ns[i];
    if (HasNan(*table, row, columns->tag)) {
      ++without;
      continue;
    }
    if (out.empty() || t_ns != out.back().t_ns) out.push_back({t_ns, table->line(row), {}});
    if (const Status added = AddRow(*table, row, *columns, known_ids, &out.back()); !added) {
      return added.error();
    }
  }
  if (notes == nullptr) return out;
  notes->insert(notes->end(), stamps->notes.begin(), stamps->notes.end());
  if (without > 0) {
    notes->push_back(path + ": passed over " + std::to_string(without) + " rows without numbers");
  }
  return out;
}

std::string MeasuredTagsHeader() {
  std::string out = DetectionsCsvHeader(TimeUnit::kSeconds);
  out.pop_back();
  for (const std::string& name : CovarianceNames()) out += "," + name;
  return out + ",doubled\n";
}

std::string FormatMeasuredTags(int64_t t_ns, const std::vector<TagDetection>& tags,
                               const std::vector<int>& doubled_ids) {
  std::string out;
  for (const TagDetection& tag : tags) {
    out += FormatDetections(t_ns, {tag}, TimeUnit::kSeconds);
    out.pop_back();
    for (int i = 0; i < 8; ++i) {
      for (int j = i; j < 8; ++j) {
        out += "," + (tag.covariance ? FormatNumber((*tag.covariance)(i, j)) : std::string());
      }
    }
    out += ",\n";
  }
  constexpr int kCornerColumns = 8, kCovarianceColumns = 36;
  for (const int id : doubled_ids) {
    out += FormatStamp(t_ns, TimeUnit::kSeconds) + "," + std::to_string(id) +
           std::string(kCornerColumns + kCovarianceColumns, ',') + ",1\n";
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

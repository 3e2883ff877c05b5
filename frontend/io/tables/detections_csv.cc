#include "frontend/io/tables/detections_csv.h"

#include <algorithm>
#include <limits>

namespace tagtwist {
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

std::string StampColumn(TimeUnit unit) { return unit == TimeUnit::kSeconds ? "t" : "timestamp"; }

}  // namespace

Result<std::vector<StampedDetections>> ReadDetectionsCsv(const std::string& path, TimeUnit unit,
                                                         const std::vector<int>& known_ids) {
  const auto table = CsvTable::Read(path);
  if (!table) return table.error();
  const auto stamp_column = table->RequireColumns({StampColumn(unit)});
  if (!stamp_column) return stamp_column.error();
  const auto columns =
      table->RequireColumns({"id", "u1", "v1", "u2", "v2", "u3", "v3", "u4", "v4"});
  if (!columns) return columns.error();
  std::vector<StampedDetections> out;
  for (size_t row = 0; row < table->rows(); ++row) {
    const auto t_ns = ReadStamp(*table, row, stamp_column->front(), unit);
    if (!t_ns) return t_ns.error();
    auto tag = ReadTag(*table, row, *columns);
    if (!tag) return tag.error();
    if (!known_ids.empty() &&
        std::find(known_ids.begin(), known_ids.end(), tag->id) == known_ids.end()) {
      return table->ErrorAt(row, "id: expected a tag of the map, got " + std::to_string(tag->id));
    }
    if (out.empty() || *t_ns != out.back().t_ns) {
      if (!out.empty()) {
        if (const auto fault = StampFault(out.back().t_ns, *t_ns)) {
          return table->ErrorAt(row, *fault);
        }
      }
      out.push_back({*t_ns, table->line(row), {}});
    }
    out.back().tags.push_back(*tag);
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

}  // namespace tagtwist

#include "frontend/io/trajectories/trajectory_columns.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <map>
#include <numeric>
#include <utility>

#include "frontend/base/number_text.h"

namespace tagtwist::internal {
namespace {

using Names = std::vector<std::string>;

// A column's name in one shape: "field.pose.position.x" -> "pose_position_x", "p_RS_R_x [m]" ->
// "p_rs_r_x", "#time(ns)" -> "time".
std::string Plain(std::string_view name) {
  name = name.substr(0, name.find_first_of("[("));
  std::string out;
  for (const char c : name) {
    const auto byte = static_cast<unsigned char>(c);
    if (std::isalnum(byte) != 0) {
      out += static_cast<char>(std::tolower(byte));
    } else if (!out.empty() && out.back() != '_') {
      out += '_';
    }
  }
  while (!out.empty() && out.back() == '_') out.pop_back();
  return out.rfind("field_", 0) == 0 ? out.substr(6) : out;
}

// "ns" of "timestamp [ns]" and of "time(ns)"; of a name that ends in _ns, too.
std::string UnitOf(std::string_view name) {
  const size_t open = name.find_first_of("[(");
  if (open != std::string_view::npos) {
    const size_t close = name.find_first_of("])", open);
    return std::string(name.substr(
        open + 1, close == std::string_view::npos ? std::string_view::npos : close - open - 1));
  }
  const size_t last = name.rfind('_');
  return last == std::string_view::npos ? "" : std::string(name.substr(last + 1));
}

std::optional<StampUnit> StampUnitOf(const std::string& unit) {
  if (unit == "s" || unit == "sec" || unit == "Seconds") return StampUnit::kSeconds;
  if (unit == "ms") return StampUnit::kMilliseconds;
  if (unit == "us") return StampUnit::kMicroseconds;
  if (unit == "ns" || unit == "nsec") return StampUnit::kNanoseconds;
  return std::nullopt;
}

// Names that a vector's first component goes by; the others end in the other letters.
const std::map<std::string, std::vector<std::string>>& Stems() {
  static const std::map<std::string, std::vector<std::string>> stems = {
      {"position",
       {"", "t", "p", "p_", "t_", "pos_", "position_", "pose_position_", "pose_pose_position_",
        "transform_translation_", "translation_", "p_rs_r_"}},
      {"attitude",
       {"q", "q_", "quat_", "quaternion_", "orientation_", "pose_orientation_",
        "pose_pose_orientation_", "transform_rotation_", "rotation_", "q_rs_"}},
      {"velocity", {"v#_world", "v", "v_", "v_rs_r_"}},
      {"rate", {"w#_body", "w", "w_", "w_rs_s_"}}};
  return stems;
}

std::string Component(const std::string& stem, char axis) {
  const size_t place = stem.find('#');
  if (place == std::string::npos) return stem + axis;
  std::string out = stem;
  out[place] = axis;
  return out;
}

std::optional<size_t> Find(const Names& names, const std::string& name) {
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) return std::nullopt;
  return static_cast<size_t>(found - names.begin());
}

// The columns of a vector under the first stem of which all components are there; empty: none.
std::vector<size_t> FindVector(const Names& names, const std::string& what, const char* axes) {
  for (const std::string& stem : Stems().at(what)) {
    std::vector<size_t> out;
    for (const char* axis = axes; *axis != 0; ++axis) {
      if (const auto column = Find(names, Component(stem, *axis))) out.push_back(*column);
    }
    if (out.size() == std::string_view(axes).size()) return out;
  }
  return {};
}

std::optional<size_t> FindStamp(const Names& names) {
  for (const char* name : {"t", "header_stamp", "timestamp", "time", "stamp", "time_s", "time_ns",
                           "timestamp_s", "timestamp_ns", "timestamp_us", "timestamp_ms", "secs"}) {
    if (const auto column = Find(names, name)) return column;
  }
  return std::nullopt;
}

std::string Listed(const Names& names) {
  std::string out;
  for (const std::string& name : names) out += (out.empty() ? "" : ", ") + name;
  return out.size() > 120 ? out.substr(0, 120) + "..." : out;
}

double MetresIn(const std::string& unit) {
  if (unit == "mm") return 1e-3;
  return unit == "cm" ? 1e-2 : 1;
}

Result<TrajectoryColumns> ByNames(const TextGrid::Row& heading, const std::string& path) {
  Names names;
  for (const std::string_view cell : heading.cells) names.push_back(Plain(cell));
  const std::string place = path + ":" + std::to_string(heading.line) + ": ";
  TrajectoryColumns out;
  out.form = "a table with names";
  const auto stamp = FindStamp(names);
  if (!stamp) {
    return Error{place + "missing column 't' (or time, timestamp); there are " + Listed(names)};
  }
  out.stamp = *stamp;
  out.stamp_unit = StampUnitOf(UnitOf(heading.cells[*stamp]));
  if (names[*stamp] == "header_stamp") out.stamp_unit = StampUnit::kNanoseconds;
  out.pose = FindVector(names, "position", "xyz");
  if (out.pose.empty()) {
    return Error{place + "missing column 'x', 'y' or 'z' (or tx, px, p_x); there are " +
                 Listed(names)};
  }
  const bool euroc = names[out.pose[0]] == "p_rs_r_x";
  if (euroc && !out.stamp_unit) out.stamp_unit = StampUnit::kNanoseconds;
  out.metres = MetresIn(UnitOf(heading.cells[out.pose[0]]));
  const auto attitude = FindVector(names, "attitude", "xyzw");
  if (attitude.empty()) {
    return Error{place + "missing column 'qx', 'qy', 'qz' or 'qw': positions alone cannot be " +
                 "compared with; there are " + Listed(names)};
  }
  out.pose.insert(out.pose.end(), attitude.begin(), attitude.end());
  out.velocity = FindVector(names, "velocity", "xyz");
  out.rate = FindVector(names, "rate", "xyz");
  return out;
}

std::vector<size_t> From(size_t first, std::initializer_list<size_t> order) {
  std::vector<size_t> out;
  for (const size_t each : order) out.push_back(first + each);
  return out;
}

bool FirstColumnCounts(const TextGrid& grid) {
  std::optional<int64_t> before;
  for (const TextGrid::Row& row : grid.rows()) {
    const auto number = ParseInteger(row.cells[0]);
    if (!number || (before && (*number <= *before || *number - 1 != *before))) return false;
    before = number;
  }
  return true;
}

Result<TrajectoryColumns> ByNumber(const TextGrid& grid, const std::string& path) {
  const TextGrid::Row& row = grid.rows().front();
  const size_t columns = row.cells.size();
  TrajectoryColumns out;
  if (columns == 8 || columns == 20) {
    out.form = columns == 8 ? "TUM" : "OpenVINS with covariances";
    out.pose = From(1, {0, 1, 2, 3, 4, 5, 6});
    return out;
  }
  if (columns == 9 && FirstColumnCounts(grid)) {
    out.form = "TUM with a running number ahead";
    out.stamp = 1;
    out.pose = From(2, {0, 1, 2, 3, 4, 5, 6});
    return out;
  }
  if (columns == 17) {
    out.form = "EuRoC state_groundtruth without names";
    out.pose = From(1, {0, 1, 2, 4, 5, 6, 3});
    out.velocity = From(8, {0, 1, 2});
    return out;
  }
  const std::string place = path + ":" + std::to_string(row.line) + ": ";
  if (columns == 12) {
    return Error{place +
                 "KITTI's poses have no times: expected its times.txt beside the file, or " +
                 "t x y z qx qy qz qw"};
  }
  if (columns == 3 || columns == 4) {
    return Error{place + "positions alone cannot be compared with: expected t x y z qx qy qz qw, " +
                 "got " + std::to_string(columns) + " fields: export attitudes, too"};
  }
  return Error{place + "expected t x y z qx qy qz qw, or names over the columns, got " +
               std::to_string(columns) + " fields"};
}

// By those names, which must stand over all columns of the rows.
Result<TrajectoryColumns> ByNamesOver(const TextGrid& grid, const TextGrid::Row& names,
                                      const std::string& path) {
  auto out = ByNames(names, path);
  const size_t width = grid.rows().front().cells.size();
  if (!out || names.cells.size() == width) return out;
  return Error{path + ":" + std::to_string(names.line) + ": expected " + std::to_string(width) +
               " names as the rows have fields, got " + std::to_string(names.cells.size())};
}

// The last line of the heading, when it names as many columns as the rows have.
const TextGrid::Row* NamesOf(const TextGrid& grid) {
  for (auto row = grid.heading().rbegin(); row != grid.heading().rend(); ++row) {
    TextGrid::Row named = *row;
    const bool known = FindStamp([&] {
                         Names names;
                         for (const std::string_view cell : named.cells)
                           names.push_back(Plain(cell));
                         return names;
                       }())
                           .has_value();
    if (row->cells.size() == grid.rows().front().cells.size() && known) return &*row;
  }
  return nullptr;
}

}  // namespace

Result<TrajectoryColumns> FindTrajectoryColumns(const TextGrid& grid, const std::string& path) {
  if (const TextGrid::Row* names = NamesOf(grid)) return ByNames(*names, path);
  // A heading that is no comment has names, though not those that are needed.
  for (const TextGrid::Row& row : grid.heading()) {
    const bool comment = row.cells[0].empty() || row.cells[0][0] == '#' || row.cells[0][0] == '%';
    if (!comment && row.cells.size() > 1) return ByNamesOver(grid, row, path);
  }
  return ByNumber(grid, path);
}

}  // namespace tagtwist::internal

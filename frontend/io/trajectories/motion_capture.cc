#include "frontend/io/trajectories/motion_capture.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "frontend/base/number_text.h"
#include "frontend/types/so3.h"

namespace tagtwist::internal {
namespace {

using Row = TextGrid::Row;
using Read = std::optional<Result<TrajectoryFile>>;

// The heading's line whose first cell it is.
const Row* Line(const TextGrid& grid, std::string_view first_cell) {
  for (const Row& row : grid.heading()) {
    if (!row.cells.empty() && row.cells[0] == first_cell) return &row;
  }
  return nullptr;
}

std::string_view CellOf(const Row& row, size_t column) {
  return column < row.cells.size() ? row.cells[column] : std::string_view();
}

// What stands after a key in a line of keys and values.
std::string_view ValueOf(const Row& row, std::string_view key) {
  for (size_t i = 0; i + 1 < row.cells.size(); ++i) {
    if (row.cells[i] == key) return row.cells[i + 1];
  }
  return {};
}

// A body among those of a file, by the column that it begins at.
struct Body {
  std::string name;
  size_t column = 0;
};

Result<Body> Choose(const std::vector<Body>& bodies, const std::string& wanted,
                    const std::string& path) {
  std::string listed;
  for (const Body& body : bodies) {
    if (body.name == wanted || (wanted.empty() && bodies.size() == 1)) return body;
    listed += (listed.empty() ? "" : ", ") + body.name;
  }
  if (bodies.empty()) return Error{path + ": no rigid body in it: export rigid bodies or segments"};
  return Error{path + ": " + (wanted.empty() ? "several bodies" : "no body " + wanted) +
               ": expected --truth_topic, one of " + listed};
}

std::optional<std::vector<double>> Numbers(const Row& row, size_t first, size_t count) {
  std::vector<double> out;
  for (size_t i = first; i < first + count; ++i) {
    const auto number = ParseNumber(CellOf(row, i));
    if (!number) return std::nullopt;
    out.push_back(*number);
  }
  return out;
}

std::optional<double> MetresIn(std::string_view unit) {
  if (unit == "Meters" || unit == "m") return 1;
  if (unit == "Centimeters" || unit == "cm") return 1e-2;
  if (unit == "Millimeters" || unit == "mm") return 1e-3;
  return std::nullopt;
}

std::vector<Body> MotiveBodies(const Row& types, const Row& names, const Row& kinds) {
  std::vector<Body> out;
  for (size_t i = 2; i < types.cells.size(); ++i) {
    if (types.cells[i] != "Rigid Body" || CellOf(kinds, i) != "Rotation") continue;
    const std::string name(CellOf(names, i));
    if (out.empty() || out.back().name != name) out.push_back({name, i});
  }
  return out;
}

const Row* MotiveKinds(const TextGrid& grid) {
  for (const Row& row : grid.heading()) {
    if (std::find(row.cells.begin(), row.cells.end(), "Rotation") != row.cells.end()) return &row;
  }
  return nullptr;
}

Result<TrajectoryFile> MotivePoses(const TextGrid& grid, const std::string& path, size_t column,
                                   double metres) {
  TrajectoryRows rows(path);
  for (const Row& row : grid.rows()) {
    const auto t_ns = ParseSeconds(CellOf(row, 1));
    const auto n = Numbers(row, column, 7);
    if (!t_ns || !n) {
      rows.PassOver(row.line, "without numbers");
      continue;
    }
    const Status added = rows.Add(
        row.line, *t_ns,
        {metres * (*n)[4], metres * (*n)[5], metres * (*n)[6], (*n)[0], (*n)[1], (*n)[2], (*n)[3]});
    if (!added) return added.error();
  }
  return rows.Finish("Motive");
}

struct ViconHeading {
  const Row* names = nullptr;   // Frame, Sub Frame, RX, ...
  const Row* bodies = nullptr;  // the line above
  const Row* units = nullptr;   // the line below
  double rate_hz = 0;
};

// Above the names stand the section, the rate alone, and the bodies.
std::optional<ViconHeading> FindViconHeading(const TextGrid& grid) {
  const auto& heading = grid.heading();
  for (size_t i = 2; i + 1 < heading.size(); ++i) {
    if (heading[i].cells[0] != "Frame" || CellOf(heading[i], 1) != "Sub Frame") continue;
    ViconHeading out{&heading[i], &heading[i - 1], &heading[i + 1], 0};
    out.rate_hz = ParseNumber(CellOf(heading[i - 2], 0)).value_or(0);
    return out;
  }
  return std::nullopt;
}

std::vector<Body> ViconBodies(const ViconHeading& heading) {
  std::vector<Body> out;
  for (size_t i = 2; i + 5 < heading.names->cells.size(); ++i) {
    const std::string_view name = CellOf(*heading.bodies, i);
    if (!name.empty() && heading.names->cells[i] == "RX") out.push_back({std::string(name), i});
  }
  return out;
}

Result<TrajectoryFile> ViconPoses(const TextGrid& grid, const std::string& path,
                                  const ViconHeading& heading, size_t column, double metres) {
  const bool quaternion = CellOf(*heading.names, column + 3) == "RW";
  const bool degrees = CellOf(*heading.units, column) == "deg";
  const size_t size = quaternion ? 7 : 6;
  TrajectoryRows rows(path);
  for (const Row& row : grid.rows()) {
    const auto frame = ParseNumber(CellOf(row, 0));
    if (!frame) break;  // another section
    const auto n = Numbers(row, column, size);
    const double t_ns = 1e9 * *frame / heading.rate_hz;
    if (!n || !(std::abs(t_ns) < kMostStampNs)) {
      rows.PassOver(row.line, "without numbers");
      continue;
    }
    const Eigen::Vector3d vector = Eigen::Vector3d(n->data()) * (degrees ? M_PI / 180 : 1);
    const Eigen::Quaterniond q =
        quaternion ? Eigen::Quaterniond((*n)[3], (*n)[0], (*n)[1], (*n)[2]) : ExpSo3(vector);
    const Eigen::Vector3d p = metres * Eigen::Vector3d(n->data() + size - 3);
    const Status added =
        rows.Add(row.line, std::llround(t_ns), {p.x(), p.y(), p.z(), q.x(), q.y(), q.z(), q.w()});
    if (!added) return added.error();
  }
  return rows.Finish("Vicon");
}

// The column of Rot[0], or nullopt.
std::optional<size_t> FirstMatrixColumn(const Row& names) {
  for (size_t i = 0; i + 8 < names.cells.size(); ++i) {
    const std::string_view cell = names.cells[i];
    if (cell.size() >= 6 && cell.substr(cell.size() - 6) == "Rot[0]") return i;
  }
  return std::nullopt;
}

Result<TrajectoryFile> QualisysPoses(const TextGrid& grid, const std::string& path,
                                     const Row& names, size_t matrix_column) {
  const auto is_x = [](std::string_view cell) {
    return cell == "X" || (cell.size() > 2 && cell.substr(cell.size() - 2) == " X");
  };
  const auto x = std::find_if(names.cells.begin(), names.cells.end(), is_x);
  const auto time = std::find(names.cells.begin(), names.cells.end(), "Time");
  if (x == names.cells.end() || time == names.cells.end()) {
    return Error{Place(path, names.line) + "expected the columns Time, X, Y, Z of a 6D export"};
  }
  const auto x_column = static_cast<size_t>(x - names.cells.begin());
  const auto time_column = static_cast<size_t>(time - names.cells.begin());
  TrajectoryRows rows(path);
  for (const Row& row : grid.rows()) {
    const auto t_ns = ParseSeconds(CellOf(row, time_column));
    const auto p = Numbers(row, x_column, 3), m = Numbers(row, matrix_column, 9);
    const bool lost = m && std::all_of(m->begin(), m->end(), [](double v) { return v == 0; });
    if (!t_ns || !p || !m || lost) {
      rows.PassOver(row.line, "without a pose");
      continue;
    }
    const Eigen::Matrix3d rotation = Eigen::Map<const Eigen::Matrix3d>(m->data());  // by columns
    const double off = (rotation.transpose() * rotation - Eigen::Matrix3d::Identity()).norm();
    if (!(off < 1e-2) || !(rotation.determinant() > 0)) {
      return Error{Place(path, row.line) + "Rot[0]..Rot[8]: expected a rotation"};
    }
    const Eigen::Quaterniond q = Eigen::Quaterniond(rotation).normalized();
    const Status added =
        rows.Add(row.line, *t_ns,
                 {1e-3 * (*p)[0], 1e-3 * (*p)[1], 1e-3 * (*p)[2], q.x(), q.y(), q.z(), q.w()});
    if (!added) return added.error();
  }
  return rows.Finish("Qualisys");
}

}  // namespace

Read ReadMotive(const TextGrid& grid, const std::string& path, const std::string& body) {
  const Row* first = Line(grid, "Format Version");
  const Row* kinds = MotiveKinds(grid);
  if (first == nullptr || kinds == nullptr) return std::nullopt;
  const auto& heading = grid.heading();
  const Row* types = nullptr;
  for (size_t i = 0; i + 1 < heading.size() && types == nullptr; ++i) {
    const bool has = std::find(heading[i].cells.begin(), heading[i].cells.end(), "Rigid Body") !=
                     heading[i].cells.end();
    if (has) types = &heading[i];
  }
  if (types == nullptr) return Result<TrajectoryFile>(Choose({}, body, path).error());
  if (ValueOf(*first, "Rotation Type") != "Quaternion") {
    return Result<TrajectoryFile>(Error{Place(path, first->line) +
                                        "Motive's Euler angles are not read: export with " +
                                        "rotation type Quaternion"});
  }
  const std::string_view unit = ValueOf(*first, "Length Units");
  const auto metres = MetresIn(unit);
  if (!metres) {
    return Result<TrajectoryFile>(Error{Place(path, first->line) +
                                        "Length Units: expected Meters, Centimeters or " +
                                        "Millimeters, got " + QuoteForMessage(unit)});
  }
  const auto chosen = Choose(MotiveBodies(*types, types[1], *kinds), body, path);
  if (!chosen) return Result<TrajectoryFile>(chosen.error());
  return MotivePoses(grid, path, chosen->column, *metres);
}

Read ReadVicon(const TextGrid& grid, const std::string& path, const std::string& body) {
  const auto heading = FindViconHeading(grid);
  if (!heading) return std::nullopt;
  if (!(heading->rate_hz > 0)) {
    return Result<TrajectoryFile>(Error{Place(path, heading->names->line) +
                                        "expected the rate [Hz] two lines above the names"});
  }
  const auto chosen = Choose(ViconBodies(*heading), body, path);
  if (!chosen) return Result<TrajectoryFile>(chosen.error());
  const bool quaternion = CellOf(*heading->names, chosen->column + 3) == "RW";
  const auto metres = MetresIn(CellOf(*heading->units, chosen->column + (quaternion ? 4 : 3)));
  if (!metres) {
    return Result<TrajectoryFile>(
        Error{Place(path, heading->units->line) + "expected the unit of TX, mm or m"});
  }
  return ViconPoses(grid, path, *heading, chosen->column, *metres);
}

Read ReadQualisys(const TextGrid& grid, const std::string& path, const std::string& body) {
  const Row* data = Line(grid, "DATA_INCLUDED");
  if (data == nullptr || Line(grid, "FREQUENCY") == nullptr) return std::nullopt;
  if (CellOf(*data, 1) != "6D") {
    return Result<TrajectoryFile>(
        Error{Place(path, data->line) + "points have no attitudes: export 6D data"});
  }
  const Row* bodies = Line(grid, "BODY_NAMES");
  std::vector<Body> known;
  for (size_t i = 1; bodies != nullptr && i < bodies->cells.size(); ++i) {
    if (!bodies->cells[i].empty()) known.push_back({std::string(bodies->cells[i]), i});
  }
  const auto chosen = Choose(known, body, path);
  if (!chosen) return Result<TrajectoryFile>(chosen.error());
  const Row& names = grid.heading().back();
  const auto matrix = FirstMatrixColumn(names);
  if (!matrix) {
    return Result<TrajectoryFile>(Error{
        Place(path, names.line) + "a Qualisys file does not tell the order of its Euler angles: " +
        "export the rotation matrix (Rot[0] to Rot[8]) with it"});
  }
  if (known.size() > 1) {
    return Result<TrajectoryFile>(
        Error{Place(path, names.line) + "several bodies: export the one alone"});
  }
  return QualisysPoses(grid, path, names, *matrix);
}

}  // namespace tagtwist::internal

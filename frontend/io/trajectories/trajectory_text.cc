#include "frontend/io/trajectories/trajectory_text.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <utility>

#include "frontend/base/files/input_file.h"
#include "frontend/base/number_text.h"
#include "frontend/io/tables/stamp_unit.h"
#include "frontend/io/tables/text_grid.h"
#include "frontend/io/trajectories/motion_capture.h"
#include "frontend/io/trajectories/trajectory_columns.h"
#include "frontend/types/truth.h"

namespace tagtwist::internal {
namespace {

bool IsNotANumber(std::string_view cell) {
  return cell.empty() || cell == "nan" || cell == "NaN" || cell == "-nan" || cell == "NAN";
}

// Which unit the stamps count: what the table tells, else what they imply.
StampUnit StampUnitOf(const TextGrid& grid, const TrajectoryColumns& columns) {
  std::vector<double> numbers;
  bool whole = true;
  for (const TextGrid::Row& row : grid.rows()) {
    if (columns.stamp >= row.cells.size()) continue;
    const std::string_view cell = row.cells[columns.stamp];
    if (const auto number = ParseNumber(cell)) numbers.push_back(*number);
    whole = whole && ParseInteger(cell).has_value();
  }
  if (numbers.empty()) return StampUnit::kSeconds;
  const StampUnit told = columns.stamp_unit.value_or(StampUnit::kSeconds);
  if (const auto wrong = FindWrongUnit(numbers, told)) return wrong->implied;
  if (columns.stamp_unit) return *columns.stamp_unit;
  if (const auto dated = UnitOfUnixTime(numbers.front())) return *dated;
  if (!whole) return StampUnit::kSeconds;
  return UnitOfInterval(MedianStep(numbers)).value_or(StampUnit::kSeconds);
}

// Numbers of some cells; nullopt where one is none or infinite.
std::optional<std::vector<double>> NumbersOf(const TextGrid::Row& row,
                                             const std::vector<size_t>& columns) {
  std::vector<double> out;
  for (const size_t column : columns) {
    const auto number = ParseNumber(row.cells[column]);
    if (!number) return std::nullopt;
    out.push_back(*number);
  }
  return out;
}

// The fault of a cell that is neither a number nor "nan".
std::optional<std::string> CellFault(const TextGrid::Row& row, const std::vector<size_t>& columns) {
  for (const size_t column : columns) {
    const std::string_view cell = row.cells[column];
    if (ParseNumber(cell) || IsNotANumber(cell)) continue;
    return "expected a finite number, got " + QuoteForMessage(cell);
  }
  return std::nullopt;
}

bool AllZero(const std::vector<TruthSample>& samples) {
  for (const TruthSample& sample : samples) {
    if (!sample.twist || sample.twist->v_world.norm() != 0) return false;
  }
  return !samples.empty();
}

// Columns of velocities that were never filled would be taken for a body at rest.
void DropEmptyTwists(TrajectoryFile* file, const std::string& path) {
  std::vector<TruthSample>& samples = file->samples;
  constexpr double kMovedM = 0.01;
  bool moved = false;
  for (const TruthSample& sample : samples) {
    const Eigen::Vector3d way =
        sample.world_from_body.translation() - samples.front().world_from_body.translation();
    moved = moved || way.norm() > kMovedM;
  }
  if (!moved || !AllZero(samples)) return;
  for (TruthSample& sample : samples) sample.twist.reset();
  file->notes.push_back(path + ": its velocities are zero throughout while it moves: left out");
}

void FillRates(std::vector<TruthSample>* samples) {
  const std::vector<Eigen::Vector3d> rates = DifferentiateAttitude(*samples);
  for (size_t i = 0; i < samples->size(); ++i) {
    if ((*samples)[i].twist) (*samples)[i].twist->omega_body = rates[i];
  }
}

Status AddRow(const TextGrid::Row& row, const TrajectoryColumns& columns, StampUnit unit,
              const std::string& path, TrajectoryRows* rows) {
  const auto t_ns = ParseStamp(row.cells[columns.stamp], unit);
  if (!t_ns) {
    if (IsNotANumber(row.cells[columns.stamp])) {
      rows->PassOver(row.line, "without a stamp");
      return Ok();
    }
    return Error{Place(path, row.line) + "expected a time in " + ToString(unit) + ", got " +
                 QuoteForMessage(row.cells[columns.stamp])};
  }
  if (const auto fault = CellFault(row, columns.pose)) {
    return Error{Place(path, row.line) + *fault};
  }
  auto numbers = NumbersOf(row, columns.pose);
  if (!numbers) {
    rows->PassOver(row.line, "without numbers");
    return Ok();
  }
  for (size_t i = 0; i < 3; ++i) (*numbers)[i] *= columns.metres;
  if (const Status added = rows->Add(row.line, *t_ns, *numbers); !added) return added;
  if (!rows->LastWasTaken() || columns.velocity.empty()) return Ok();
  for (const auto* twist : {&columns.velocity, &columns.rate}) {
    if (const auto fault = CellFault(row, *twist)) return Error{Place(path, row.line) + *fault};
  }
  const auto v = NumbersOf(row, columns.velocity), w = NumbersOf(row, columns.rate);
  if (!v || !w) return Ok();
  rows->SetTwist({Eigen::Vector3d(v->data()), w->empty() ? Eigen::Vector3d(Eigen::Vector3d::Zero())
                                                         : Eigen::Vector3d(w->data())});
  return Ok();
}

Result<TrajectoryFile> ReadTable(const TextGrid& grid, const std::string& path) {
  const auto columns = FindTrajectoryColumns(grid, path);
  if (!columns) return columns.error();
  const StampUnit unit = StampUnitOf(grid, *columns);
  TrajectoryRows rows(path);
  const size_t width = grid.rows().front().cells.size();
  for (const TextGrid::Row& row : grid.rows()) {
    if (row.cells.size() != width) {
      return Error{Place(path, row.line) + "expected " + std::to_string(width) + " fields, got " +
                   std::to_string(row.cells.size())};
    }
    if (const Status added = AddRow(row, *columns, unit, path, &rows); !added) return added.error();
  }
  auto file = rows.Finish(columns->form);
  if (!file) return file;
  if (columns->rate.empty() && !columns->velocity.empty()) FillRates(&file->samples);
  DropEmptyTwists(&*file, path);
  const bool told = columns->stamp_unit == unit;
  if (unit != StampUnit::kSeconds && !told) {
    file->notes.push_back(path + ": its stamps are taken for " + ToString(unit));
  }
  return file;
}

// KITTI: a 3 x 4 matrix a row, its times in times.txt beside it, one a row.
std::optional<Result<TrajectoryFile>> ReadKitti(const TextGrid& grid, const std::string& path,
                                                const Limits& limits) {
  const auto times = std::filesystem::path(path).parent_path() / "times.txt";
  std::error_code unknown;
  const bool is_kitti = grid.heading().empty() && grid.rows().front().cells.size() == 12;
  if (!is_kitti || !std::filesystem::exists(times, unknown)) return std::nullopt;
  auto text = ReadWholeFile(times.string(), limits);
  if (!text) return Result<TrajectoryFile>(text.error());
  std::vector<int64_t> stamps_ns;
  std::string_view rest = *text;
  while (!rest.empty()) {
    const std::string_view line = rest.substr(0, rest.find('\n'));
    rest.remove_prefix(std::min(line.size() + 1, rest.size()));
    const auto t_ns = ParseSeconds(line.substr(0, line.find_last_not_of(" \r") + 1));
    if (t_ns) stamps_ns.push_back(*t_ns);
  }
  if (stamps_ns.size() != grid.rows().size()) {
    return Result<TrajectoryFile>(Error{times.string() + ": expected a time for each of the " +
                                        std::to_string(grid.rows().size()) + " poses, got " +
                                        std::to_string(stamps_ns.size())});
  }
  TrajectoryRows rows(path);
  for (size_t i = 0; i < stamps_ns.size(); ++i) {
    const TextGrid::Row& row = grid.rows()[i];
    std::vector<size_t> all(row.cells.size());
    for (size_t k = 0; k < all.size(); ++k) all[k] = k;
    const auto n = NumbersOf(row, all);
    if (!n || n->size() != 12) {
      return Result<TrajectoryFile>(Error{Place(path, row.line) + "expected 12 finite numbers"});
    }
    Eigen::Matrix3d rotation;
    rotation << (*n)[0], (*n)[1], (*n)[2], (*n)[4], (*n)[5], (*n)[6], (*n)[8], (*n)[9], (*n)[10];
    const double off = (rotation.transpose() * rotation - Eigen::Matrix3d::Identity()).norm();
    if (!(off < 1e-2) || !(rotation.determinant() > 0)) {
      return Result<TrajectoryFile>(Error{Place(path, row.line) + "expected a rigid 3 x 4 matrix"});
    }
    const Eigen::Quaterniond q = Eigen::Quaterniond(rotation).normalized();
    const Status added =
        rows.Add(row.line, stamps_ns[i], {(*n)[3], (*n)[7], (*n)[11], q.x(), q.y(), q.z(), q.w()});
    if (!added) return Result<TrajectoryFile>(added.error());
  }
  return rows.Finish("KITTI");
}

bool IsC3d(std::string_view bytes) {
  return bytes.size() > 512 && bytes[0] > 0 && bytes[0] < 32 && bytes[1] == '\x50';
}

}  // namespace

Result<TrajectoryFile> ReadTrajectoryText(std::string bytes, const std::string& path,
                                          const std::string& body, const Limits& limits) {
  if (bytes.empty()) return Error{path + ": empty file"};
  if (IsC3d(bytes)) {
    return Error{path + ": a C3D file has points, no attitudes: export the rigid body's poses as " +
                 "CSV or TSV instead"};
  }
  auto text = DecodeText(std::move(bytes), path);
  if (!text) return text.error();
  const TextGrid grid = TextGrid::Parse(std::move(*text));
  if (grid.rows().empty()) {
    return Error{path + ":1: no rows: expected poses (t x y z qx qy qz qw), got no row of numbers"};
  }
  if (auto motive = ReadMotive(grid, path, body)) return *motive;
  if (auto vicon = ReadVicon(grid, path, body)) return *vicon;
  if (auto qualisys = ReadQualisys(grid, path, body)) return *qualisys;
  if (!body.empty()) {
    return Error{path + ": has one trajectory without a name: expected no name, got " + body};
  }
  if (auto kitti = ReadKitti(grid, path, limits)) return *kitti;
  return ReadTable(grid, path);
}

}  // namespace tagtwist::internal

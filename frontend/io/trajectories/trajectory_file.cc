#include "frontend/io/trajectories/trajectory_file.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string_view>
#include <utility>

#include "frontend/base/files/input_file.h"
#include "frontend/io/mat/mat_file.h"
#include "frontend/io/tables/csv.h"
#include "frontend/io/tables/stamps.h"
#include "frontend/io/trajectories/mat_truth.h"
#include "frontend/io/trajectories/truth_parts.h"

namespace tagtwist {
namespace {

// The twist's six columns under either set of names; empty when there is none of them.
Result<std::vector<size_t>> FindTwistColumns(const CsvTable& table) {
  const std::vector<std::string> own = {"vx_world", "vy_world", "vz_world",
                                        "wx_body",  "wy_body",  "wz_body"};
  const std::vector<std::string> aliases = {"vx", "vy", "vz", "wx", "wy", "wz"};
  for (const auto* names : {&own, &aliases}) {
    for (const std::string& name : *names) {
      if (table.FindColumn(name)) return table.RequireColumns(*names);
    }
  }
  return std::vector<size_t>{};
}

Result<std::vector<TruthSample>> TruthFromTable(const CsvTable& table) {
  const auto stamp_column = table.RequireColumns({"t"});
  if (!stamp_column) return stamp_column.error();
  const auto pose_columns = table.RequireColumns({"x", "y", "z", "qx", "qy", "qz", "qw"});
  if (!pose_columns) return pose_columns.error();
  const auto twist_columns = FindTwistColumns(table);
  if (!twist_columns) return twist_columns.error();
  if (table.rows() == 0) return Error{table.path() + ": no rows"};
  const auto stamps = ReadGrowingStamps(table, stamp_column->front(), TimeUnit::kSeconds);
  if (!stamps) return stamps.error();
  std::vector<TruthSample> truth;
  truth.reserve(table.rows());
  for (size_t row = 0; row < table.rows(); ++row) {
    const auto numbers = table.Numbers(row, *pose_columns);
    if (!numbers) return numbers.error();
    const auto pose = PoseFromNumbers(*numbers);
    if (!pose) return table.ErrorAt(row, pose.error().message);
    const auto n = table.Numbers(row, *twist_columns);
    if (!n) return n.error();
    truth.push_back({(*stamps)[row], *pose, std::nullopt});
    if (!n->empty()) {
      truth.back().twist = Twist{Eigen::Vector3d(n->data()), Eigen::Vector3d(n->data() + 3)};
    }
  }
  return truth;
}

std::vector<std::string_view> SplitAtBlanks(std::string_view line) {
  std::vector<std::string_view> out;
  for (;;) {
    const size_t first = line.find_first_not_of(" \t\r");
    if (first == std::string_view::npos) return out;
    line.remove_prefix(first);
    const size_t end = std::min(line.find_first_of(" \t\r"), line.size());
    out.push_back(line.substr(0, end));
    line.remove_prefix(end);
  }
}

// A TUM line's sample; the fault without file and line otherwise.
Result<TruthSample> SampleFromTumFields(const std::vector<std::string_view>& fields) {
  if (fields.size() != 8) {
    return Error{"expected t x y z qx qy qz qw, got " + std::to_string(fields.size()) + " fields"};
  }
  const auto t_ns = ParseSeconds(fields[0]);
  if (!t_ns) return Error{"expected a time in seconds, got " + QuoteForMessage(fields[0])};
  std::vector<double> numbers;
  for (size_t i = 1; i < 8; ++i) {
    const auto number = ParseNumber(fields[i]);
    if (!number) return Error{"expected a finite number, got " + QuoteForMessage(fields[i])};
    numbers.push_back(*number);
  }
  const auto pose = PoseFromNumbers(numbers);
  if (!pose) return pose.error();
  return TruthSample{*t_ns, *pose, std::nullopt};
}

Result<std::vector<TruthSample>> TruthFromTum(std::string_view text, const std::string& path) {
  std::vector<TruthSample> truth;
  for (int line_number = 1; !text.empty(); ++line_number) {
    const size_t end = std::min(text.find('\n'), text.size());
    const auto fields = SplitAtBlanks(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
    if (fields.empty() || fields[0][0] == '#') continue;
    const std::string place = path + ":" + std::to_string(line_number) + ": ";
    const auto sample = SampleFromTumFields(fields);
    if (!sample) return Error{place + sample.error().message};
    if (!truth.empty()) {
      if (const auto fault = StampFault(truth.back().t_ns, sample->t_ns)) {
        return Error{place + *fault};
      }
    }
    truth.push_back(*sample);
  }
  if (truth.empty()) return Error{path + ": no rows"};
  return truth;
}

// The first line that is no comment decides: TUM has no comma in it.
bool LooksLikeTum(std::string_view text) {
  while (!text.empty()) {
    const std::string_view line = text.substr(0, text.find('\n'));
    text.remove_prefix(std::min(line.size() + 1, text.size()));
    const bool comment = SplitAtBlanks(line).empty() || SplitAtBlanks(line)[0][0] == '#';
    if (!comment) return line.find(',') == std::string_view::npos;
  }
  return false;
}

}  // namespace

Result<Pose> PoseFromNumbers(const std::vector<double>& xyz_qxyzw) {
  const std::vector<double>& n = xyz_qxyzw;
  const Eigen::Quaterniond rotation(n[6], n[3], n[4], n[5]);
  const double norm = rotation.norm();
  if (!(std::abs(norm - 1) <= 1e-2)) {
    return Error{"quaternion: expected unit norm, got " + FormatNumber(norm)};
  }
  return MakePose(rotation.normalized(), {n[0], n[1], n[2]});
}

bool AllHaveTwist(const std::vector<TruthSample>& truth) {
  for (const TruthSample& sample : truth) {
    if (!sample.twist) return false;
  }
  return !truth.empty();
}

Result<std::vector<TruthSample>> ReadGroundTruth(const std::string& path) {
  if (IsMatFile(path)) return ReadMatTruth(path);
  auto text = ReadWholeFile(path);
  if (!text) return text.error();
  if (LooksLikeTum(*text)) return TruthFromTum(*text, path);
  const auto table = CsvTable::Parse(std::move(*text), path);
  if (!table) return table.error();
  if (LooksLikeEurocTruth(*table)) return TruthFromEurocTable(*table, {});
  return TruthFromTable(*table);
}

std::string FormatGroundTruthCsv(const std::vector<TruthSample>& truth) {
  const bool with_twist = AllHaveTwist(truth);
  std::string out = "t,x,y,z,qx,qy,qz,qw";
  if (with_twist) out += ",vx_world,vy_world,vz_world,wx_body,wy_body,wz_body";
  out += "\n";
  for (const TruthSample& sample : truth) {
    out += FormatSeconds(sample.t_ns);
    for (const double x : sample.world_from_body.translation()) out += "," + FormatNumber(x);
    const Eigen::Vector4d q = sample.world_from_body.rotation().coeffs();
    for (const double x : q) out += "," + FormatNumber(x);
    if (with_twist) {
      for (const double x : sample.twist->v_world) out += "," + FormatNumber(x);
      for (const double x : sample.twist->omega_body) out += "," + FormatNumber(x);
    }
    out += "\n";
  }
  return out;
}

std::string FormatTumLine(int64_t t_ns, const Pose& world_from_body) {
  std::string out = FormatSeconds(t_ns);
  for (const double x : world_from_body.translation()) out += " " + FormatNumber(x);
  const Eigen::Vector4d q = world_from_body.rotation().coeffs();  // rotation() is a temporary
  for (const double x : q) out += " " + FormatNumber(x);
  return out + "\n";
}

std::string FormatTum(const std::vector<TruthSample>& trajectory) {
  std::string out = "# t x y z qx qy qz qw\n";
  for (const TruthSample& sample : trajectory) {
    out += FormatTumLine(sample.t_ns, sample.world_from_body);
  }
  return out;
}

std::vector<Eigen::Vector3d> DifferentiateAttitude(const std::vector<TruthSample>& truth) {
  std::vector<Eigen::Vector3d> out(truth.size(), Eigen::Vector3d::Zero());
  for (size_t i = 0; truth.size() >= 2 && i < truth.size(); ++i) {
    const TruthSample& before = truth[i == 0 ? 0 : i - 1];
    const TruthSample& after = truth[std::min(i + 1, truth.size() - 1)];
    out[i] = TwistBetween(before.world_from_body, after.world_from_body,
                          ToSeconds(after.t_ns - before.t_ns))
                 .omega_body;
  }
  return out;
}

}  // namespace tagtwist

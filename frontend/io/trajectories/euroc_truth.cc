#include <cmath>
#include <cstdlib>

#include "frontend/io/tables/stamps.h"
#include "frontend/io/trajectories/trajectory_file.h"
#include "frontend/io/trajectories/truth_parts.h"

namespace tagtwist::internal {
namespace {

constexpr int64_t kMaxGyroDistanceNs = 10'000'000;

using Columns = std::vector<size_t>;

// The three columns prefix_x, prefix_y, prefix_z, or none of them.
Result<Columns> OptionalVector(const CsvTable& table, const std::string& prefix) {
  if (!table.FindColumn(prefix + "_x")) return Columns{};
  return table.RequireColumns({prefix + "_x", prefix + "_y", prefix + "_z"});
}

struct EurocColumns {
  Columns pose;  // x y z qx qy qz qw
  Columns velocity, rate, gyro_bias;
};

Result<EurocColumns> FindEurocColumns(const CsvTable& table) {
  EurocColumns out;
  auto pose = table.RequireColumns(
      {"p_RS_R_x", "p_RS_R_y", "p_RS_R_z", "q_RS_x", "q_RS_y", "q_RS_z", "q_RS_w"});
  if (!pose) return pose.error();
  out.pose = std::move(*pose);
  for (const auto& [prefix, columns] :
       {std::pair{"v_RS_R", &out.velocity}, {"w_RS_S", &out.rate}, {"b_w_RS_S", &out.gyro_bias}}) {
    auto found = OptionalVector(table, prefix);
    if (!found) return found.error();
    *columns = std::move(*found);
  }
  return out;
}

Result<Eigen::Vector3d> ReadVector(const CsvTable& table, size_t row, const Columns& columns) {
  if (columns.empty()) return Eigen::Vector3d(Eigen::Vector3d::Zero());
  const auto numbers = table.Numbers(row, columns);
  if (!numbers) return numbers.error();
  return Eigen::Vector3d(numbers->data());
}

// True where the attitude of a pose is a quaternion of zero: nothing was tracked.
bool IsZero(const CsvTable& table, size_t row, const Columns& pose) {
  const auto n = table.Numbers(row, pose);
  return n && (*n)[3] == 0 && (*n)[4] == 0 && (*n)[5] == 0 && (*n)[6] == 0;
}

// Index of the IMU sample to take a rate from; imu.size() when none is near enough.
size_t FindGyro(const std::vector<int64_t>& imu_stamps_ns, int64_t t_ns) {
  if (imu_stamps_ns.empty()) return 0;
  const size_t nearest = NearestIndex(imu_stamps_ns, t_ns);
  return std::abs(imu_stamps_ns[nearest] - t_ns) <= kMaxGyroDistanceNs ? nearest
                                                                       : imu_stamps_ns.size();
}

Status FillRates(const CsvTable& table, const EurocColumns& columns,
                 const std::vector<ImuSample>& imu, const std::vector<size_t>& rows,
                 std::vector<TruthSample>* truth) {
  const std::vector<Eigen::Vector3d> differences = DifferentiateAttitude(*truth);
  std::vector<int64_t> imu_stamps_ns;
  imu_stamps_ns.reserve(imu.size());
  for (const ImuSample& sample : imu) imu_stamps_ns.push_back(sample.t_ns);
  for (size_t i = 0; i < truth->size(); ++i) {
    TruthSample& sample = (*truth)[i];
    const size_t row = rows[i];
    const auto bias = ReadVector(table, row, columns.gyro_bias);
    if (!bias) return bias.error();
    const auto rate = ReadVector(table, row, columns.rate);
    if (!rate) return rate.error();
    const size_t gyro = FindGyro(imu_stamps_ns, sample.t_ns);
    sample.twist->omega_body = !columns.rate.empty() ? *rate
                               : gyro < imu.size()   ? Eigen::Vector3d(imu[gyro].gyro_radps - *bias)
                                                     : differences[i];
  }
  return Ok();
}

}  // namespace

bool LooksLikeEurocTruth(const CsvTable& table) {
  return table.FindColumn("p_RS_R_x") && table.FindColumn("timestamp");
}

Result<std::vector<TruthSample>> TruthFromEurocTable(const CsvTable& table,
                                                     const std::vector<ImuSample>& imu,
                                                     std::vector<std::string>* notes) {
  const auto stamp_column = table.RequireColumns({"timestamp"});
  if (!stamp_column) return stamp_column.error();
  const auto columns = FindEurocColumns(table);
  if (!columns) return columns.error();
  if (table.rows() == 0) return Error{table.path() + ": no rows"};
  const auto stamps = ReadStamps(table, stamp_column->front(), TimeUnit::kNanoseconds);
  if (!stamps) return stamps.error();
  std::vector<TruthSample> truth;
  std::vector<size_t> rows;
  size_t without = 0;
  for (size_t i = 0; i < stamps->rows.size(); ++i) {
    const size_t row = stamps->rows[i];
    if (HasNan(table, row, columns->pose) || IsZero(table, row, columns->pose)) {
      ++without;
      continue;
    }
    const auto numbers = table.Numbers(row, columns->pose);
    if (!numbers) return numbers.error();
    const auto pose = PoseFromNumbers(*numbers);
    if (!pose) return table.ErrorAt(row, pose.error().message);
    const auto velocity = ReadVector(table, row, columns->velocity);
    if (!velocity) return velocity.error();
    TruthSample sample{stamps->stamps_ns[i], *pose, std::nullopt};
    if (!columns->velocity.empty()) sample.twist = Twist{*velocity, Eigen::Vector3d::Zero()};
    truth.push_back(sample);
    rows.push_back(row);
  }
  if (notes != nullptr) {
    notes->insert(notes->end(), stamps->notes.begin(), stamps->notes.end());
    if (without > 0) {
      notes->push_back(table.path() + ": passed over " + std::to_string(without) +
                       " rows without a pose");
    }
  }
  if (truth.empty()) return Error{table.path() + ": no row has a pose"};
  if (columns->velocity.empty()) return truth;
  if (const auto filled = FillRates(table, *columns, imu, rows, &truth); !filled)
    return filled.error();
  return truth;
}

std::string FormatEurocTruth(const std::vector<TruthSample>& truth) {
  const bool with_twist = AllHaveTwist(truth);
  std::string out =
      "#timestamp [ns],p_RS_R_x [m],p_RS_R_y [m],p_RS_R_z [m],q_RS_w [],q_RS_x [],q_RS_y [],q_RS_z "
      "[]";
  if (with_twist) {
    out +=
        ",v_RS_R_x [m s^-1],v_RS_R_y [m s^-1],v_RS_R_z [m s^-1],b_w_RS_S_x [rad s^-1],b_w_RS_S_y "
        "[rad s^-1],b_w_RS_S_z [rad s^-1],b_a_RS_S_x [m s^-2],b_a_RS_S_y [m s^-2],b_a_RS_S_z [m "
        "s^-2],w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad s^-1]";
  }
  out += "\n";
  for (const TruthSample& sample : truth) {
    const Eigen::Quaterniond q = sample.world_from_body.rotation();
    out += std::to_string(sample.t_ns);
    for (const double x : sample.world_from_body.translation()) out += "," + FormatNumber(x);
    for (const double x : {q.w(), q.x(), q.y(), q.z()}) out += "," + FormatNumber(x);
    if (with_twist) {
      for (const double x : sample.twist->v_world) out += "," + FormatNumber(x);
      out += ",0,0,0,0,0,0";
      for (const double x : sample.twist->omega_body) out += "," + FormatNumber(x);
    }
    out += "\n";
  }
  return out;
}

}  // namespace tagtwist::internal

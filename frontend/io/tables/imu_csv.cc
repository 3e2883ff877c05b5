#include "frontend/io/tables/imu_csv.h"

namespace tagtwist::internal {
namespace {

// Stamp, accelerometer, gyroscope.
std::vector<std::string> ColumnNames(TimeUnit unit) {
  if (unit == TimeUnit::kSeconds) return {"t", "ax", "ay", "az", "gx", "gy", "gz"};
  return {"timestamp", "a_RS_S_x", "a_RS_S_y", "a_RS_S_z", "w_RS_S_x", "w_RS_S_y", "w_RS_S_z"};
}

void AppendVector(const Eigen::Vector3d& v, std::string* out) {
  for (const double x : v) *out += "," + FormatNumber(x);
}

}  // namespace

Result<std::vector<ImuSample>> ReadImuCsv(const std::string& path, TimeUnit unit,
                                          std::vector<std::string>* notes, const Limits& limits) {
  const auto table = CsvTable::Read(path, limits);
  if (!table) return table.error();
  auto columns = table->RequireColumns(ColumnNames(unit));
  if (!columns) return columns.error();
  const auto stamps = ReadStamps(*table, columns->front(), unit);
  if (!stamps) return stamps.error();
  columns->erase(columns->begin());
  std::vector<ImuSample> out;
  size_t without = 0;
  for (size_t i = 0; i < stamps->rows.size(); ++i) {
    const size_t row = stamps->rows[i];
    if (HasNan(*table, row, *columns)) {
      ++without;
      continue;
    }
    const auto n = table->Numbers(row, *columns);
    if (!n) return n.error();
    out.push_back(
        {stamps->stamps_ns[i], Eigen::Vector3d(n->data()), Eigen::Vector3d(n->data() + 3)});
  }
  if (notes == nullptr) return out;
  notes->insert(notes->end(), stamps->notes.begin(), stamps->notes.end());
  if (without > 0) {
    notes->push_back(path + ": passed over " + std::to_string(without) + " rows without numbers");
  }
  return out;
}

std::string FormatImuCsv(const std::vector<ImuSample>& imu, TimeUnit unit) {
  const bool own = unit == TimeUnit::kSeconds;
  std::string out = own ? "t,ax,ay,az,gx,gy,gz\n"
                        : "#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad "
                          "s^-1],a_RS_S_x [m s^-2],a_RS_S_y [m s^-2],a_RS_S_z [m s^-2]\n";
  for (const ImuSample& sample : imu) {
    out += FormatStamp(sample.t_ns, unit);
    AppendVector(own ? sample.accel_mps2 : sample.gyro_radps, &out);
    AppendVector(own ? sample.gyro_radps : sample.accel_mps2, &out);
    out += "\n";
  }
  return out;
}

}  // namespace tagtwist::internal

#include <filesystem>
#include <string>

#include "frontend/io/recordings/image_list_source.h"
#include "frontend/io/tables/imu_csv.h"
#include "frontend/io/trajectories/truth_parts.h"

namespace tagtwist::internal {

std::string EurocTags(const std::string& camera) {
  const size_t number = camera.find_first_of("0123456789");
  return "tags" + (number == std::string::npos ? "" : camera.substr(number));
}

Result<std::unique_ptr<DataSource>> OpenEurocSource(const std::string& folder,
                                                    const std::string& camera,
                                                    const DataSourceOptions& options) {
  const std::filesystem::path root(folder);
  ListingFiles files;
  files.table = (root / camera / "data.csv").string();
  files.stamp_column = "timestamp";
  files.file_column = "filename";
  files.image_folder = (root / camera / "data").string();
  files.detections = (root / EurocTags(camera) / "data.csv").string();
  files.unit = TimeUnit::kNanoseconds;
  auto list = ReadImageList(files, options);
  if (!list) return list.error();
  std::error_code unknown;
  if (const auto path = root / "imu0" / "data.csv"; std::filesystem::exists(path, unknown)) {
    auto imu = ReadImuCsv(path.string(), TimeUnit::kNanoseconds, &list->notes, options.limits);
    if (!imu) return imu.error();
    list->imu = std::move(*imu);
  }
  for (const char* name : {"state_groundtruth_estimate0", "vicon0", "mocap0"}) {
    const auto path = root / name / "data.csv";
    if (!list->ground_truth.empty() || !std::filesystem::exists(path, unknown)) continue;
    const auto table = CsvTable::Read(path.string(), options.limits);
    if (!table) return table.error();
    auto truth = TruthFromEurocTable(*table, list->imu, &list->notes);
    if (!truth) return truth.error();
    list->ground_truth = std::move(*truth);
    list->truth_origin = path.string();
  }
  if (list->ground_truth.empty() && std::filesystem::exists(root / "leica0", unknown)) {
    list->notes.push_back((root / "leica0").string() +
                          ": positions alone are not compared with: not read");
  }
  return MakeImageListSource(std::move(*list), options);
}

}  // namespace tagtwist::internal

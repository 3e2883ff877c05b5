#include <filesystem>

#include "frontend/io/recordings/image_list_source.h"
#include "frontend/io/tables/imu_csv.h"
#include "frontend/io/trajectories/truth_parts.h"

namespace tagtwist {

Result<std::unique_ptr<DataSource>> OpenEurocSource(const std::string& folder,
                                                    const DataSourceOptions& options) {
  const std::filesystem::path root(folder);
  ListingFiles files;
  files.table = (root / "cam0" / "data.csv").string();
  files.stamp_column = "timestamp";
  files.file_column = "filename";
  files.image_folder = (root / "cam0" / "data").string();
  files.detections = (root / "tags0" / "data.csv").string();
  files.unit = TimeUnit::kNanoseconds;
  auto list = ReadImageList(files, options);
  if (!list) return list.error();
  std::error_code unknown;
  if (const auto path = root / "imu0" / "data.csv"; std::filesystem::exists(path, unknown)) {
    auto imu = ReadImuCsv(path.string(), TimeUnit::kNanoseconds);
    if (!imu) return imu.error();
    list->imu = std::move(*imu);
  }
  const auto truth_path = root / "state_groundtruth_estimate0" / "data.csv";
  if (std::filesystem::exists(truth_path, unknown)) {
    const auto table = CsvTable::Read(truth_path.string());
    if (!table) return table.error();
    auto truth = TruthFromEurocTable(*table, list->imu);
    if (!truth) return truth.error();
    list->ground_truth = std::move(*truth);
  }
  return MakeImageListSource(std::move(*list), options);
}

}  // namespace tagtwist

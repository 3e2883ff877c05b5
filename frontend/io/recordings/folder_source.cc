#include <filesystem>

#include "frontend/io/recordings/image_list_source.h"
#include "frontend/io/tables/imu_csv.h"
#include "frontend/io/trajectories/trajectory_file.h"

namespace tagtwist::internal {

Status ReadTruthAndImu(const std::string& folder, const Limits& limits, ImageList* list) {
  const std::filesystem::path root(folder);
  std::error_code unknown;
  if (const auto path = root / "ground_truth.csv"; std::filesystem::exists(path, unknown)) {
    auto truth = ReadTrajectoryFile(path.string(), "", limits);
    if (!truth) return truth.error();
    list->ground_truth = std::move(truth->samples);
    list->truth_origin = path.string();
    list->notes.insert(list->notes.end(), truth->notes.begin(), truth->notes.end());
  }
  if (const auto path = root / "imu.csv"; std::filesystem::exists(path, unknown)) {
    auto imu = ReadImuCsv(path.string(), TimeUnit::kSeconds, &list->notes, limits);
    if (!imu) return imu.error();
    list->imu = std::move(*imu);
  }
  return Ok();
}

Result<std::unique_ptr<DataSource>> OpenFolderSource(const std::string& folder,
                                                     const DataSourceOptions& options) {
  const std::filesystem::path root(folder);
  ListingFiles files;
  files.table = (root / "timestamps.csv").string();
  files.stamp_column = "t";
  files.file_column = "file";
  files.image_folder = folder;
  files.detections = (root / "detections.csv").string();
  auto list = ReadImageList(files, options);
  if (!list) return list.error();
  if (const Status read = ReadTruthAndImu(folder, options.limits, &*list); !read) {
    return read.error();
  }
  return MakeImageListSource(std::move(*list), options);
}

}  // namespace tagtwist::internal

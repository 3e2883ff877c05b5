#include <filesystem>
#include <optional>
#include <string_view>

#include "frontend/base/files/input_file.h"
#include "frontend/io/mat/mat_file.h"
#include "frontend/io/recordings/data_source.h"
#include "frontend/io/recordings/data_source_kinds.h"

namespace tagtwist {

using namespace internal;
namespace {

bool Exists(const std::filesystem::path& path) {
  std::error_code unknown;
  return std::filesystem::exists(path, unknown);
}

// One of EuRoC's cameras, cam1 with data.csv of its own, without a slash at its end.
std::optional<std::filesystem::path> EurocCamera(const std::filesystem::path& root,
                                                 const DataSourceOptions& options) {
  auto path = root.lexically_normal();
  if (!path.has_filename()) path = path.parent_path();
  if (path.filename().string().rfind("cam", 0) != 0) return std::nullopt;
  const auto tags = path.parent_path() / EurocTags(path.filename().string()) / "data.csv";
  const bool is_one = Exists(path / "data.csv") || (options.use_detections && Exists(tags));
  return is_one ? std::optional(path) : std::nullopt;
}

bool IsBagFile(const std::string& path) {
  constexpr std::string_view kBagMagic = "#ROSBAG";
  return FirstBytes(path, kBagMagic.size()) == kBagMagic;
}

}  // namespace

const std::vector<TruthSample>& DataSource::ground_truth() const {
  static const std::vector<TruthSample> none;
  return none;
}

const std::vector<ImuSample>& DataSource::imu() const {
  static const std::vector<ImuSample> none;
  return none;
}

Status DataSource::Skip(size_t frames) {
  for (size_t i = 0; i < frames; ++i) {
    const auto frame = Next();
    if (!frame) return frame.error();
    if (!*frame) break;
  }
  return Ok();
}

const std::vector<std::string>& DataSource::notes() const {
  static const std::vector<std::string> none;
  return none;
}

Result<std::unique_ptr<DataSource>> OpenDataSource(const std::string& path,
                                                   const DataSourceOptions& options) {
  const std::filesystem::path root(path);
  std::error_code unknown;
  if (!Exists(root)) return Error{path + ": no such file or folder"};
  const bool is_folder = std::filesystem::is_directory(root, unknown);
  if (!is_folder) {
    if (const auto regular = CheckRegularFile(path); !regular) return regular.error();
  }
  if (IsRos2Bag(path)) return OpenRos2Source(path, options);
  if (!is_folder) {
    if (IsMatFile(path)) return OpenMatSource(path, options);
    if (IsBagFile(path)) return OpenBagSource(path, options);
    if (std::filesystem::is_regular_file(root, unknown) &&
        std::filesystem::file_size(root, unknown) == 0) {
      return Error{path + ": empty file"};
    }
    return OpenVideoSource(path, options);
  }
  // Where detections are used, tags0 stands for a missing cam0.
  for (const auto& folder : {root / "mav0", root}) {
    const bool tags = options.use_detections && Exists(folder / "tags0" / "data.csv");
    if (tags || Exists(folder / "cam0" / "data.csv")) {
      return OpenEurocSource(folder.string(), "cam0", options);
    }
  }
  if (const auto camera = EurocCamera(root, options)) {
    return OpenEurocSource(camera->parent_path().string(), camera->filename().string(), options);
  }
  if (Exists(root / "timestamps.csv")) return OpenFolderSource(path, options);
  if (Exists(root / "detections.csv")) {
    if (options.use_detections) return OpenFolderSource(path, options);
    return Error{path +
                 ": no timestamps.csv; its detections.csv can stand for it only where "
                 "detections are used"};
  }
  if (!options.use_detections && HasNamedImages(path)) return OpenNamedImagesSource(path, options);
  return Error{path +
               ": expected a data set (timestamps.csv, mav0/cam0/data.csv, or images with stamps "
               "for names), got none"};
}

}  // namespace tagtwist

// Readers of recordings: opened with the data set's own corners and without, read to the end.
#include <filesystem>

#include "frontend/io/recordings/data_source.h"
#include "frontend/io/recordings/data_source_kinds.h"
#include "tests/fuzz/fuzz_file.h"
#include "tests/fuzz/fuzz_target.h"

namespace tagtwist::internal {
namespace {

constexpr int kMostFrames = 200;  // of one file, read here

using Opened = Result<std::unique_ptr<DataSource>>;

void ReadThrough(DataSource* source) {
  const std::vector<int64_t>& stamps = source->stamps_ns();
  for (size_t i = 1; i < stamps.size(); ++i) {
    Promise(stamps[i] > stamps[i - 1], "stamps that do not grow");
  }
  const auto& truth = source->ground_truth();
  for (size_t i = 1; i < truth.size(); ++i) {
    Promise(truth[i].t_ns > truth[i - 1].t_ns, "stamps of truth that do not grow");
  }
  for (const std::string& note : source->notes()) {
    Promise(note.find('\n') == std::string::npos, "a note of more than one line: " + note);
  }
  int64_t last_ns = 0;
  for (int i = 0; i < kMostFrames; ++i) {
    const auto frame = source->Next();
    if (!IsTaken(frame) || !*frame) return;
    Promise(i == 0 || (*frame)->t_ns > last_ns, "frames whose stamps do not grow");
    last_ns = (*frame)->t_ns;
    for (const TagDetection& tag : (*frame)->detections) {
      for (const auto& corner : tag.corners) Promise(corner.allFinite(), "a corner nowhere");
    }
  }
}

bool OpenBothWays(Opened (*open)(const std::string&, const DataSourceOptions&),
                  const std::string& path) {
  bool taken = false;
  for (const bool use_detections : {false, true}) {
    DataSourceOptions options;
    options.use_detections = use_detections;
    const auto source = open(path, options);
    if (!IsTaken(source)) continue;
    taken = true;
    ReadThrough(source->get());
  }
  return taken;
}

}  // namespace

bool FuzzBag(const std::string& bytes) {
  const FuzzFile file(bytes);
  return OpenBothWays(OpenBagSource, file.path());
}

bool FuzzMat(const std::string& bytes) {
  const FuzzFile file(bytes);
  return OpenBothWays(OpenMatSource, file.path());
}

bool FuzzRos2(const std::string& bytes) {
  const FuzzFile file(bytes);
  return IsRos2Bag(file.path()) && OpenBothWays(OpenRos2Source, file.path());
}

bool FuzzVideo(const std::string& bytes) {
  const FuzzFile file(bytes);
  const auto source = OpenVideoSource(file.path(), {});
  if (!IsTaken(source)) return false;
  ReadThrough(source->get());
  return true;
}

bool FuzzFolder(const std::string& bytes) {
  const TempFolder folder;
  WriteTree(UnpackTree(bytes), folder.path());
  const bool taken = OpenBothWays(OpenFolderSource, folder.path());
  const bool named =
      HasNamedImages(folder.path()) && OpenBothWays(OpenNamedImagesSource, folder.path());
  return taken || named;
}

namespace {

Result<std::unique_ptr<DataSource>> OpenFirstEurocCamera(const std::string& folder,
                                                         const DataSourceOptions& options) {
  return OpenEurocSource(folder, "cam0", options);
}

}  // namespace

bool FuzzEuroc(const std::string& bytes) {
  const TempFolder folder;
  WriteTree(UnpackTree(bytes), folder.path());
  const std::string mav0 = folder / "mav0";
  return OpenBothWays(OpenFirstEurocCamera, std::filesystem::exists(mav0) ? mav0 : folder.path());
}

}  // namespace tagtwist::internal

#include <filesystem>

#include "frontend/io/recordings/dataset_writer.h"
#include "frontend/io/recordings/dataset_writer_kinds.h"
#include "frontend/io/tables/stamps.h"

namespace tagtwist::internal {

Status FrameRules::Check(const FrameToWrite& frame, const std::string& path) {
  const std::string place = path + ": frame " + std::to_string(frames_) + ": ";
  if (frames_ > 0) {
    if (const auto fault = StampFault(previous_ns_, frame.t_ns)) return Error{place + *fault};
  }
  if (!frame.image.empty()) {
    if (frame.image.type() != CV_8UC1) return Error{place + "expected an 8-bit gray image"};
    if (size_.empty()) size_ = frame.image.size();
    if (frame.image.size() != size_) return Error{place + "the image's size differs"};
  }
  previous_ns_ = frame.t_ns;
  ++frames_;
  return Ok();
}

Result<std::unique_ptr<DatasetWriter>> CreateDatasetWriter(const std::string& path,
                                                           DatasetFormat format) {
  std::error_code unknown;
  const bool folder = std::filesystem::is_directory(path, unknown);
  const bool taken =
      folder ? format == DatasetFormat::kMat || !std::filesystem::is_empty(path, unknown)
             : std::filesystem::exists(path, unknown);
  if (taken) {
    return Error{path + (folder && format != DatasetFormat::kMat
                             ? ": exists already and is not empty"
                             : ": exists already")};
  }
  switch (format) {
    case DatasetFormat::kFolder:
      return CreateFolderWriter(path);
    case DatasetFormat::kEuroc:
      return CreateEurocWriter(path);
    case DatasetFormat::kMat:
      break;
  }
  return CreateMatWriter(path);
}

}  // namespace tagtwist::internal

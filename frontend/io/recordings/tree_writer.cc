#include <array>
#include <cstdio>
#include <filesystem>
#include <utility>

#include "frontend/base/files/atomic_file.h"
#include "frontend/base/files/partial.h"
#include "frontend/io/images/image_file.h"
#include "frontend/io/recordings/dataset_writer_kinds.h"
#include "frontend/io/tables/detections_csv.h"
#include "frontend/io/tables/imu_csv.h"
#include "frontend/io/trajectories/trajectory_file.h"
#include "frontend/io/trajectories/truth_parts.h"

namespace tagtwist::internal {
namespace {

// Where a format keeps what, relative to the data set's folder.
struct Layout {
  bool euroc = false;
  TimeUnit unit = TimeUnit::kSeconds;
  std::string frames, frames_header, image_folder, detections, truth, imu;
};

Layout PlainLayout() {
  return {false,    TimeUnit::kSeconds, "timestamps.csv",   "t,file\n",
          "images", "detections.csv",   "ground_truth.csv", "imu.csv"};
}

Layout EurocLayout() {
  return {true,
          TimeUnit::kNanoseconds,
          "mav0/cam0/data.csv",
          "#timestamp [ns],filename\n",
          "mav0/cam0/data",
          "mav0/tags0/data.csv",
          "mav0/state_groundtruth_estimate0/data.csv",
          "mav0/imu0/data.csv"};
}

// A data set that is a tree of files: the plain folder and EuRoC/ASL.
class TreeWriter : public DatasetWriter {
 public:
  TreeWriter(std::string path, Partial partial, Layout layout)
      : path_(std::move(path)), partial_(std::move(partial)), layout_(std::move(layout)) {}

  Status Add(const FrameToWrite& frame) override {
    if (auto fit = rules_.Check(frame, path_); !fit) return fit;
    frame_rows_ += FormatStamp(frame.t_ns, layout_.unit) + ",";
    if (!frame.image.empty()) {
      const std::string file = ImageFile(frame.t_ns);
      const auto png = EncodePng(frame.image);
      if (!png) return Error{path_ + ": " + png.error().message};
      if (auto written = Write(layout_.image_folder + "/" + file, *png); !written) return written;
      frame_rows_ += (layout_.euroc ? "" : layout_.image_folder + "/") + file;
    }
    frame_rows_ += "\n";
    detection_rows_ += FormatDetections(frame.t_ns, frame.detections, layout_.unit);
    return Ok();
  }

  Status Finish(const std::vector<TruthSample>& truth, const std::vector<ImuSample>& imu) override {
    if (rules_.frames() == 0) return Error{path_ + ": no frames to write"};
    std::vector<std::pair<std::string, std::string>> tables = {
        {layout_.frames, layout_.frames_header + frame_rows_}};
    if (!detection_rows_.empty()) {
      tables.emplace_back(layout_.detections, DetectionsCsvHeader(layout_.unit) + detection_rows_);
    }
    if (!truth.empty()) {
      tables.emplace_back(layout_.truth,
                          layout_.euroc ? FormatEurocTruth(truth) : FormatGroundTruthCsv(truth));
    }
    if (!imu.empty()) tables.emplace_back(layout_.imu, FormatImuCsv(imu, layout_.unit));
    for (const auto& [file, content] : tables) {
      if (auto written = Write(file, content); !written) return written;
    }
    const int failure = partial_.PutAt(path_);
    if (failure == 0) return Ok();
    return Error{path_ + ": cannot write: " + std::generic_category().message(failure)};
  }

 private:
  std::string ImageFile(int64_t t_ns) const {
    if (layout_.euroc) return std::to_string(t_ns) + ".png";
    std::array<char, 32> name;
    std::snprintf(name.data(), name.size(), "%06zu.png", rules_.frames() - 1);
    return name.data();
  }

  Status Write(const std::string& file, const std::string& content) {
    const std::filesystem::path target = std::filesystem::path(partial_.path()) / file;
    std::error_code failure;
    // One level after the other: the partial folder itself does not come back once it was removed.
    std::filesystem::path folder = partial_.path();
    for (const auto& part : std::filesystem::path(file).parent_path()) {
      std::filesystem::create_directory(folder /= part, failure);
    }
    const auto written = WriteFileAtomically(target.string(), content);
    if (written) return Ok();
    // The partial folder is ours alone to know of: name the file by where it would have been.
    const std::string reason = written.error().message.substr(target.string().size());
    return Error{(std::filesystem::path(path_) / file).string() + reason};
  }

  std::string path_;
  Partial partial_;
  Layout layout_;
  FrameRules rules_;
  std::string frame_rows_, detection_rows_;
};

Result<std::unique_ptr<DatasetWriter>> CreateTreeWriter(const std::string& path, Layout layout) {
  auto partial = Partial::Make(path, Partial::Kind::kFolder);
  if (!partial) return partial.error();
  return std::unique_ptr<DatasetWriter>(
      std::make_unique<TreeWriter>(path, std::move(*partial), std::move(layout)));
}

}  // namespace

Result<std::unique_ptr<DatasetWriter>> CreateFolderWriter(const std::string& path) {
  return CreateTreeWriter(path, PlainLayout());
}

Result<std::unique_ptr<DatasetWriter>> CreateEurocWriter(const std::string& path) {
  return CreateTreeWriter(path, EurocLayout());
}

}  // namespace tagtwist::internal

#pragma once
#include <string>
#include <vector>

#include "frontend/io/recordings/data_source_kinds.h"
#include "frontend/io/tables/stamps.h"

namespace tagtwist::internal {

/// A frame of a recording that keeps its images in files.
struct ListedFrame {
  std::string name;        // the image's path; else the place of its row
  std::string image_path;  // empty: no image
  std::vector<TagDetection> detections;
  std::vector<int> doubled_ids = {};  // Frame::doubled_ids
};

/// All of a recording but its images.
struct ImageList {
  std::vector<int64_t> stamps_ns;
  std::vector<ListedFrame> frames;
  std::vector<TruthSample> ground_truth;
  std::vector<ImuSample> imu;
  std::vector<std::string> notes;  // DataSource::notes
  std::string truth_origin;        // DataSource::truth_origin
};

std::unique_ptr<DataSource> MakeImageListSource(ImageList list, const DataSourceOptions& options);

/// ground_truth.csv and imu.csv of a plain folder, where it has them.
Status ReadTruthAndImu(const std::string& folder, const Limits& limits, ImageList* list);

/// How a recording lists its images and detections.
struct ListingFiles {
  std::string table;         // stamps and image files
  std::string stamp_column;  // "t", "timestamp"
  std::string file_column;   // "file", "filename"
  std::string image_folder;  // files are relative to it
  std::string detections;    // the detections' table
  TimeUnit unit = TimeUnit::kSeconds;
};

/// Stamps, image paths and, when the options ask for them, detections. Refuses a listing of which
/// no image exists, except where detections are used: then there are no images.
Result<ImageList> ReadImageList(const ListingFiles& files, const DataSourceOptions& options);

}  // namespace tagtwist::internal

#pragma once
#include <optional>
#include <string>
#include <vector>

#include "frontend/io/recordings/data_source_kinds.h"
#include "frontend/io/tables/detections_reader.h"
#include "frontend/io/tables/stamps.h"

namespace tagtwist::internal {

/// All of a recording but its images and its detections.
struct ImageList {
  std::vector<int64_t> stamps_ns;
  std::string table;                // that lists the frames
  std::vector<int> lines;           // of each frame's row in it; none: no table
  std::vector<std::string> images;  // path of each frame's, or ""; none: no frame has one
  bool images_are_there = true;     // else the paths are names alone
  std::optional<DetectionsReader> detections;  // read as frames are asked for
  bool rows_were_passed_over = false;          // of the table: detections of no frame are theirs
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

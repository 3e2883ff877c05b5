#include "frontend/io/recordings/image_list_source.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <utility>

#include "frontend/io/images/image_file.h"
#include "frontend/io/tables/detections_csv.h"

namespace tagtwist::internal {
namespace {

constexpr int64_t kSameStampNs = 1000;

class ImageListSource : public DataSource {
 public:
  ImageListSource(ImageList list, const DataSourceOptions& options)
      : list_(std::move(list)), options_(options) {}

  Result<std::optional<Frame>> Next() override {
    if (next_ == list_.frames.size()) return std::optional<Frame>();
    ListedFrame& listed = list_.frames[next_];
    Frame frame;
    frame.t_ns = list_.stamps_ns[next_++];
    frame.name = listed.name;
    frame.detections = std::move(listed.detections);
    frame.doubled_ids = std::move(listed.doubled_ids);
    if (!options_.read_images) return std::optional<Frame>(std::move(frame));
    if (listed.image_path.empty()) {
      if (!options_.use_detections) frame.image_problem = "no image file is named";
      return std::optional<Frame>(std::move(frame));
    }
    auto image = ReadGrayImage(listed.image_path, options_.limits);
    if (!image) {
      frame.image_problem = image.error().message;
    } else if (auto fault = size_guard_.Check(*image, listed.image_path)) {
      return *fault;
    } else {
      frame.image = std::move(*image);
    }
    return std::optional<Frame>(std::move(frame));
  }

  Status Skip(size_t frames) override {
    next_ = std::min(list_.frames.size(), next_ + frames);
    return Ok();
  }

  const std::vector<int64_t>& stamps_ns() const override { return list_.stamps_ns; }
  const std::vector<TruthSample>& ground_truth() const override { return list_.ground_truth; }
  const std::vector<ImuSample>& imu() const override { return list_.imu; }
  const std::vector<std::string>& notes() const override { return list_.notes; }
  std::string truth_origin() const override { return list_.truth_origin; }

 private:
  ImageList list_;
  DataSourceOptions options_;
  size_t next_ = 0;
  ImageSizeGuard size_guard_;
};

// Frames from the table of stamps and image files.
Result<ImageList> ListFromTable(const CsvTable& table, const ListingFiles& files,
                                const DataSourceOptions& options) {
  const auto stamp_column = table.RequireColumns({files.stamp_column});
  if (!stamp_column) return stamp_column.error();
  const auto file_column = table.FindColumn(files.file_column);
  if (!file_column && !options.use_detections) {
    return table.RequireColumns({files.file_column}).error();
  }
  if (table.rows() == 0) return Error{table.path() + ": no rows"};
  auto stamps = ReadStamps(table, stamp_column->front(), files.unit);
  if (!stamps) return stamps.error();
  ImageList list;
  list.stamps_ns = std::move(stamps->stamps_ns);
  list.notes = std::move(stamps->notes);
  for (const size_t row : stamps->rows) {
    ListedFrame frame;
    const std::string file(file_column ? table.Cell(row, *file_column) : "");
    if (!file.empty()) {
      frame.image_path = (std::filesystem::path(files.image_folder) / file).string();
    }
    frame.name =
        file.empty() ? table.path() + ":" + std::to_string(table.line(row)) : frame.image_path;
    list.frames.push_back(std::move(frame));
  }
  return list;
}

// Without a table the frames are the stamps of the detections.
ImageList ListFromDetections(std::vector<StampedDetections> detections, const std::string& path) {
  ImageList list;
  for (StampedDetections& rows : detections) {
    list.stamps_ns.push_back(rows.t_ns);
    list.frames.push_back({path + ":" + std::to_string(rows.line), "", std::move(rows.tags),
                           std::move(rows.doubled_ids)});
  }
  return list;
}

Status AttachDetections(std::vector<StampedDetections> detections, const std::string& path,
                        bool rows_were_passed_over, ImageList* list) {
  for (StampedDetections& rows : detections) {
    const size_t nearest = NearestIndex(list->stamps_ns, rows.t_ns);
    if (std::abs(list->stamps_ns[nearest] - rows.t_ns) > kSameStampNs) {
      if (rows_were_passed_over) continue;  // the frame's row was one of them
      return Error{path + ":" + std::to_string(rows.line) + ": stamp " + FormatSeconds(rows.t_ns) +
                   " s is no frame's"};
    }
    auto& [name, image_path, tags, doubled_ids] = list->frames[nearest];
    tags.insert(tags.end(), rows.tags.begin(), rows.tags.end());
    doubled_ids.insert(doubled_ids.end(), rows.doubled_ids.begin(), rows.doubled_ids.end());
  }
  return Ok();
}

bool AnyImageExists(const ImageList& list) {
  std::error_code unknown;
  for (const ListedFrame& frame : list.frames) {
    if (!frame.image_path.empty() && std::filesystem::exists(frame.image_path, unknown)) {
      return true;
    }
  }
  return false;
}

}  // namespace

std::optional<Error> ImageSizeGuard::Check(const cv::Mat& image, const std::string& name) {
  if (first_name_.empty()) {
    size_ = image.size();
    first_name_ = name;
  }
  if (image.size() == size_) return std::nullopt;
  const auto describe = [](const cv::Size& size) {
    return std::to_string(size.width) + " x " + std::to_string(size.height);
  };
  return Error{name + ": expected " + describe(size_) + " px like " + first_name_ + ", got " +
               describe(image.size())};
}

std::unique_ptr<DataSource> MakeImageListSource(ImageList list, const DataSourceOptions& options) {
  return std::make_unique<ImageListSource>(std::move(list), options);
}

Result<ImageList> ReadImageList(const ListingFiles& files, const DataSourceOptions& options) {
  std::vector<StampedDetections> detections;
  std::vector<std::string> notes;
  if (options.use_detections) {
    auto read = ReadDetectionsCsv(files.detections, files.unit, options.known_tag_ids, &notes,
                                  options.limits);
    if (!read) return read.error();
    detections = std::move(*read);
    std::error_code unknown;
    if (!std::filesystem::exists(files.table, unknown)) {
      if (detections.empty()) return Error{files.detections + ": no rows"};
      ImageList list = ListFromDetections(std::move(detections), files.detections);
      list.notes = std::move(notes);
      return list;
    }
  }
  const auto table = CsvTable::Read(files.table, options.limits);
  if (!table) return table.error();
  auto list = ListFromTable(*table, files, options);
  if (!list) return list;
  const bool rows_were_passed_over = !list->notes.empty();
  list->notes.insert(list->notes.end(), notes.begin(), notes.end());
  if (const Status attached =
          AttachDetections(std::move(detections), files.detections, rows_were_passed_over, &*list);
      !attached) {
    return attached.error();
  }
  if (!options.read_images || AnyImageExists(*list)) return list;
  if (!options.use_detections) {
    return table->ErrorAt(0, "none of the images exists, the first is " +
                                 QuoteForMessage(list->frames.front().image_path));
  }
  for (ListedFrame& frame : list->frames) frame.image_path.clear();
  return list;
}

}  // namespace tagtwist::internal

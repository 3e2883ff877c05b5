#include "frontend/io/recordings/image_list_source.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <utility>

#include "frontend/io/images/image_file.h"
#include "frontend/io/tables/csv.h"

namespace tagtwist::internal {
namespace {

constexpr int64_t kSameStampNs = 1000;

std::string PlaceOf(const std::string& path, int line) { return path + ":" + std::to_string(line); }

// The frame that has that stamp.
std::optional<size_t> FrameAt(const std::vector<int64_t>& stamps_ns, int64_t t_ns) {
  const size_t nearest = NearestIndex(stamps_ns, t_ns);
  if (std::abs(stamps_ns[nearest] - t_ns) > kSameStampNs) return std::nullopt;
  return nearest;
}

template <typename T>
void Append(const std::vector<T>& from, std::vector<T>* to) {
  to->insert(to->end(), from.begin(), from.end());
}

class ImageListSource : public DataSource {
 public:
  ImageListSource(ImageList list, const DataSourceOptions& options)
      : list_(std::move(list)), options_(options) {}

  Result<std::optional<Frame>> Next() override {
    if (next_ == list_.stamps_ns.size()) return std::optional<Frame>();
    const size_t index = next_++;
    Frame frame;
    frame.t_ns = list_.stamps_ns[index];
    if (index < list_.lines.size()) frame.name = PlaceOf(list_.table, list_.lines[index]);
    const bool named = index < list_.images.size() && !list_.images[index].empty();
    if (named) frame.name = list_.images[index];
    if (const Status taken = TakeDetections(index, &frame); !taken) return taken.error();
    if (!options_.read_images) return std::optional<Frame>(std::move(frame));
    if (!named || !list_.images_are_there) {
      if (!options_.use_detections) frame.image_problem = "no image file is named";
      return std::optional<Frame>(std::move(frame));
    }
    auto image = ReadGrayImage(frame.name, options_.limits);
    if (!image) {
      frame.image_problem = image.error().message;
    } else if (auto fault = size_guard_.Check(*image, frame.name)) {
      return *fault;
    } else {
      frame.image = std::move(*image);
    }
    return std::optional<Frame>(std::move(frame));
  }

  Status Skip(size_t frames) override {
    next_ = std::min(list_.stamps_ns.size(), next_ + frames);
    return Ok();
  }

  const std::vector<int64_t>& stamps_ns() const override { return list_.stamps_ns; }
  const std::vector<TruthSample>& ground_truth() const override { return list_.ground_truth; }
  const std::vector<ImuSample>& imu() const override { return list_.imu; }
  const std::vector<std::string>& notes() const override { return list_.notes; }
  std::string truth_origin() const override { return list_.truth_origin; }

 private:
  // Those of a frame's stamp; what belongs to frames before it was skipped.
  Status TakeDetections(size_t index, Frame* frame) {
    while (list_.detections) {
      if (!ahead_) {
        auto next = list_.detections->Next();
        if (!next) return next.error();
        ahead_ = std::move(*next);
        if (!ahead_) break;
      }
      const auto of_frame = FrameAt(list_.stamps_ns, ahead_->t_ns);
      if (!of_frame && !list_.rows_were_passed_over) return Changed();
      if (of_frame && *of_frame > index) break;
      if (of_frame && *of_frame == index) {
        if (frame->name.empty()) frame->name = PlaceOf(list_.table, ahead_->line);
        Append(ahead_->tags, &frame->detections);
        Append(ahead_->doubled_ids, &frame->doubled_ids);
      }
      ahead_.reset();
    }
    return frame->name.empty() ? Changed() : Ok();
  }

  Status Changed() const { return Error{list_.table + ": was changed while it was read"}; }

  ImageList list_;
  DataSourceOptions options_;
  size_t next_ = 0;
  std::optional<StampedDetections> ahead_;  // of the next frame that has any
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
  list.table = table.path();
  list.stamps_ns = std::move(stamps->stamps_ns);
  list.rows_were_passed_over = !stamps->notes.empty();
  list.notes = std::move(stamps->notes);
  bool any_file = false;
  for (const size_t row : stamps->rows) {
    const std::string file(file_column ? table.Cell(row, *file_column) : "");
    any_file = any_file || !file.empty();
    list.lines.push_back(table.line(row));
    list.images.push_back(
        file.empty() ? "" : (std::filesystem::path(files.image_folder) / file).string());
  }
  if (!any_file) list.images = {};
  return list;
}

// Detections of no frame are refused, with the line of the first.
Status CheckDetectionsFit(const ImageList& list, const std::string& path,
                          const std::vector<int64_t>& stamps_ns, DetectionsReader* reader) {
  if (list.rows_were_passed_over) return Ok();  // the frame's row was one of them
  const auto stray = std::find_if(stamps_ns.begin(), stamps_ns.end(),
                                  [&](int64_t t_ns) { return !FrameAt(list.stamps_ns, t_ns); });
  if (stray == stamps_ns.end()) return Ok();
  while (true) {
    const auto next = reader->Next();
    if (!next) return next.error();
    if (*next && (*next)->t_ns != *stray) continue;
    return Error{(*next ? PlaceOf(path, (*next)->line) : path) + ": stamp " +
                 FormatSeconds(*stray) + " s is no frame's"};
  }
}

bool AnyImageExists(const ImageList& list) {
  std::error_code unknown;
  return std::any_of(list.images.begin(), list.images.end(), [&](const std::string& path) {
    return !path.empty() && std::filesystem::exists(path, unknown);
  });
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
  std::optional<DetectionsReader> detections;
  std::vector<int64_t> detections_ns;
  if (options.use_detections) {
    auto opened =
        DetectionsReader::Open(files.detections, files.unit, options.known_tag_ids, options.limits);
    if (!opened) return opened.error();
    detections.emplace(std::move(*opened));
    detections_ns = detections->TakeStamps();
    std::error_code unknown;
    if (!std::filesystem::exists(files.table, unknown)) {
      if (detections_ns.empty()) return Error{files.detections + ": no rows"};
      ImageList list;  // the frames are the stamps of the detections
      list.table = files.detections;
      list.stamps_ns = std::move(detections_ns);
      list.notes = detections->notes();
      list.detections = std::move(detections);
      return list;
    }
  }
  const auto table = CsvTable::Read(files.table, options.limits);
  if (!table) return table.error();
  auto list = ListFromTable(*table, files, options);
  if (!list) return list;
  if (detections) {
    Append(detections->notes(), &list->notes);
    const Status fits = CheckDetectionsFit(*list, files.detections, detections_ns, &*detections);
    if (!fits) return fits.error();
    list->detections = std::move(detections);
  }
  if (!options.read_images || AnyImageExists(*list)) return list;
  if (!options.use_detections) {
    return table->ErrorAt(0, "none of the images exists, the first is " +
                                 QuoteForMessage(list->images.empty() ? "" : list->images.front()));
  }
  list->images_are_there = false;
  return list;
}

}  // namespace tagtwist::internal

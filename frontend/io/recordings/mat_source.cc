#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "frontend/io/mat/mat_backends.h"
#include "frontend/io/recordings/data_source_kinds.h"
#include "frontend/io/tables/csv.h"
#include "frontend/io/tables/stamps.h"
#include "frontend/io/trajectories/mat_truth.h"

namespace tagtwist::internal {
namespace {

// Gray image of a column-major H x W or H x W x 3 (RGB) array of bytes; the fault otherwise.
Result<cv::Mat> ImageFromArray(MatArray* array) {
  const auto& dims = array->dims;
  const bool colour = dims.size() == 3 && dims[2] == 3;
  if (array->kind != MatArray::Kind::kBytes || !(colour || dims.size() == 2)) {
    return Error{"expected an image of bytes, got " + DescribeShape(*array)};
  }
  const int rows = static_cast<int>(dims[0]), columns = static_cast<int>(dims[1]);
  const auto plane = [&](size_t i) -> cv::Mat {
    const size_t offset = i * dims[0] * dims[1];
    return cv::Mat(columns, rows, CV_8UC1, array->bytes.data() + offset).t();
  };
  if (!colour) return plane(0);
  cv::Mat rgb, gray;
  cv::merge(std::vector<cv::Mat>{plane(0), plane(1), plane(2)}, rgb);
  cv::cvtColor(rgb, gray, cv::COLOR_RGB2GRAY);
  return gray;
}

class MatSource : public DataSource {
 public:
  MatSource(std::string path, const DataSourceOptions& options, std::unique_ptr<MatFile> file)
      : path_(std::move(path)), options_(options), file_(std::move(file)) {}

  Status Open();
  Result<std::optional<Frame>> Next() override;
  Status Skip(size_t frames) override {
    next_ = std::min(stamps_ns_.size(), next_ + frames);
    return Ok();
  }
  const std::vector<int64_t>& stamps_ns() const override { return stamps_ns_; }
  const std::vector<TruthSample>& ground_truth() const override { return ground_truth_; }
  const std::vector<ImuSample>& imu() const override { return imu_; }

 private:
  std::string Place(size_t packet, const std::string& field) const {
    return FieldPlace(path_, file_->packets_name(), packet, field);
  }
  Status RequireFields() const;
  Status ReadStamps();
  Status ReadImu();
  Status FillDetections(size_t packet, Frame* frame);
  Result<std::vector<double>> ReadCorner(size_t packet, const std::string& field, size_t tags);
  Status FillImage(size_t packet, Frame* frame);

  std::string path_;
  DataSourceOptions options_;
  std::unique_ptr<MatFile> file_;
  std::vector<int64_t> stamps_ns_;
  std::vector<TruthSample> ground_truth_;
  std::vector<ImuSample> imu_;
  size_t next_ = 0;
  ImageSizeGuard size_guard_;
};

Status MatSource::Open() {
  if (auto status = file_->OpenPackets(); !status) return status;
  if (auto status = RequireFields(); !status) return status;
  if (file_->packets() == 0) return Error{path_ + ": " + file_->packets_name() + " is empty"};
  if (auto status = ReadStamps(); !status) return status;
  if (auto status = ReadImu(); !status) return status;
  auto truth = TruthFromMat(file_.get(), path_);
  if (!truth) return truth.error();
  ground_truth_ = std::move(*truth);
  return Ok();
}

Status MatSource::RequireFields() const {
  std::vector<std::string> fields = {"t"};
  if (options_.use_detections) {
    fields.insert(fields.end(), {"id", "p1", "p2", "p3", "p4"});
  } else if (options_.read_images) {
    fields.emplace_back("img");
  }
  for (const std::string& field : fields) {
    if (!file_->HasField(field)) {
      return Error{path_ + ": " + file_->packets_name() + ": missing field '" + field + "'"};
    }
  }
  return Ok();
}

Status MatSource::ReadStamps() {
  stamps_ns_.reserve(file_->packets());
  for (size_t packet = 0; packet < file_->packets(); ++packet) {
    const auto t = file_->ReadField(packet, "t");
    if (!t) return t.error();
    const std::vector<double> seconds = t->ToNumbers();
    if (seconds.size() != 1) {
      return Error{Place(packet, "t") + "expected one number, got " + DescribeShape(*t)};
    }
    const auto t_ns = NanosecondsFromMat(seconds[0]);
    if (!t_ns) {
      return Error{Place(packet, "t") + "expected a time in seconds, got " +
                   FormatNumber(seconds[0])};
    }
    if (!stamps_ns_.empty()) {
      if (const auto fault = StampFault(stamps_ns_.back(), *t_ns)) {
        return Error{Place(packet, "t") + *fault};
      }
    }
    stamps_ns_.push_back(*t_ns);
  }
  return Ok();
}

// A packet without an IMU sample of its own (no field, empty or not finite) gives none.
Status MatSource::ReadImu() {
  if (!file_->HasField("acc") || !file_->HasField("omg")) return Ok();
  for (size_t packet = 0; packet < file_->packets(); ++packet) {
    ImuSample sample;
    sample.t_ns = stamps_ns_[packet];
    bool complete = true;
    for (const auto& [field, value] :
         {std::pair{"acc", &sample.accel_mps2}, {"omg", &sample.gyro_radps}}) {
      const auto array = file_->ReadField(packet, field);
      if (!array) return array.error();
      const std::vector<double> numbers = array->ToNumbers();
      if (numbers.size() != 3 && !numbers.empty()) {
        return Error{Place(packet, field) + "expected 3 x 1, got " + DescribeShape(*array)};
      }
      complete = complete && numbers.size() == 3;
      if (complete) *value = Eigen::Vector3d(numbers.data());
      complete = complete && value->allFinite();
    }
    if (complete) imu_.push_back(sample);
  }
  return Ok();
}

Result<std::optional<Frame>> MatSource::Next() {
  if (next_ == stamps_ns_.size()) return std::optional<Frame>();
  const size_t packet = next_++;
  Frame frame;
  frame.t_ns = stamps_ns_[packet];
  frame.name = path_ + ": " + file_->packets_name() + "(" + std::to_string(packet + 1) + ")";
  if (options_.use_detections) {
    if (const auto status = FillDetections(packet, &frame); !status) return status.error();
  }
  if (options_.read_images && file_->HasField("img")) {
    if (const auto status = FillImage(packet, &frame); !status) return status.error();
  }
  return std::optional<Frame>(std::move(frame));
}

// Columns of a corner field as u0 v0 u1 v1 ...; all finite.
Result<std::vector<double>> MatSource::ReadCorner(size_t packet, const std::string& field,
                                                  size_t tags) {
  const auto array = file_->ReadField(packet, field);
  if (!array) return array.error();
  if (tags == 0 && array->size() == 0) return std::vector<double>{};
  if (!array->IsMatrix(2, tags)) {
    return Error{Place(packet, field) + "expected 2 x " + std::to_string(tags) + " like id, got " +
                 DescribeShape(*array)};
  }
  std::vector<double> numbers = array->ToNumbers();
  for (const double number : numbers) {
    if (!std::isfinite(number)) return Error{Place(packet, field) + "not finite"};
  }
  return numbers;
}

Status MatSource::FillDetections(size_t packet, Frame* frame) {
  const auto ids = file_->ReadField(packet, "id");
  if (!ids) return ids.error();
  if (ids->kind == MatArray::Kind::kOther) {
    return Error{Place(packet, "id") + "expected tag ids, got " + DescribeShape(*ids)};
  }
  for (const double id : ids->ToNumbers()) {
    if (!(id >= 0 && id <= std::numeric_limits<int>::max() && id == std::floor(id))) {
      return Error{Place(packet, "id") + "expected tag ids >= 0, got " + FormatNumber(id)};
    }
    frame->detections.emplace_back().id = static_cast<int>(id);
  }
  for (size_t corner = 0; corner < 4; ++corner) {
    const auto points =
        ReadCorner(packet, "p" + std::to_string(corner + 1), frame->detections.size());
    if (!points) return points.error();
    for (size_t i = 0; i < frame->detections.size(); ++i) {
      frame->detections[i].corners[corner] = {(*points)[2 * i], (*points)[2 * i + 1]};
    }
  }
  return Ok();
}

Status MatSource::FillImage(size_t packet, Frame* frame) {
  auto array = file_->ReadField(packet, "img");
  if (!array) return array.error();
  if (array->size() == 0 && array->kind != MatArray::Kind::kOther) {
    if (!options_.use_detections) frame->image_problem = "img: empty";
    return Ok();
  }
  auto image = ImageFromArray(&*array);
  if (!image) {
    frame->image_problem = "img: " + image.error().message;
    return Ok();
  }
  if (auto fault = size_guard_.Check(*image, frame->name)) return *fault;
  frame->image = std::move(*image);
  return Ok();
}

}  // namespace

Result<std::unique_ptr<DataSource>> OpenMatSource(const std::string& path,
                                                  const DataSourceOptions& options) {
  auto file = OpenMatFile(path, options.limits);
  if (!file) return file.error();
  auto source = std::make_unique<MatSource>(path, options, std::move(*file));
  if (const auto opened = source->Open(); !opened) return opened.error();
  return std::unique_ptr<DataSource>(std::move(source));
}

}  // namespace tagtwist::internal

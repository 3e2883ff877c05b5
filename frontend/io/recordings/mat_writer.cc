#include <matio.h>

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <new>
#include <system_error>
#include <utility>

#include "frontend/base/files/partial.h"
#include "frontend/io/mat/mat_plain.h"
#include "frontend/io/recordings/dataset_writer_kinds.h"
#include "frontend/io/tables/stamps.h"
#include "frontend/io/trajectories/vicon.h"

namespace tagtwist::internal {
namespace {

// In the order of the course's files.
constexpr std::array<const char*, 12> kFields = {"is_ready", "t",  "rpy", "omg", "acc", "img",
                                                 "id",       "p0", "p1",  "p2",  "p3",  "p4"};

struct CloseMat {
  void operator()(mat_t* file) const { Mat_Close(file); }
};
struct FreeVariable {
  void operator()(matvar_t* variable) const { Mat_VarFree(variable); }
};
using Variable = std::unique_ptr<matvar_t, FreeVariable>;

// matio says by what is missing alone that memory ran out.
matvar_t* Made(matvar_t* variable) {
  if (variable == nullptr) throw std::bad_alloc();
  if (variable->data == nullptr && variable->nbytes > 0) {
    Mat_VarFree(variable);
    throw std::bad_alloc();
  }
  return variable;
}

// A matrix of doubles, column-major; it keeps its own copy.
matvar_t* MakeNumbers(const char* name, size_t rows, size_t columns,
                      const std::vector<double>& values) {
  std::array<size_t, 2> dims = {rows, columns};
  static const double none = 0;  // matio copies nothing, but asks for an address
  const double* const data = values.empty() ? &none : values.data();
  return Made(Mat_VarCreate(name, MAT_C_DOUBLE, MAT_T_DOUBLE, 2, dims.data(),
                            const_cast<double*>(data), 0));
}

matvar_t* MakeBytes(const cv::Mat& column_major, size_t rows, size_t columns, int flags) {
  std::array<size_t, 2> dims = {rows, columns};
  static unsigned char none = 0;
  return Made(Mat_VarCreate(nullptr, MAT_C_UINT8, MAT_T_UINT8, 2, dims.data(),
                            column_major.empty() ? &none : column_major.data, flags));
}

// Where the diagonals p1-p3 and p2-p4 meet: the projection of the tag's centre.
Eigen::Vector2d Centre(const TagDetection& tag) {
  const auto& p = tag.corners;
  Eigen::Matrix2d directions;
  directions << p[2] - p[0], p[1] - p[3];
  if (!(std::abs(directions.determinant()) > 1e-9)) return (p[0] + p[1] + p[2] + p[3]) / 4;
  return p[0] + (p[2] - p[0]) * (directions.inverse() * (p[1] - p[0])).x();
}

// matio 1.5 writes a compressed struct array in one go, so the frames wait in memory until Finish.
class MatWriter : public DatasetWriter {
 public:
  MatWriter(std::string path, Partial partial)
      : path_(std::move(path)), partial_(std::move(partial)) {}
  Status Add(const FrameToWrite& frame) override;
  Status Finish(const std::vector<TruthSample>& truth, const std::vector<ImuSample>& imu) override;

 private:
  struct Packet {
    int64_t t_ns;
    cv::Mat column_major;  // the image transposed
    std::vector<TagDetection> detections;
  };
  Variable MakePackets(const std::vector<TruthSample>& truth, const std::vector<ImuSample>& imu);
  std::string path_;
  Partial partial_;
  FrameRules rules_;
  std::vector<Packet> packets_;
};

Status MatWriter::Add(const FrameToWrite& frame) {
  if (auto fit = rules_.Check(frame, path_); !fit) return fit;
  cv::Mat column_major;
  if (!frame.image.empty()) column_major = frame.image.t();
  packets_.push_back({frame.t_ns, column_major, frame.detections});
  return Ok();
}

// What the samples nearest in time say: vectors of 3, empty where there are no samples.
struct Inertial {
  std::vector<double> rpy, omg, acc;
};

std::vector<double> ToVector(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

template <typename Sample>
std::vector<int64_t> StampsOf(const std::vector<Sample>& samples) {
  std::vector<int64_t> out;
  out.reserve(samples.size());
  for (const Sample& sample : samples) out.push_back(sample.t_ns);
  return out;
}

class NearestInertial {
 public:
  NearestInertial(const std::vector<TruthSample>& truth, const std::vector<ImuSample>& imu)
      : truth_(truth), imu_(imu), truth_stamps_(StampsOf(truth)), imu_stamps_(StampsOf(imu)) {}
  Inertial At(int64_t t_ns) const {
    Inertial out;
    if (!truth_.empty()) {
      const TruthSample& nearest = truth_[NearestIndex(truth_stamps_, t_ns)];
      out.rpy = ToVector(ZxyFromRotation(nearest.world_from_body.rotation()));
    }
    if (!imu_.empty()) {
      const ImuSample& nearest = imu_[NearestIndex(imu_stamps_, t_ns)];
      out.omg = ToVector(nearest.gyro_radps);
      out.acc = ToVector(nearest.accel_mps2);
    }
    return out;
  }

 private:
  const std::vector<TruthSample>& truth_;
  const std::vector<ImuSample>& imu_;
  std::vector<int64_t> truth_stamps_, imu_stamps_;
};

void SetDetections(const std::vector<TagDetection>& tags, matvar_t* packets, size_t index) {
  const auto set = [&](const std::string& field, size_t rows, const std::vector<double>& values) {
    matvar_t* const value =
        MakeNumbers(nullptr, values.empty() && rows == 2 ? 0 : rows, values.size() / rows, values);
    Mat_VarSetStructFieldByName(packets, field.c_str(), index, value);
  };
  std::vector<double> ids;
  std::array<std::vector<double>, 5> points;
  for (const TagDetection& tag : tags) {
    ids.push_back(tag.id);
    for (size_t k = 0; k < 5; ++k) {
      const Eigen::Vector2d point = k == 0 ? Centre(tag) : tag.corners[k - 1];
      points[k].insert(points[k].end(), {point.x(), point.y()});
    }
  }
  set("id", 1, ids);
  for (size_t k = 0; k < 5; ++k) set("p" + std::to_string(k), 2, points[k]);
}

Variable MatWriter::MakePackets(const std::vector<TruthSample>& truth,
                                const std::vector<ImuSample>& imu) {
  std::array<size_t, 2> dims = {1, packets_.size()};
  std::array<const char*, kFields.size()> fields = kFields;
  Variable out(Made(Mat_VarCreateStruct("data", 2, dims.data(), fields.data(), fields.size())));
  const NearestInertial nearest(truth, imu);
  const cv::Mat one(1, 1, CV_8UC1, cv::Scalar(1));
  for (size_t i = 0; i < packets_.size(); ++i) {
    Packet& packet = packets_[i];
    const auto set = [&](const char* field, matvar_t* value) {
      Mat_VarSetStructFieldByName(out.get(), field, i, value);
    };
    set("is_ready", MakeBytes(one, 1, 1, MAT_F_LOGICAL));
    set("t", MakeNumbers(nullptr, 1, 1, {ToSeconds(packet.t_ns)}));
    const Inertial inertial = nearest.At(packet.t_ns);
    for (const auto& [field, values] :
         {std::pair{"rpy", &inertial.rpy}, {"omg", &inertial.omg}, {"acc", &inertial.acc}}) {
      set(field, MakeNumbers(nullptr, values->size(), values->empty() ? 0 : 1, *values));
    }
    set("img", MakeBytes(packet.column_major, static_cast<size_t>(packet.column_major.cols),
                         static_cast<size_t>(packet.column_major.rows), 0));
    packet.column_major.release();  // matio has its copy
    SetDetections(packet.detections, out.get(), i);
  }
  return out;
}

Status MatWriter::Finish(const std::vector<TruthSample>& truth, const std::vector<ImuSample>& imu) {
  if (packets_.empty()) return Error{path_ + ": no frames to write"};
  std::vector<double> time, vicon;
  for (const TruthSample& sample : truth) {
    const auto column = ViconFromTruth(sample);
    if (!column) return Error{path_ + ": a .mat has no place for ground truth without twist"};
    time.push_back(ToSeconds(sample.t_ns));
    vicon.insert(vicon.end(), column->begin(), column->end());
  }
  const Error write_error{path_ + ": cannot write the MAT file"};
  std::unique_ptr<mat_t, CloseMat> file(Mat_CreateVer(
      partial_.path().c_str(), "MATLAB 5.0 MAT-file, written by tagtwist", MAT_FT_MAT5));
  if (file == nullptr) return write_error;
  std::vector<Variable> variables;
  variables.push_back(MakePackets(truth, imu));
  if (!truth.empty()) {
    variables.emplace_back(MakeNumbers("time", 1, time.size(), time));
    variables.emplace_back(MakeNumbers("vicon", 12, time.size(), vicon));
  }
  for (const Variable& variable : variables) {
    if (variable == nullptr ||
        Mat_VarWrite(file.get(), variable.get(), MAT_COMPRESSION_ZLIB) != 0) {
      return write_error;
    }
  }
  file.reset();
  // matio does not say when the disk is full.
  if (!CheckMatIsWhole(partial_.path())) return write_error;
  const int failure = partial_.PutAt(path_);
  if (failure == 0) return Ok();
  return Error{path_ + ": cannot write: " + std::generic_category().message(failure)};
}

}  // namespace

Result<std::unique_ptr<DatasetWriter>> CreateMatWriter(const std::string& path) {
  auto partial = Partial::Make(path, Partial::Kind::kFile);
  if (!partial) return partial.error();
  return std::unique_ptr<DatasetWriter>(std::make_unique<MatWriter>(path, std::move(*partial)));
}

}  // namespace tagtwist::internal

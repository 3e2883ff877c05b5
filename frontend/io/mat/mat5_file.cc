#include <matio.h>
#include <unistd.h>

#include <algorithm>
#include <string_view>
#include <utility>

#include "frontend/io/mat/mat_backends.h"
#include "frontend/io/mat/mat_elements.h"
#include "frontend/io/mat/mat_plain.h"

namespace tagtwist::internal {
namespace {

struct CloseMat {
  void operator()(mat_t* file) const { Mat_Close(file); }
};
struct FreeVariable {
  void operator()(matvar_t* variable) const { Mat_VarFree(variable); }
};
using Mat = std::unique_ptr<mat_t, CloseMat>;
using Variable = std::unique_ptr<matvar_t, FreeVariable>;

// Reads n elements of class T, as doubles.
template <typename T>
bool ReadAs(mat_t* file, matvar_t* variable, int n, std::vector<double>* out) {
  std::vector<T> values(static_cast<size_t>(n));
  if (Mat_VarReadDataLinear(file, variable, values.data(), 0, 1, n) != 0) return false;
  out->reserve(values.size());
  for (const T value : values) out->push_back(static_cast<double>(value));
  return true;
}

bool ReadNumbers(mat_t* file, matvar_t* variable, int n, std::vector<double>* out) {
  switch (variable->class_type) {
    case MAT_C_DOUBLE:
      return ReadAs<double>(file, variable, n, out);
    case MAT_C_SINGLE:
      return ReadAs<float>(file, variable, n, out);
    case MAT_C_INT8:
      return ReadAs<int8_t>(file, variable, n, out);
    case MAT_C_INT16:
      return ReadAs<int16_t>(file, variable, n, out);
    case MAT_C_UINT16:
      return ReadAs<uint16_t>(file, variable, n, out);
    case MAT_C_INT32:
      return ReadAs<int32_t>(file, variable, n, out);
    case MAT_C_UINT32:
      return ReadAs<uint32_t>(file, variable, n, out);
    case MAT_C_INT64:
      return ReadAs<int64_t>(file, variable, n, out);
    case MAT_C_UINT64:
      return ReadAs<uint64_t>(file, variable, n, out);
    default:
      return false;
  }
}

bool IsRealNumeric(const matvar_t& variable) {
  return variable.class_type >= MAT_C_DOUBLE && variable.class_type <= MAT_C_UINT64 &&
         variable.isComplex == 0;
}

// The elements of a variable known by its header; nullopt when they cannot be read.
std::optional<MatArray> ReadArray(mat_t* file, matvar_t* variable, const Limits& limits) {
  MatArray out;
  if (variable == nullptr || variable->class_type == MAT_C_EMPTY) return out;
  if (!IsRealNumeric(*variable)) {
    out.kind = MatArray::Kind::kOther;
    return out;
  }
  out.dims.assign(variable->dims, variable->dims + variable->rank);
  size_t n = 1;
  for (const size_t side : out.dims) {
    if (side > 0 && n > static_cast<size_t>(limits.elements) / side) return std::nullopt;
    n *= side;
  }
  const int count = static_cast<int>(n);
  if (variable->class_type == MAT_C_UINT8) {
    out.kind = MatArray::Kind::kBytes;
    out.bytes.resize(n);
    if (n > 0 && Mat_VarReadDataLinear(file, variable, out.bytes.data(), 0, 1, count) != 0) {
      return std::nullopt;
    }
    return out;
  }
  if (n > 0 && !ReadNumbers(file, variable, count, &out.numbers)) return std::nullopt;
  return out;
}

class Mat5File : public MatFile {
 public:
  Mat5File(std::string path, PlainMat plain, const Limits& limits)
      : path_(std::move(path)), plain_(std::move(plain)), limits_(limits) {
    file_.reset(Mat_Open(plain_.path.c_str(), MAT_ACC_RDONLY));
    if (plain_.temporary) ::unlink(plain_.path.c_str());  // lives on until it is closed
  }
  bool IsOpen() const { return file_ != nullptr; }

  Result<std::optional<MatArray>> ReadVariable(const std::string& name) override {
    const Variable info(Mat_VarReadInfo(file_.get(), name.c_str()));
    if (info == nullptr) return std::optional<MatArray>();
    auto array = ReadArray(file_.get(), info.get(), limits_);
    if (!array) return Error{path_ + ": " + name + ": cannot read"};
    return array;
  }

  Status OpenPackets() override {
    packets_.reset(Mat_VarReadInfo(file_.get(), "data"));
    if (packets_ == nullptr) packets_ = FindOnlyStruct();
    if (packets_ == nullptr || packets_->class_type != MAT_C_STRUCT) {
      return Error{path_ + ": no struct variable 'data'"};
    }
    if (packets_->name != nullptr) packets_name_ = packets_->name;
    size_ = 1;
    for (int i = 0; i < packets_->rank; ++i) size_ *= packets_->dims[i];
    return Ok();
  }

  const std::string& packets_name() const override { return packets_name_; }
  size_t packets() const override { return size_; }

  bool HasField(const std::string& field) const override {
    const unsigned fields = Mat_VarGetNumberOfFields(packets_.get());
    char* const* const names = Mat_VarGetStructFieldnames(packets_.get());
    return names != nullptr &&
           std::find(names, names + fields, std::string_view(field)) != names + fields;
  }

  Result<MatArray> ReadField(size_t packet, const std::string& field) override {
    matvar_t* const info = Mat_VarGetStructFieldByName(packets_.get(), field.c_str(), packet);
    auto array = ReadArray(file_.get(), info, limits_);
    if (!array) return Error{FieldPlace(path_, packets_name_, packet, field) + "cannot read"};
    return std::move(*array);
  }

 private:
  Variable FindOnlyStruct() {
    Variable found;
    Mat_Rewind(file_.get());
    for (;;) {
      Variable next(Mat_VarReadNextInfo(file_.get()));
      if (next == nullptr) return found;
      if (next->class_type != MAT_C_STRUCT) continue;
      if (found != nullptr) return nullptr;
      found = std::move(next);
    }
  }

  std::string path_;
  PlainMat plain_;
  Limits limits_;
  Mat file_;
  Variable packets_;
  std::string packets_name_;
  size_t size_ = 0;
};

}  // namespace

std::string FieldPlace(const std::string& path, const std::string& packets_name, size_t packet,
                       const std::string& field) {
  return path + ": " + packets_name + "(" + std::to_string(packet + 1) + ")." + field + ": ";
}

Result<std::unique_ptr<MatFile>> OpenMat5File(const std::string& path, const Limits& limits) {
  auto plain = MakePlainMat(path, limits);
  if (!plain) return plain.error();
  if (const auto sound = CheckMatStructure(plain->path, path, limits); !sound) {
    if (plain->temporary) ::unlink(plain->path.c_str());
    return sound.error();
  }
  auto file = std::make_unique<Mat5File>(path, std::move(*plain), limits);
  if (!file->IsOpen()) return Error{path + ": damaged: cannot be opened as a MATLAB file"};
  return std::unique_ptr<MatFile>(std::move(file));
}

}  // namespace tagtwist::internal

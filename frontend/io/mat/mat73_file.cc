#include <hdf5.h>

#include <algorithm>
#include <array>
#include <utility>

#include "frontend/io/mat/mat_backends.h"

namespace tagtwist::internal {
namespace {

// HDF5 prints what goes wrong on stderr unless told not to; told so for the length of a call.
class QuietHdf5 {
 public:
  QuietHdf5() {
    H5Eget_auto2(H5E_DEFAULT, &print_, &data_);
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  }
  ~QuietHdf5() { H5Eset_auto2(H5E_DEFAULT, print_, data_); }
  QuietHdf5(const QuietHdf5&) = delete;
  QuietHdf5& operator=(const QuietHdf5&) = delete;

 private:
  H5E_auto2_t print_ = nullptr;
  void* data_ = nullptr;
};

// An HDF5 handle and the function that closes it.
class Handle {
 public:
  Handle() = default;
  Handle(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) {}
  ~Handle() {
    if (id_ >= 0) close_(id_);
  }
  Handle(Handle&& other) noexcept : id_(std::exchange(other.id_, -1)), close_(other.close_) {}
  Handle& operator=(Handle&& other) noexcept {
    std::swap(id_, other.id_);
    std::swap(close_, other.close_);
    return *this;
  }
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  hid_t id() const { return id_; }
  explicit operator bool() const { return id_ >= 0; }

 private:
  hid_t id_ = -1;
  herr_t (*close_)(hid_t) = nullptr;
};

bool HasAttribute(hid_t object, const char* name) { return H5Aexists(object, name) > 0; }

// MATLAB_class of an object, "" where it has none.
std::string MatlabClass(hid_t object) {
  if (!HasAttribute(object, "MATLAB_class")) return "";
  const Handle attribute(H5Aopen(object, "MATLAB_class", H5P_DEFAULT), H5Aclose);
  const Handle type(H5Aget_type(attribute.id()), H5Tclose);
  if (H5Tget_class(type.id()) != H5T_STRING || H5Tis_variable_str(type.id()) != 0) return "";
  const size_t size = H5Tget_size(type.id());
  if (size > 64) return "";
  std::string out(size, '\0');
  if (H5Aread(attribute.id(), type.id(), out.data()) < 0) return "";
  return out.substr(0, out.find('\0'));
}

// Sides of a dataset in MATLAB's order, which is the reverse of HDF5's; empty when unreadable.
std::vector<size_t> MatlabDims(hid_t dataset) {
  const Handle space(H5Dget_space(dataset), H5Sclose);
  const int rank = H5Sget_simple_extent_ndims(space.id());
  if (rank < 1 || rank > H5S_MAX_RANK) return {};
  std::vector<hsize_t> sides(static_cast<size_t>(rank));
  H5Sget_simple_extent_dims(space.id(), sides.data(), nullptr);
  return {sides.rbegin(), sides.rend()};
}

std::optional<size_t> CountElements(const std::vector<size_t>& dims, const Limits& limits) {
  const auto most = static_cast<size_t>(limits.elements);
  size_t n = 1;
  for (const size_t side : dims) {
    if (side > 0 && n > most / side) return std::nullopt;
    n *= side;
  }
  return n;
}

MatArray NotAnArray() {
  MatArray out;
  out.kind = MatArray::Kind::kOther;
  return out;
}

// Whether so many elements can be in the file: a damaged extent asks for memory that nothing fills.
// Deflate, MATLAB's filter, makes data at most 1032 times smaller; what is stored nowhere reads as
// zeros, and little of that is plausible.
bool CanHold(hid_t dataset, size_t elements) {
  constexpr uint64_t kMostDeflation = 1032, kAlways = 1U << 20;
  const Handle type(H5Dget_type(dataset), H5Tclose);
  const uint64_t bytes = elements * std::max<uint64_t>(H5Tget_size(type.id()), 1);
  const Handle file(H5Iget_file_id(dataset), H5Fclose);
  hsize_t file_bytes = 0;
  if (H5Fget_filesize(file.id(), &file_bytes) < 0) return false;
  const uint64_t stored = std::min<uint64_t>(H5Dget_storage_size(dataset), file_bytes);
  if (bytes > kAlways && bytes / kMostDeflation > stored) return false;
  const Handle made(H5Dget_create_plist(dataset), H5Pclose);
  if (H5Pget_layout(made.id()) != H5D_CHUNKED) return bytes <= kAlways || bytes <= stored;
  std::array<hsize_t, H5S_MAX_RANK> sides{};
  const int rank = H5Pget_chunk(made.id(), static_cast<int>(sides.size()), sides.data());
  uint64_t chunk = bytes / std::max<size_t>(elements, 1);
  for (int i = 0; i < rank; ++i) {
    const uint64_t side = std::max<hsize_t>(sides[static_cast<size_t>(i)], 1);
    if (chunk > (kAlways + kMostDeflation * file_bytes) / side) return false;
    chunk *= side;
  }
  return true;
}

// The elements of an object; nullopt when they cannot be read.
std::optional<MatArray> ReadArray(hid_t object, const Limits& limits) {
  if (H5Iget_type(object) != H5I_DATASET) return NotAnArray();
  MatArray out;
  if (HasAttribute(object, "MATLAB_empty")) return out;
  const Handle type(H5Dget_type(object), H5Tclose);
  const H5T_class_t type_class = H5Tget_class(type.id());
  const bool text = MatlabClass(object) == "char";
  if (text || (type_class != H5T_INTEGER && type_class != H5T_FLOAT)) return NotAnArray();
  out.dims = MatlabDims(object);
  const auto n = CountElements(out.dims, limits);
  if (out.dims.empty() || !n || !CanHold(object, *n)) return std::nullopt;
  const bool bytes = type_class == H5T_INTEGER && H5Tget_size(type.id()) == 1 &&
                     H5Tget_sign(type.id()) == H5T_SGN_NONE;
  out.kind = bytes ? MatArray::Kind::kBytes : MatArray::Kind::kNumbers;
  void* to = nullptr;
  if (bytes) {
    out.bytes.resize(*n);
    to = out.bytes.data();
  } else {
    out.numbers.resize(*n);
    to = out.numbers.data();
  }
  const hid_t memory_type = bytes ? H5T_NATIVE_UINT8 : H5T_NATIVE_DOUBLE;
  if (*n > 0 && H5Dread(object, memory_type, H5S_ALL, H5S_ALL, H5P_DEFAULT, to) < 0) {
    return std::nullopt;
  }
  return out;
}

// A struct array is a group: a field is a dataset of references, one for every element, or, in a
// 1 x 1 struct, the value itself.
struct Field {
  std::string name;
  Handle object;
  std::vector<hobj_ref_t> references;
};

std::vector<std::string> LinkNames(hid_t group) {
  std::vector<std::string> out;
  const auto add = [](hid_t, const char* name, const H5L_info_t*, void* names) -> herr_t {
    static_cast<std::vector<std::string>*>(names)->emplace_back(name);
    return 0;
  };
  hsize_t from = 0;
  H5Literate(group, H5_INDEX_NAME, H5_ITER_INC, &from, add, &out);
  return out;
}

class Mat73File : public MatFile {
 public:
  Mat73File(std::string path, const Limits& limits) : path_(std::move(path)), limits_(limits) {
    const QuietHdf5 quiet;
    file_ = Handle(H5Fopen(path_.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose);
  }
  bool IsOpen() const { return static_cast<bool>(file_); }

  Result<std::optional<MatArray>> ReadVariable(const std::string& name) override {
    const QuietHdf5 quiet;
    if (H5Lexists(file_.id(), name.c_str(), H5P_DEFAULT) <= 0) return std::optional<MatArray>();
    const Handle object = Open(file_.id(), name);
    auto array = object ? ReadArray(object.id(), limits_) : std::nullopt;
    if (!array) return Error{path_ + ": " + name + ": cannot read"};
    return array;
  }

  Status OpenPackets() override {
    const QuietHdf5 quiet;
    std::vector<std::string> structs;
    for (const std::string& name : LinkNames(file_.id())) {
      const Handle object = Open(file_.id(), name);
      if (name[0] == '#' || !object || H5Iget_type(object.id()) != H5I_GROUP) continue;
      if (name == "data") structs.assign(1, name);
      if (name == "data") break;
      structs.push_back(name);
    }
    const bool taken = H5Lexists(file_.id(), "data", H5P_DEFAULT) > 0;
    if (structs.size() != 1 || (taken && structs[0] != "data")) {
      return Error{path_ + ": no struct variable 'data'"};
    }
    packets_name_ = structs[0];
    return ListFields(Open(file_.id(), packets_name_));
  }

  const std::string& packets_name() const override { return packets_name_; }
  size_t packets() const override { return size_; }
  bool HasField(const std::string& field) const override { return Find(field) != nullptr; }

  Result<MatArray> ReadField(size_t packet, const std::string& name) override {
    const QuietHdf5 quiet;
    const Field* const field = Find(name);
    if (field == nullptr) return MatArray{};
    std::optional<MatArray> array;
    if (field->references.empty()) {
      array = ReadArray(field->object.id(), limits_);
    } else {
      const Handle value(
          H5Rdereference2(file_.id(), H5P_DEFAULT, H5R_OBJECT, &field->references[packet]),
          H5Oclose);
      if (value) array = ReadArray(value.id(), limits_);
    }
    if (!array) return Error{FieldPlace(path_, packets_name_, packet, name) + "cannot read"};
    return std::move(*array);
  }

 private:
  static Handle Open(hid_t where, const std::string& name) {
    return {H5Oopen(where, name.c_str(), H5P_DEFAULT), H5Oclose};
  }

  const Field* Find(const std::string& name) const {
    const auto found = std::find_if(fields_.begin(), fields_.end(),
                                    [&](const Field& field) { return field.name == name; });
    return found == fields_.end() ? nullptr : &*found;
  }

  Status ListFields(const Handle& group) {
    size_ = 1;
    for (const std::string& name : LinkNames(group.id())) {
      Field field{name, Open(group.id(), name), {}};
      const bool dataset = field.object && H5Iget_type(field.object.id()) == H5I_DATASET;
      const Handle type(dataset ? H5Dget_type(field.object.id()) : -1, H5Tclose);
      // References with a class of their own are a cell: a value, not the struct's elements.
      if (type && H5Tget_class(type.id()) == H5T_REFERENCE &&
          MatlabClass(field.object.id()).empty()) {
        const auto n = CountElements(MatlabDims(field.object.id()), limits_);
        field.references.resize(n && CanHold(field.object.id(), *n) ? *n : 0);
        if (field.references.empty() || (!fields_.empty() && *n != size_) ||
            H5Dread(field.object.id(), H5T_STD_REF_OBJ, H5S_ALL, H5S_ALL, H5P_DEFAULT,
                    field.references.data()) < 0) {
          return Error{path_ + ": " + packets_name_ + ": cannot read field '" + name + "'"};
        }
        size_ = field.references.size();
      }
      fields_.push_back(std::move(field));
    }
    return Ok();
  }

  std::string path_;
  Limits limits_;
  Handle file_;
  std::string packets_name_;
  std::vector<Field> fields_;
  size_t size_ = 0;
};

}  // namespace

Result<std::unique_ptr<MatFile>> OpenMat73File(const std::string& path, const Limits& limits) {
  auto file = std::make_unique<Mat73File>(path, limits);
  if (!file->IsOpen()) return Error{path + ": truncated or damaged: no whole HDF5 file"};
  return std::unique_ptr<MatFile>(std::move(file));
}

}  // namespace tagtwist::internal

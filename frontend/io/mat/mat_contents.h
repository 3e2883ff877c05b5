#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "frontend/base/result.h"

namespace tagtwist::internal {

/// A numeric array of a .mat file, column-major. Bytes stay bytes, all other classes become
/// doubles; what is no real numeric array (cell, text, struct, complex, sparse) has kOther and no
/// elements.
struct MatArray {
  enum class Kind { kNumbers, kBytes, kOther };
  Kind kind = Kind::kNumbers;
  std::vector<size_t> dims = {0, 0};
  std::vector<double> numbers;
  std::vector<uint8_t> bytes;

  size_t size() const;
  bool IsMatrix(size_t rows, size_t columns) const;
  /// The elements as doubles, whatever the kind.
  std::vector<double> ToNumbers() const;
};

/// "2 x 5", "240 x 376 x 3", "not a real array".
std::string DescribeShape(const MatArray& array);

/// A MATLAB 5 (uncompressed or compressed) or 7.3 (HDF5) file with one array of structs, the
/// packets. Fields are read one at a time, so memory holds no more than the one asked for.
class MatFile {
 public:
  virtual ~MatFile() = default;
  /// nullopt when the file has no variable of that name.
  virtual Result<std::optional<MatArray>> ReadVariable(const std::string& name) = 0;

  /// Takes the struct variable `data` for the packets, or the only struct in the file where none
  /// has that name; the error "path: no struct variable 'data'" otherwise.
  virtual Status OpenPackets() = 0;
  virtual const std::string& packets_name() const = 0;
  virtual size_t packets() const = 0;
  virtual bool HasField(const std::string& field) const = 0;
  /// An unset field is an empty array. "path: data(17).img: cannot read".
  virtual Result<MatArray> ReadField(size_t packet, const std::string& field) = 0;
};

}  // namespace tagtwist::internal

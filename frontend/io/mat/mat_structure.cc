#include <algorithm>
#include <optional>

#include "frontend/io/mat/mat_elements.h"

namespace tagtwist::internal {
namespace {

// Array classes and storage types, as numbered by the format.
constexpr uint32_t kCell = 1, kStruct = 2, kFirstNumeric = 6, kLastNumeric = 15;
constexpr uint32_t kInt8 = 1, kInt32 = 5, kUint32 = 6;
constexpr uint32_t kComplexFlag = 0x800;

// Bytes of an element of a storage type; 0 for what stores no numbers.
uint64_t StorageBytes(uint32_t type) {
  constexpr std::array<uint64_t, 14> kBytes = {0, 1, 1, 2, 2, 4, 4, 4, 0, 8, 0, 0, 8, 8};
  return type < kBytes.size() ? kBytes[type] : 0;
}

class StructureCheck {
 public:
  StructureCheck(std::FILE* file, bool big_endian, const Limits& limits)
      : file_(file), big_endian_(big_endian), limits_(limits) {}

  // A matrix between begin and end.
  bool IsSound(uint64_t begin, uint64_t end, int depth = 0) {
    if (begin == end) return true;  // an unset field
    at_ = begin;
    end_ = end;
    const auto flags = NextWords(kUint32, 2, 2);
    const auto dims = NextWords(kInt32, 2, 32);
    const auto name = Next();
    if (!flags || !dims || !name || name->type != kInt8 || depth > limits_.depth) return false;
    uint64_t elements = 1;
    for (const uint32_t side : *dims) {
      if (side > (end - begin) && elements > 0) return false;  // more than there are bytes
      elements *= side;
      if (elements > (end - begin)) return false;
    }
    const uint32_t array_class = flags->front() & 0xff;
    if (array_class == kStruct) return IsSoundStruct(elements, depth);
    if (array_class == kCell) return AreSoundMatrices(elements, depth);
    if (array_class < kFirstNumeric || array_class > kLastNumeric) return true;  // never read
    const int parts = (flags->front() & kComplexFlag) != 0 ? 2 : 1;
    for (int part = 0; part < parts; ++part) {
      const auto data = Next();
      if (!data || StorageBytes(data->type) == 0) return false;
      if (data->length != elements * StorageBytes(data->type)) return false;
    }
    return true;
  }

  bool is_crowded() const { return matrices_ > static_cast<uint64_t>(limits_.fields); }

 private:
  bool IsSoundStruct(uint64_t elements, int depth) {
    const auto name_length = NextWords(kInt32, 1, 1);
    const auto names = Next();
    if (!name_length || !names || names->type != kInt8) return false;
    const uint64_t length = name_length->front();
    if (length == 0 || names->length % length != 0) return false;
    const uint64_t fields = names->length / length;
    if (fields > 0 && elements > (end_ - at_) / fields) return false;
    return AreSoundMatrices(elements * fields, depth);
  }

  bool AreSoundMatrices(uint64_t count, int depth) {
    // matio keeps some hundred bytes for each, however empty it is.
    matrices_ += count;
    if (is_crowded()) return false;
    for (uint64_t i = 0; i < count; ++i) {
      const auto matrix = Next();
      if (!matrix || matrix->type != kMatMatrixType) return false;
      const uint64_t after = at_, end = end_;
      if (!IsSound(matrix->begin, matrix->begin + matrix->length, depth + 1)) return false;
      at_ = after;
      end_ = end;
    }
    return true;
  }

  // The element at at_, which moves behind it; nullopt when it does not lie inside.
  std::optional<MatElement> Next() {
    std::array<unsigned char, kMatTagBytes> tag;
    if (end_ - at_ < kMatTagBytes || !Read(at_, tag.data(), tag.size())) return std::nullopt;
    const uint32_t first = MatUint32(tag.data(), big_endian_);
    MatElement out;
    if (first >> 16 != 0) {  // small: length and type in one word, up to four bytes after it
      out = {first & 0xffff, at_ + 4, first >> 16};
      if (out.length > 4) return std::nullopt;
      at_ += kMatTagBytes;
      return out;
    }
    out = {first, at_ + kMatTagBytes, MatUint32(tag.data() + 4, big_endian_)};
    if (out.length > end_ - out.begin) return std::nullopt;
    at_ = std::min(end_, out.begin + (out.length + 7) / 8 * 8);
    return out;
  }

  // The next element as 32-bit words, `least` to `most` of them.
  std::optional<std::vector<uint32_t>> NextWords(uint32_t type, size_t least, size_t most) {
    const auto element = Next();
    if (!element || element->type != type || element->length % 4 != 0) return std::nullopt;
    const size_t words = element->length / 4;
    if (words < least || words > most) return std::nullopt;
    std::vector<unsigned char> bytes(element->length);
    if (!Read(element->begin, bytes.data(), bytes.size())) return std::nullopt;
    std::vector<uint32_t> out;
    for (size_t i = 0; i < words; ++i) out.push_back(MatUint32(&bytes[4 * i], big_endian_));
    return out;
  }

  bool Read(uint64_t at, unsigned char* to, size_t size) {
    return std::fseek(file_, static_cast<long>(at), SEEK_SET) == 0 &&
           std::fread(to, 1, size, file_) == size;
  }

  std::FILE* file_;
  bool big_endian_;
  Limits limits_;
  uint64_t at_ = 0, end_ = 0, matrices_ = 0;
};

}  // namespace

Status CheckMatStructure(const std::string& plain_path, const std::string& path,
                         const Limits& limits) {
  const CFile file = OpenCFile(plain_path, "rbe");
  if (file == nullptr) return Error{path + ": cannot open"};
  const auto elements = ListMatVariables(file.get(), path);
  if (!elements) return elements.error();
  StructureCheck check(file.get(), elements->big_endian, limits);
  for (size_t i = 0; i < elements->variables.size(); ++i) {
    const MatElement& variable = elements->variables[i];
    if (variable.type == kMatMatrixType &&
        check.IsSound(variable.begin, variable.begin + variable.length)) {
      continue;
    }
    if (check.is_crowded()) {
      return Error{path + ": expected fewer fields and cells" + RaisesLimit("fields")};
    }
    return Error{path + ": damaged: variable " + std::to_string(i + 1) + " does not add up"};
  }
  return Ok();
}

}  // namespace tagtwist::internal

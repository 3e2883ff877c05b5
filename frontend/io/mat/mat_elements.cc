#include "frontend/io/mat/mat_elements.h"

#include <algorithm>

namespace tagtwist::internal {

CFile OpenCFile(const std::string& path, const char* mode) {
  return CFile(std::fopen(path.c_str(), mode), std::fclose);
}

uint32_t MatUint32(const unsigned char* bytes, bool big_endian) {
  uint32_t value = 0;
  for (size_t i = 0; i < 4; ++i) value = value << 8 | bytes[big_endian ? i : 3 - i];
  return value;
}

namespace {

// "a.mat: truncated: ... at byte 128"
Error ByteError(const std::string& path, const std::string& fault, uint64_t at) {
  return Error{path + ": " + fault + " at byte " + std::to_string(at)};
}

}  // namespace

Result<MatElements> ListMatVariables(std::FILE* file, const std::string& path) {
  MatElements out;
  if (std::fseek(file, 0, SEEK_END) != 0) return Error{path + ": cannot read"};
  const auto file_bytes = static_cast<uint64_t>(std::ftell(file));
  std::rewind(file);
  if (std::fread(out.header.data(), 1, kMatHeaderBytes, file) != kMatHeaderBytes) {
    return Error{path + ": truncated: no whole MAT header"};
  }
  out.big_endian = out.header[126] == 'M';
  for (uint64_t at = kMatHeaderBytes; at < file_bytes;) {
    std::array<unsigned char, kMatTagBytes> tag;
    if (std::fseek(file, static_cast<long>(at), SEEK_SET) != 0 ||
        std::fread(tag.data(), 1, kMatTagBytes, file) != kMatTagBytes) {
      return ByteError(path, "truncated: no whole variable", at);
    }
    const MatElement element{MatUint32(tag.data(), out.big_endian), at + kMatTagBytes,
                             MatUint32(tag.data() + 4, out.big_endian)};
    if (element.type != kMatMatrixType && element.type != kMatCompressedType) {
      return ByteError(path, "damaged: no variable", at);
    }
    if (element.length > file_bytes - std::min(file_bytes, element.begin)) {
      return ByteError(path, "truncated: the file ends inside the variable", at);
    }
    out.variables.push_back(element);
    at = element.begin + element.length;
  }
  return out;
}

}  // namespace tagtwist::internal

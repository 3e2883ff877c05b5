#include "frontend/mat_elements.h"

#include <algorithm>

namespace tagtwist {

CFile OpenCFile(const std::string& path, const char* mode) {
  return CFile(std::fopen(path.c_str(), mode), std::fclose);
}

uint32_t MatUint32(const unsigned char* bytes, bool big_endian) {
  uint32_t value = 0;
  for (size_t i = 0; i < 4; ++i) value = value << 8 | bytes[big_endian ? i : 3 - i];
  return value;
}

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
    const std::string place = " at byte " + std::to_string(at);
    if (std::fseek(file, static_cast<long>(at), SEEK_SET) != 0 ||
        std::fread(tag.data(), 1, kMatTagBytes, file) != kMatTagBytes) {
      return Error{path + ": truncated: no whole variable" + place};
    }
    const MatElement element{MatUint32(tag.data(), out.big_endian), at + kMatTagBytes,
                             MatUint32(tag.data() + 4, out.big_endian)};
    if (element.type != kMatMatrixType && element.type != kMatCompressedType) {
      return Error{path + ": damaged: no variable" + place};
    }
    if (element.length > file_bytes - std::min(file_bytes, element.begin)) {
      return Error{path + ": truncated: the variable" + place + " has " +
                   std::to_string(element.length) + " bytes, the file ends after " +
                   std::to_string(file_bytes - element.begin)};
    }
    out.variables.push_back(element);
    at = element.begin + element.length;
  }
  return out;
}

}  // namespace tagtwist

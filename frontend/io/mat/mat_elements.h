#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "frontend/base/limits.h"
#include "frontend/base/result.h"

namespace tagtwist::internal {

/// The bytes of a MATLAB 5 file: a header, then elements of a tag (type, length) and content. The
/// format: The MathWorks, "MAT-File Format", level 5.
constexpr size_t kMatHeaderBytes = 128, kMatTagBytes = 8;
constexpr uint32_t kMatMatrixType = 14, kMatCompressedType = 15;

struct MatElement {
  uint32_t type = 0;
  uint64_t begin = 0, length = 0;  // of the content, without the tag [bytes]
};

struct MatElements {
  std::array<unsigned char, kMatHeaderBytes> header = {};
  bool big_endian = false;
  std::vector<MatElement> variables;  // matrices and compressed matrices
};

using CFile = std::unique_ptr<std::FILE, int (*)(std::FILE*)>;
CFile OpenCFile(const std::string& path, const char* mode);

uint32_t MatUint32(const unsigned char* bytes, bool big_endian);

/// The variables of a file, whose lengths must fill it exactly: "x.mat: truncated: ...".
Result<MatElements> ListMatVariables(std::FILE* file, const std::string& path);

/// Checks that a file without compression adds up: the parts of every matrix lie inside it, and
/// have the sizes that its class and dimensions ask for. matio 1.5 trusts them and crashes.
Status CheckMatStructure(const std::string& plain_path, const std::string& path,
                         const Limits& limits = {});

}  // namespace tagtwist::internal

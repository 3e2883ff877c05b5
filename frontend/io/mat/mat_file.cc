#include "frontend/io/mat/mat_file.h"

#include "frontend/base/files/input_file.h"
#include "frontend/io/mat/mat_backends.h"

namespace tagtwist::internal {
namespace {

enum class MatVersion { kNone, k5, k73 };

// Bytes 124 to 127: version (0x0100 or 0x0200) and "MI", both in the writer's byte order.
MatVersion ReadVersion(const std::string& path) {
  const std::string head = FirstBytes(path, 128);
  if (head.size() < 128) return MatVersion::kNone;
  const bool little = head[126] == 'I' && head[127] == 'M';
  const bool big = head[126] == 'M' && head[127] == 'I';
  if (!little && !big) return MatVersion::kNone;
  const int version = little ? head[125] : head[124], minor = little ? head[124] : head[125];
  if (minor != 0) return MatVersion::kNone;
  return version == 1 ? MatVersion::k5 : version == 2 ? MatVersion::k73 : MatVersion::kNone;
}

}  // namespace

bool IsMatFile(const std::string& path) { return ReadVersion(path) != MatVersion::kNone; }

Result<std::unique_ptr<MatFile>> OpenMatFile(const std::string& path, const Limits& limits) {
  switch (ReadVersion(path)) {
    case MatVersion::k5:
      return OpenMat5File(path, limits);
    case MatVersion::k73:
      return OpenMat73File(path, limits);
    case MatVersion::kNone:
      break;
  }
  return Error{path + ": expected a MATLAB 5 or 7.3 file, got something else"};
}

}  // namespace tagtwist::internal

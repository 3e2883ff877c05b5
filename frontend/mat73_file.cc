#include "frontend/mat_backends.h"

namespace tagtwist {

Result<std::unique_ptr<MatFile>> OpenMat73File(const std::string& path) {
  return Error{path + ": MATLAB 7.3 files are not read; save it with '-v7'"};
}

}  // namespace tagtwist

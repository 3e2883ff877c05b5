#pragma once
#include <memory>
#include <string>

#include "frontend/base/limits.h"
#include "frontend/io/mat/mat_contents.h"

namespace tagtwist::internal {

/// MATLAB 5 files, by libmatio.
Result<std::unique_ptr<MatFile>> OpenMat5File(const std::string& path, const Limits& limits);
/// MATLAB 7.3 files, by HDF5 itself: libmatio 1.5 takes time quadratic in the number of structs.
Result<std::unique_ptr<MatFile>> OpenMat73File(const std::string& path, const Limits& limits);

/// "path: data(17).img: " for messages; packets count from 1, as in MATLAB.
std::string FieldPlace(const std::string& path, const std::string& packets_name, size_t packet,
                       const std::string& field);

}  // namespace tagtwist::internal

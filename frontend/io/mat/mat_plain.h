#pragma once
#include <string>

#include "frontend/base/limits.h"
#include "frontend/base/result.h"

namespace tagtwist::internal {

/// A MATLAB 5 file without compression.
struct PlainMat {
  std::string path;
  bool temporary = false;  // to be removed by who asked for it
};

/// Checks that a MATLAB 5 file is whole and, where a variable is compressed, inflates all of it
/// into a temporary file (in TMPDIR or /tmp). In a plain file a field is a seek away; in a
/// compressed struct it needs the inflater's state (40 KiB) kept for every field, or starting over.
/// The format: "MAT-File Level 5 File Format" of The MathWorks, chapter 1.
Result<PlainMat> MakePlainMat(const std::string& path, const Limits& limits = {});

/// That check without inflating: the variables' lengths fill the file exactly.
Status CheckMatIsWhole(const std::string& path);

}  // namespace tagtwist::internal

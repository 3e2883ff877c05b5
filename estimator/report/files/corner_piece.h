#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "frontend/base/files/run_files.h"
#include "frontend/base/result.h"
#include "frontend/types/measured_tags.h"

namespace tagtwist::internal {

/// The corners of a range of a recording's frames, measured in a run of its own, so that several
/// runs can share the search of a long recording.
struct CornerPiece {
  std::string dataset;  // as the run named it
  std::string
      measured_with;        // SHA-256 of what of the configuration decides which corners are found
  size_t frames = 0;        // of the whole recording
  size_t from = 0, to = 0;  // frames from to to - 1 are these
  int64_t first_ns = 0, last_ns = 0;  // the recording's stamps
};

/// The files of a piece in its folder: piece.json and detections.csv.
OutputSet PieceSet(const std::string& folder);
/// Puts them there, both or none.
Status WritePiece(const std::string& folder, const CornerPiece& piece,
                  const std::string& detections_csv);

/// Files that ReadPieces reads there.
std::vector<std::string> FilesOfPieces(const std::string& folder);
/// The corners of the pieces in `folder` and in the folders in it. Refused where they are not the
/// corners of all frames of `wanted`'s recording, each once, measured by the same version and what
/// `wanted` says.
Result<MeasuredTags> ReadPieces(const std::string& folder, const CornerPiece& wanted);

}  // namespace tagtwist::internal

#pragma once
#include <string>
#include <vector>

#include "frontend/base/files/run_files.h"

namespace tagtwist::internal {

/// Names of all files that WriteResults may write into a folder.
const std::vector<std::string>& ResultNames();

/// What of WriteResults' files a run may write.
struct ResultKinds {
  bool window = false, covariance = false, calibration = false, mapping = false, detections = false;
  std::vector<std::string> bodies = {};  // names, where there are several
};

/// Files of one of several bodies, called after it.
std::vector<std::string> BodyFileNames(const std::string& body, const ResultKinds& kinds);

/// Such files of the bodies that a run's summary in that folder names.
std::vector<std::string> OlderBodyFiles(const std::string& folder);

/// Those files, and what of older runs goes where this run does not write it.
OutputSet ResultSet(const std::string& folder, const ResultKinds& kinds);

}  // namespace tagtwist::internal

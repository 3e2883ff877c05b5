#pragma once
#include <string>
#include <vector>

#include "apps/estimate/estimate_flags.h"
#include "frontend/base/files/input_digest.h"

namespace tagtwist::internal {

/// What a run takes, told before it begins.
struct Inputs {
  std::vector<std::string> lines;     // recording, camera, mount, map, truth: one each
  std::vector<std::string> warnings;  // what was passed over, and what is not used
  std::vector<TruthSample> truth;     // of the file that is named, else the recording's own
};

/// An error where the ground truth cannot be read or lies outside the recording's time; it names
/// both spans.
Result<Inputs> TakeInputs(const EstimateJob& job, const Config& config, const DataSource& source);

/// The files that the job names, with their digests.
std::vector<InputFile> InputFilesOf(const EstimateJob& job);

/// Refuses to write over what the job reads. Names of older results that stay: this run reads them.
Result<std::vector<std::string>> CheckInputsAreKept(const EstimateJob& job, const Config& config);

/// The configuration as it was resolved from files and flags: the YAML of camera, mount and
/// options; of the map its size and the digest of its YAML.
std::string ConfigurationText(const Config& config);

/// Refuses a camera of one's own without a map: the course's mat is assumed only with the course's
/// camera.
Status CheckMapIsGiven(const EstimateJob& job, const Config& config);

}  // namespace tagtwist::internal

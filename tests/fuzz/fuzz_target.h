#pragma once
#include <stdexcept>
#include <string>
#include <vector>

#include "frontend/base/printable.h"
#include "frontend/base/result.h"

namespace tagtwist::internal {

/// Bytes to start from.
struct FuzzSeed {
  std::string name, bytes;
};

/// Something that takes any bytes, and does with them what the programs would.
struct FuzzTarget {
  const char* name;  // "yaml"
  /// True where they were taken by one of the readers; throws Broken where a promise was not kept.
  bool (*run)(const std::string& bytes);
  std::vector<FuzzSeed> (*seeds)();  // made by the project's own writers, and taken
};

/// All of them, in order of name.
const std::vector<FuzzTarget>& FuzzTargets();
/// nullptr: no target has that name.
const FuzzTarget* FindFuzzTarget(const std::string& name);

/// A promise that was not kept.
struct Broken : std::logic_error {
  using std::logic_error::logic_error;
};

inline void Promise(bool kept, const std::string& what) {
  if (!kept) throw Broken(what);
}

/// A refusal is one line, of a length that a person reads.
template <typename T>
bool IsTaken(const Result<T>& result) {
  if (result) return true;
  const std::string& message = result.error().message;
  Promise(!message.empty(), "a refusal without a word");
  Promise(message.find('\n') == std::string::npos, "more than one line: " + message);
  Promise(Printable(message) == message, "a character that a terminal obeys: " + message);
  Promise(message.size() < 4000, "a line too long to read");
  return false;
}

// The targets, by what they read.
bool FuzzCamera(const std::string& bytes);
bool FuzzConfig(const std::string& bytes);
bool FuzzMap(const std::string& bytes);
bool FuzzStates(const std::string& bytes);
bool FuzzTable(const std::string& bytes);
bool FuzzTruth(const std::string& bytes);
bool FuzzYaml(const std::string& bytes);
bool FuzzBag(const std::string& bytes);
bool FuzzEuroc(const std::string& bytes);
bool FuzzFolder(const std::string& bytes);
bool FuzzMat(const std::string& bytes);
bool FuzzRos2(const std::string& bytes);
bool FuzzVideo(const std::string& bytes);
bool FuzzImage(const std::string& bytes);
bool FuzzMessage(const std::string& bytes);
bool FuzzRawImage(const std::string& bytes);
bool FuzzEstimator(const std::string& bytes);
bool FuzzFlight(const std::string& bytes);

// What they start from.
std::vector<FuzzSeed> CameraSeeds();
std::vector<FuzzSeed> ConfigSeeds();
std::vector<FuzzSeed> MapSeeds();
std::vector<FuzzSeed> StatesSeeds();
std::vector<FuzzSeed> TableSeeds();
std::vector<FuzzSeed> TruthSeeds();
std::vector<FuzzSeed> YamlSeeds();
std::vector<FuzzSeed> BagSeeds();
std::vector<FuzzSeed> EurocSeeds();
std::vector<FuzzSeed> FolderSeeds();
std::vector<FuzzSeed> Mat5Seeds();
std::vector<FuzzSeed> Mat73Seeds();
std::vector<FuzzSeed> McapSeeds();
std::vector<FuzzSeed> SqliteSeeds();
std::vector<FuzzSeed> VideoSeeds();
std::vector<FuzzSeed> ImageSeeds();
std::vector<FuzzSeed> MessageSeeds();
std::vector<FuzzSeed> RawImageSeeds();
std::vector<FuzzSeed> EstimatorSeeds();
std::vector<FuzzSeed> FlightSeeds();

}  // namespace tagtwist::internal

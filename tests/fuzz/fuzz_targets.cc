#include "tests/fuzz/fuzz_target.h"

namespace tagtwist::internal {

const std::vector<FuzzTarget>& FuzzTargets() {
  static const std::vector<FuzzTarget> targets = {
      {"bag", FuzzBag, BagSeeds},
      {"camera", FuzzCamera, CameraSeeds},
      {"config", FuzzConfig, ConfigSeeds},
      {"estimator", FuzzEstimator, EstimatorSeeds},
      {"euroc", FuzzEuroc, EurocSeeds},
      {"flight", FuzzFlight, FlightSeeds},
      {"folder", FuzzFolder, FolderSeeds},
      {"image", FuzzImage, ImageSeeds},
      {"map", FuzzMap, MapSeeds},
      {"mat5", FuzzMat, Mat5Seeds},
      {"mat73", FuzzMat, Mat73Seeds},
      {"mcap", FuzzRos2, McapSeeds},
      {"message", FuzzMessage, MessageSeeds},
      {"raw_image", FuzzRawImage, RawImageSeeds},
      {"sqlite", FuzzRos2, SqliteSeeds},
      {"states", FuzzStates, StatesSeeds},
      {"table", FuzzTable, TableSeeds},
      {"truth", FuzzTruth, TruthSeeds},
      {"video", FuzzVideo, VideoSeeds},
      {"yaml", FuzzYaml, YamlSeeds},
  };
  return targets;
}

const FuzzTarget* FindFuzzTarget(const std::string& name) {
  for (const FuzzTarget& target : FuzzTargets()) {
    if (target.name == name) return &target;
  }
  return nullptr;
}

}  // namespace tagtwist::internal

#pragma once
#include <string>
#include <vector>

#include "estimator/calibration/options.h"
#include "estimator/graph/estimator_options.h"
#include "estimator/imu/imu_options.h"
#include "frontend/base/limits.h"
#include "frontend/base/result.h"
#include "frontend/front_end.h"
#include "frontend/io/setup/tag_map_file.h"
#include "frontend/types/rig.h"

namespace tagtwist {

/// Where the parts of a set-up come from, in words for the person who runs it.
struct SetUpOrigins {
  std::string camera, mount, map;
  bool map_is_assumed = true;      // no file names one: it is the course's mat
  std::vector<std::string> notes;  // what the files say and is not used: a line each
};

/// Where the recording of one of a rig's cameras is.
struct CameraRecording {
  std::string path;   // from the data set's folder
  std::string topic;  // of its images in a bag; empty: the only one that has any
};

/// All that a run is configured with.
struct Config {
  SetUp set_up;                        // its map is without the movable tags
  std::vector<int> movable_tags = {};  // ids, ascending: they may be anywhere, and are passed over
  FrontEndOptions front_end;
  EstimatorOptions estimator;
  ImuOptions imu;  // of the recording's, where a run takes it
  CalibrationOptions calibration;
  SetUpOrigins origins;
  Limits limits = {};  // of the recording's files
  /// Of the section `cameras`, one a camera; empty: the data set is the one camera's recording.
  std::vector<CameraRecording> recordings = {};
  /// Of the map's section `bodies`: tags that move, each with a trajectory of its own, besides
  /// set_up.map. Where the cameras stand the first one's are set_up.map, and `body` is its name.
  std::vector<TaggedBody> bodies = {};
  std::string body = {};

  /// The tags of set_up.map and of all bodies, whatever the frame of each.
  TagMap AllTags() const;
  /// What each is estimated with, set_up first; a body before a camera that moves as if it stood.
  std::vector<SetUp> SetUps() const;
};

/// The course's camera, extrinsic and mat, and the defaults of every options struct.
Config DefaultConfig();

/// Files that a run is configured from; an empty name: none.
struct ConfigFiles {
  std::string config;       // LoadConfig(path)
  std::string camera_file;  // a calibration (ReadCameraFile); before the configuration's camera
  /// Which of its cameras; cam0,cam1 or all: several, a rig, whose recordings go by their names.
  std::string camera_name;
  TagMapFile map;                      // before the configuration's tag map
  std::vector<int> movable_tags = {};  // besides the configuration's
  Limits limits = {};                  // of these files, and of what is read by Config.limits
};

/// Reads a configuration (docs/formats.md). Sections and keys that are left out keep their
/// defaults, those of DefaultConfig(); everything else must be right: an unknown or repeated key, a
/// wrong type, a value out of its range or a missing needed key is an error
/// "file:line: section.key: expected ..., got ...".
/// Where the camera comes from a calibration file and there is no `cam_from_body`, the
/// calibration's own mount counts, or else the camera is the body.
Result<Config> LoadConfig(const std::string& path);

/// The configuration, or the defaults without one, with what the other files say instead.
Result<Config> LoadConfig(const ConfigFiles& files);

}  // namespace tagtwist

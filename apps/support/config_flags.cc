#include "apps/support/config_flags.h"

#include <gflags/gflags.h>

#include <limits>
#include <sstream>

#include "apps/support/limits_flag.h"
#include "frontend/base/number_text.h"

DEFINE_string(
    config, "",
    "Camera, mount, tag map and options (YAML); configs/course.yaml's values without it.");
DEFINE_string(
    camera_file, "",
    "Calibration to take the camera from: Kalibr camchain, OpenCV YAML or XML, ROS "
    "camera_info, EuRoC's folder of several, or a configuration. Before the one in --config.");
DEFINE_string(camera, "",
              "Which camera of --camera_file, where it has several: cam1. cam0,cam1 or all: a rig "
              "of these, whose recordings in --dataset go by their names.");
DEFINE_string(map, "",
              "Where the tags are: Kalibr aprilgrid, WPILib field, TagSLAM bodies, or a "
              "configuration. Before the one in --config.");
DEFINE_double(tag_size_m, 0, "Side of a tag's black square, where --map does not say it (WPILib).");
DEFINE_string(movable_tags, "",
              "Ids of tags that may be anywhere, as 3,7: passed over, besides the config's.");
DEFINE_string(tag_family, "", "The tags' family, where --map does not say it and means another.");

namespace tagtwist::internal {
namespace {

Status ReadMovableTags(std::vector<int>* ids) {
  std::istringstream list(FLAGS_movable_tags);
  for (std::string item; std::getline(list, item, ',');) {
    const auto id = ParseInteger(item);
    if (!id || *id < 0 || *id > std::numeric_limits<int>::max()) {
      return Error{"--movable_tags: expected ids as 3,7, got \"" + FLAGS_movable_tags + "\""};
    }
    ids->push_back(static_cast<int>(*id));
  }
  return Ok();
}

}  // namespace

FlagGroup ConfigFlags() {
  return {"Camera and map",
          {"config", "camera_file", "camera", "map", "tag_size_m", "tag_family", "movable_tags"}};
}

Result<ConfigFiles> ConfigFilesFromFlags() {
  if (!FLAGS_camera.empty() && FLAGS_camera_file.empty()) {
    return Error{"--camera: expected with --camera_file"};
  }
  const bool of_map = FLAGS_tag_size_m != 0 || !FLAGS_tag_family.empty();
  if (of_map && FLAGS_map.empty()) return Error{"--tag_size_m, --tag_family: expected with --map"};
  if (!(FLAGS_tag_size_m >= 0)) {
    return Error{"--tag_size_m: expected > 0, got " + std::to_string(FLAGS_tag_size_m)};
  }
  ConfigFiles files{
      FLAGS_config, FLAGS_camera_file, FLAGS_camera, {FLAGS_map, {}, FLAGS_tag_family}, {}, {}};
  const auto limits = LimitsFromFlag();
  if (!limits) return limits.error();
  files.limits = *limits;
  if (const Status read = ReadMovableTags(&files.movable_tags); !read) return read.error();
  if (FLAGS_tag_size_m > 0) files.map.tag_size_m = FLAGS_tag_size_m;
  return files;
}

}  // namespace tagtwist::internal

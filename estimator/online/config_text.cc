#include "estimator/online/config_text.h"

#include <type_traits>
#include <utility>
#include <vector>

#include "frontend/base/named_enum.h"
#include "frontend/base/number_text.h"
#include "frontend/io/setup/camera_section.h"
#include "frontend/io/setup/tag_map_text.h"
#include "frontend/types/lens/lens.h"
#include "residuals/lens.h"

namespace tagtwist::internal {
namespace {

// Visitor of an options struct: "  name: value" a field; a field that is not given is left out.
struct OptionLines {
  std::string text;
  template <typename T>
  void operator()(const char* name, const T& value) {
    if constexpr (std::is_same_v<T, std::string>) {
      Add(name, value);
    } else if constexpr (std::is_enum_v<T>) {
      Add(name, NameOf(value));
    } else if constexpr (std::is_same_v<T, bool>) {
      Add(name, value ? "true" : "false");
    } else if constexpr (std::is_integral_v<T>) {
      Add(name, std::to_string(value));
    } else if constexpr (std::is_floating_point_v<T>) {
      Add(name, FormatNumber(value));
    } else if (value) {
      (*this)(name, *value);
    }
  }
  void Add(const char* name, const std::string& value) {
    text += std::string("  ") + name + ": " + value + "\n";
  }
};

template <typename Options>
std::string SectionText(const char* section, const Options& options) {
  OptionLines lines;
  Options::VisitFields(options, lines);
  return std::string("\n") + section + ":\n" + lines.text;
}

// The keys of a camera and of its mount, each line behind an indent.
std::string CameraKeysText(const RigCamera& mounted, const std::string& indent) {
  const Camera& camera = mounted.camera;
  std::string out = indent + "width: " + std::to_string(camera.width) + "\n" + indent +
                    "height: " + std::to_string(camera.height) + "\n";
  for (const auto& [name, value] : {std::pair("fx", camera.fx), std::pair("fy", camera.fy),
                                    std::pair("cx", camera.cx), std::pair("cy", camera.cy)}) {
    out += indent + name + ": " + FormatNumber(value) + "\n";
  }
  if (camera.IsDistorted()) {
    out += indent + "distortion_model: " + LensName(camera.lens) + "\n" + indent +
           "distortion: " + FormatNumberList(DistortionCoefficients(camera)) + "\n";
  }
  if (mounted.line_time_s != 0) {
    out += indent + "line_time_s: " + FormatNumber(mounted.line_time_s) + "\n";
  }
  return out + LensSigmaLines(mounted, indent);
}

std::string MountKeysText(const RigCamera& mounted, const std::string& indent) {
  const Pose& pose = mounted.cam_from_body;
  return indent + "quaternion_xyzw: " + FormatNumberList(pose.params.head<4>()) + "\n" + indent +
         "translation_m: " + FormatNumberList(pose.translation()) + "\n" +
         MountSigmaLines(mounted, indent);
}

}  // namespace

std::string CameraSectionText(const Config& config) {
  return "\ncamera:\n" + CameraKeysText(config.set_up.rig.front(), "  ");
}

std::string MountSectionText(const Config& config) {
  const bool on_body = config.set_up.rig.mounted_on == MountedOn::kBody;
  return (on_body ? "\ncam_from_body:\n" : "\ncam_from_world:\n") +
         MountKeysText(config.set_up.rig.front(), "  ");
}

std::string CamerasSectionText(const Config& config) {
  const bool on_body = config.set_up.rig.mounted_on == MountedOn::kBody;
  std::string out = "\ncameras:\n";
  for (size_t i = 0; i < config.recordings.size(); ++i) {
    const RigCamera& mounted = config.set_up.rig.cameras.at(i);
    const CameraRecording& recording = config.recordings[i];
    out += "  - name: \"" + mounted.name + "\"\n    recording: \"" + recording.path + "\"\n";
    if (!recording.topic.empty()) out += "    topic: \"" + recording.topic + "\"\n";
    out += "    clock_offset_s: " + FormatNumber(mounted.clock_offset_s) + "\n    camera:\n" +
           CameraKeysText(mounted, "      ") +
           (on_body ? "    cam_from_body:\n" : "    mounted_on: world\n    cam_from_world:\n") +
           MountKeysText(mounted, "      ");
  }
  return out;
}

std::string MapSectionText(const Config& config) {
  std::string out = "\n" + FormatTagMap(config.set_up.map);
  for (const TaggedBody& body : config.bodies) {
    out += "\n# of " + body.name + "\n" + FormatTagMap(body.map);
  }
  return out;
}

std::string DetectorSectionText(const Config& config) {
  return SectionText("detector", config.front_end.detector);
}

std::string OptionsText(const Config& config) {
  std::string out;
  if (!config.movable_tags.empty()) {
    const std::vector<double> ids(config.movable_tags.begin(), config.movable_tags.end());
    const auto n = static_cast<Eigen::Index>(ids.size());
    out += "\nmovable_tags: " + FormatNumberList(Eigen::VectorXd::Map(ids.data(), n)) + "\n";
  }
  out += DetectorSectionText(config);
  out += SectionText("klt", config.front_end.klt);
  out += SectionText("closed_form", config.front_end.closed_form);
  out += SectionText("estimator", config.estimator);
  return out + SectionText("imu", config.imu) + SectionText("calibration", config.calibration);
}

}  // namespace tagtwist::internal

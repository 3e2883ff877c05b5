#include "frontend/io/recordings/camera_info.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>

#include "frontend/base/number_text.h"
#include "frontend/io/recordings/data_source_kinds.h"

namespace tagtwist::internal {
namespace {

template <typename Numbers>
std::string NumbersText(const Numbers& numbers) {
  std::string out = "[";
  for (const double number : numbers) out += (out.size() > 1 ? ", " : "") + FormatNumber(number);
  return out + "]";
}

// Names are of letters, digits and underscores; whatever else would be YAML's.
std::string OnlyName(std::string text) {
  for (char& sign : text) {
    if (std::isalnum(static_cast<unsigned char>(sign)) == 0 && sign != '_') sign = '?';
  }
  return text;
}

bool IsRos1Bag(const std::string& path) {
  constexpr size_t kLength = 7;
  std::ifstream file(path, std::ios::binary);
  std::string begin(kLength, '\0');
  return file.read(begin.data(), kLength) && begin == "#ROSBAG";
}

}  // namespace

std::string CameraInfoText(const RosCameraInfo& info) {
  const auto member = [](const char* name, uint32_t value) {
    return std::string(name) + ": " + std::to_string(value);
  };
  return member("height", info.height) + "\n" + member("width", info.width) +
         "\ndistortion_model: '" + OnlyName(info.distortion_model) +
         "'\nD: " + NumbersText(info.d) + "\nK: " + NumbersText(info.k) + "\n" +
         member("binning_x", info.binning_x) + "\n" + member("binning_y", info.binning_y) +
         "\nroi: {" + member("x_offset", info.roi_x) + ", " + member("y_offset", info.roi_y) +
         ", " + member("height", info.roi_height) + ", " + member("width", info.roi_width) + "}\n";
}

bool IsRosBag(const std::string& path) {
  std::error_code unknown;
  if (std::filesystem::is_directory(path, unknown)) return IsRos2Bag(path);
  if (!std::filesystem::is_regular_file(path, unknown)) return false;
  return IsRos1Bag(path) || IsRos2Bag(path);
}

Result<std::string> ReadBagCameraInfo(const std::string& path, const std::string& topic,
                                      const Limits& limits) {
  const auto info = IsRos2Bag(path) ? ReadRos2CameraInfo(path, topic, limits)
                                    : ReadRos1CameraInfo(path, topic, limits);
  if (!info) return info.error();
  return CameraInfoText(*info);
}

}  // namespace tagtwist::internal

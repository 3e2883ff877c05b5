#include "estimator/online/map_section.h"

#include <filesystem>
#include <utility>

#include "estimator/online/camera_sections.h"
#include "frontend/base/option_check.h"
#include "frontend/io/setup/tag_map_file.h"
#include "frontend/io/setup/tag_map_reader.h"
#include "frontend/io/setup/yaml_reader.h"

namespace tagtwist::internal {

Result<TagMap> ReadMapSection(const YamlValue& node, const Limits& limits,
                              std::optional<double>* sigma_m) {
  constexpr double kMostM = 100;
  YamlSection section(node);
  section("sigma_m", *sigma_m);
  if (*sigma_m) section.KeepProblem(CheckRange("sigma_m", **sigma_m, 0.0, kMostM));
  if (const Status read = section.FirstFault(); !read) return read.error();
  TagMapFile file;
  section("file", file.path);
  if (file.path.empty()) {
    Result<TagMap> map = ReadTagMap(node);
    const auto problem = map ? CheckTagMap(*map) : std::nullopt;
    return problem ? Result<TagMap>(node.Refuse("a possible map, got " + *problem)) : map;
  }
  section("tag_size_m", file.tag_size_m);
  section("family", file.family);
  if (Status status = section.Finish(); !status) return status.error();
  file.path = BesideFile(node.file, file.path);
  return ReadTagMapFile(file, limits);
}

std::optional<double> SigmaOfMapFile(const std::string& path, const Limits& limits) {
  std::error_code none;
  if (!std::filesystem::is_regular_file(path, none)) return std::nullopt;
  const Result<YamlValue> root = ReadYaml(path, limits);
  if (!root) return std::nullopt;
  const YamlValue* own = Member(*root, "tag_map");
  const YamlValue* sigma = Member(own != nullptr ? *own : *root, "sigma_m");
  double out = 0;
  if (sigma == nullptr || !ReadValue(*sigma, &out)) return std::nullopt;
  return out >= 0 ? std::optional(out) : std::nullopt;
}

}  // namespace tagtwist::internal

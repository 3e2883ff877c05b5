#include "frontend/io/setup/tag_map_file.h"

#include <Eigen/LU>
#include <cmath>
#include <utility>
#include <vector>

#include "frontend/base/files/input_file.h"
#include "frontend/io/setup/field_maps.h"
#include "frontend/io/setup/rig/tagslam_pose.h"
#include "frontend/io/setup/tag_map_reader.h"
#include "frontend/io/setup/yaml_reader.h"
#include "frontend/io/setup/yaml_tree.h"
#include "frontend/types/tag_family.h"
#include "frontend/types/tag_overlap.h"

namespace tagtwist {

using namespace internal;
namespace {

// Kalibr: ids row by row from the bottom left, upright, tagSpacing as a share of tagSize. World:
// origin at the bottom-left corner of the first tag, x right, y up, z out of the paper.
Result<TagMap> ReadAprilGrid(const YamlValue& root, const std::string& family,
                             const Limits& limits) {
  YamlSection section(root);
  std::string type;
  int columns = 0, rows = 0;
  double size_m = 0, spacing = 0;
  int first_id = 0, border_cells = 2;
  section("target_type", type);
  if (type != "aprilgrid") {
    section.Keep(section.Find("target_type")
                     ->Refuse("aprilgrid (a board without ids cannot be a map), got " + type));
  }
  for (const char* name : {"tagStartId", "startId", "start_id", "low_id", "firstId"}) {
    section(name, first_id);
  }
  section("borderBits", border_cells);
  section.Require("tagCols", &columns);
  section.Require("tagRows", &rows);
  section.Require("tagSize", &size_m);
  section.Require("tagSpacing", &spacing);
  const auto check = [&](const char* name, bool good, const std::string& expected) {
    const YamlValue* node = section.Find(name);
    if (node != nullptr && !good) section.Keep(node->Refuse(expected));
  };
  const std::string fewer = ">= 1, and fewer tags" + RaisesLimit("tags");
  check("tagCols", columns >= 1, ">= 1");
  check("tagRows", rows >= 1, ">= 1");
  check("tagCols", columns <= limits.tags, fewer);
  check("tagRows", rows <= limits.tags / std::max(columns, 1), fewer);
  check("tagSize", size_m > 0, "> 0 [m]");
  check("tagSpacing", spacing >= 0, ">= 0, a share of tagSize");
  check("borderBits", border_cells == 1 || border_cells == 2, "1 or 2");
  if (Status status = section.FirstFault(); !status) return status.error();
  std::vector<Tag> tags;
  const double step_m = size_m * (1 + spacing);
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const Eigen::Vector3d centre(column * step_m + 0.5 * size_m, row * step_m + 0.5 * size_m, 0);
      tags.push_back({first_id + columns * row + column,
                      MakePose(Eigen::Quaterniond::Identity(), centre), size_m});
    }
  }
  const std::string usual = border_cells == 1 ? "tag36h11" : kKalibrFamily;
  return TagMap(family.empty() ? usual : family, std::move(tags));
}

// The tags of a board of a body of TagSLAM's, row by row; the board's origin is the centre of its
// first tag, its pose, where it has one, is body to board.
Status AddTagSlamBoard(const YamlValue& board, const Pose& world_from_body, const Limits& limits,
                       std::vector<Tag>* tags) {
  YamlSection section(board);
  int first_id = 0, rows = 0, columns = 0;
  double size_m = 0, spacing = 0;
  section.Require("tag_start_id", &first_id);
  section.Require("tag_size", &size_m);
  section.Require("tag_spacing", &spacing);
  section.Require("tag_rows", &rows);
  section.Require("tag_columns", &columns);
  const Pose board_from_body = ReadTagSlamPose(section.Find("pose"), &section);
  if (Status status = section.FirstFault(); !status) return status;
  // Of all boards: a file may have many.
  const int64_t left = limits.tags - static_cast<int64_t>(tags->size());
  if (rows < 1 || columns < 1 || rows > left / columns) {
    return board.Refuse("tag_rows and tag_columns >= 1, and fewer tags" + RaisesLimit("tags"));
  }
  if (first_id < 0 || first_id > limits.tags) return board.Refuse("tag_start_id >= 0, and a tag's");
  if (!(size_m > 0) || !(spacing >= 0)) {
    return board.Refuse("tag_size > 0 [m] and tag_spacing >= 0, a share of it");
  }
  const double step_m = size_m * (1 + spacing);
  for (int i = 0; i < rows * columns; ++i) {
    const Eigen::Vector3d centre(i % columns * step_m, i / columns * step_m, 0);
    tags->push_back({first_id + i,
                     world_from_body * Inverse(board_from_body) *
                         MakePose(Eigen::Quaterniond::Identity(), centre),
                     size_m});
  }
  return Ok();
}

Status ReadTagSlamBody(const YamlValue& body, const Limits& limits, std::vector<Tag>* tags) {
  YamlSection section(body);
  bool is_static = false;
  std::optional<double> default_size_m;
  section("is_static", is_static);
  section("default_tag_size", default_size_m);
  const YamlValue* list = section.Find("tags");
  const YamlValue* board = section.Find("board");
  if (!is_static || (list == nullptr && board == nullptr)) return section.FirstFault();
  if (section.Find("pose") == nullptr) {
    return body.Refuse(
        "a pose, got none (TagSLAM would estimate it): give it, or leave the body out "
        "and let --map_unknown_tags place its tags");
  }
  const Pose world_from_body = ReadTagSlamPose(section.Find("pose"), &section);
  if (list != nullptr && list->kind != YamlValue::Kind::kList) {
    section.Keep(list->Refuse("a list of tags"));
  }
  if (Status status = section.FirstFault(); !status) return status;
  if (board != nullptr) {
    if (Status status = AddTagSlamBoard(*board, world_from_body, limits, tags); !status)
      return status;
  }
  if (list == nullptr) return Ok();
  for (const YamlValue& item : list->items) {
    YamlSection of_tag(item);
    Tag tag;
    of_tag.Require("id", &tag.id);
    if (default_size_m) tag.size_m = *default_size_m;
    default_size_m ? of_tag("size", tag.size_m) : of_tag.Require("size", &tag.size_m);
    const YamlValue* pose = of_tag.Require(std::string("pose"));
    tag.world_from_tag = world_from_body * ReadTagSlamPose(pose, &of_tag);
    if (Status status = of_tag.FirstFault(); !status) return status;
    tags->push_back(tag);
  }
  return Ok();
}

Result<TagMap> ReadTagSlam(const YamlValue& bodies, const std::string& family,
                           const Limits& limits) {
  if (bodies.kind != YamlValue::Kind::kList) return bodies.Refuse("a list of bodies");
  std::vector<Tag> tags;
  for (const YamlValue& entry : bodies.items) {  // a mapping from its name
    if (entry.kind != YamlValue::Kind::kMapping) return entry.Refuse("a body by its name");
    for (const auto& [name, body] : entry.members) {
      if (Status status = ReadTagSlamBody(body, limits, &tags); !status) return status.error();
    }
  }
  if (tags.empty()) return bodies.Refuse("a static body with tags, got none");
  return TagMap(family.empty() ? "tag36h11" : family, std::move(tags));
}

Result<TagMap> ReadAny(const YamlValue& root, const TagMapFile& file, const Limits& limits) {
  YamlSection section(root);
  if (section.Find("target_type") != nullptr) {
    return ReadAprilGrid(root, file.family, limits);
  }
  if (const YamlValue* bodies = section.Find("bodies")) {
    return ReadTagSlam(*bodies, file.family, limits);
  }
  if (const YamlValue* bundles = section.Find("tag_bundles")) {
    return ReadBundle(*bundles, file.family);
  }
  if (const YamlValue* fiducials = section.Find("fiducials")) {
    return ReadLimelight(*fiducials, file.family);
  }
  if (const YamlValue* own = section.Find("tag_map")) return ReadTagMap(*own);
  const YamlValue* tags = section.Find("tags");
  if (tags != nullptr && tags->kind == YamlValue::Kind::kList && !tags->items.empty() &&
      YamlSection(tags->items[0]).Find("ID") != nullptr) {
    return ReadWpilib(root, file.tag_size_m, file.family);
  }
  return ReadTagMap(root);
}

Result<TagMap> ReadUnchecked(const TagMapFile& file, const Limits& limits) {
  auto text = ReadTextFile(file.path, limits);
  if (!text) return text.error();
  if (IsFieldCsv(*text)) {
    return ReadFieldCsv(std::move(*text), file.path, file.tag_size_m, file.family);
  }
  const Result<YamlValue> root = ParseYaml(std::move(*text), file.path, limits);
  return root ? ReadAny(*root, file, limits) : root.error();
}

}  // namespace

Result<TagMap> ReadTagMapFile(const TagMapFile& file, const Limits& limits) {
  if (file.tag_size_m && !(*file.tag_size_m > 0)) {
    return Error{"tag_size_m: expected > 0, got " + std::to_string(*file.tag_size_m)};
  }
  Result<TagMap> map = ReadUnchecked(file, limits);
  if (!map) return map;
  if (const auto problem = CheckTagMap(*map)) return Error{file.path + ": " + *problem};
  return map;
}

std::optional<std::string> CheckTagMap(const TagMap& map) {
  if (auto problem = map.Problem()) return problem;
  const Result<int> size = TagFamilySize(map.family());
  if (!size) return size.error().message;
  for (const Tag& tag : map.tags()) {
    if (tag.id >= *size) {
      return "tag " + std::to_string(tag.id) + ": expected ids 0.." + std::to_string(*size - 1) +
             " of " + map.family();
    }
  }
  const auto overlap = FindOverlap(map);
  if (!overlap) return std::nullopt;
  return "tags " + std::to_string(overlap->first) + " and " + std::to_string(overlap->second) +
         " overlap";
}

}  // namespace tagtwist

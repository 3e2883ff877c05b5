#include "frontend/io/setup/tag_map_reader.h"

#include <Eigen/LU>
#include <array>
#include <cmath>
#include <set>

#include "frontend/types/tag_family.h"

namespace tagtwist::internal {
namespace {

// A family and the number of its ids.
struct Family {
  std::string name = "tag36h11";
  int size = 0;
  std::string Ids() const { return "0.." + std::to_string(size - 1); }
};
constexpr double kUnitTolerance = 1e-3;

std::string MillimetresText(double metres) {
  return std::to_string(1e3 * metres).substr(0, 6) + " mm";
}

// `gaps` is one number for all, or a list of `count` of them.
void ReadGaps(const char* name, int count, YamlSection* section, std::vector<double>* gaps) {
  const YamlValue* node = section->Require(name);
  if (node == nullptr) return;
  if (node->kind == YamlValue::Kind::kList) {
    section->Keep(ReadNumbers(*node, 0, gaps));
    return;
  }
  double gap = 0;
  section->Keep(ReadValue(*node, &gap));
  gaps->assign(static_cast<size_t>(count), gap);
}

Result<TagMap> ReadGrid(const YamlValue& node, const Family& family) {
  YamlSection section(node);
  TagGrid grid;
  grid.family = family.name;
  section("first_id", grid.first_id);
  section.Require("rows", &grid.rows);
  section.Require("columns", &grid.columns);
  section.Require("tag_size_m", &grid.tag_size_m);
  const bool in_family = grid.first_id >= 0 && grid.first_id < family.size && grid.rows >= 1 &&
                         grid.rows <= family.size && grid.columns >= 1 &&
                         grid.columns <= (family.size - grid.first_id) / grid.rows;
  if (!in_family) {
    const YamlValue* rows = node.kind == YamlValue::Kind::kMapping ? section.Find("rows") : nullptr;
    section.Keep((rows != nullptr ? *rows : node)
                     .Refuse("first_id, rows and columns with ids " + family.Ids() + ", got " +
                             std::to_string(grid.first_id) + ", " + std::to_string(grid.rows) +
                             " and " + std::to_string(grid.columns)));
  }
  ReadGaps("row_gaps_m", in_family ? grid.rows - 1 : 0, &section, &grid.row_gaps_m);
  ReadGaps("column_gaps_m", in_family ? grid.columns - 1 : 0, &section, &grid.column_gaps_m);
  section.KeepProblem(grid.Problem());
  if (Status status = section.Finish(); !status) return status.error();
  return MakeTagMap(grid);
}

// The tag whose corners p1..p4 these are, as nearly as a square can.
Status FitTag(const YamlValue& node, Tag* tag) {
  constexpr double kTolerance = 0.02;  // of the side
  if (node.kind != YamlValue::Kind::kList || node.items.size() != 4) {
    return node.Refuse("a list of 4 corners");
  }
  std::array<Eigen::Vector3d, 4> corners;
  for (size_t i = 0; i < 4; ++i) {
    std::vector<double> numbers;
    if (Status status = ReadNumbers(node.items[i], 3, &numbers); !status) return status;
    corners[i] = Eigen::Vector3d(numbers[0], numbers[1], numbers[2]);
  }
  const auto& [p1, p2, p3, p4] = corners;
  const Eigen::Vector3d along_x = 0.5 * (p2 + p3 - p1 - p4), along_y = 0.5 * (p3 + p4 - p1 - p2);
  tag->size_m = 0.5 * (along_x.norm() + along_y.norm());
  Eigen::Matrix3d rotation;
  rotation.col(2) = along_x.cross(along_y).normalized();
  rotation.col(0) = along_x.normalized();
  rotation.col(1) = rotation.col(2).cross(rotation.col(0));
  if (!(tag->size_m > 0) || !rotation.allFinite() || !(rotation.determinant() > 0.5)) {
    return node.Refuse("the corners of a square, got points on a line");
  }
  tag->world_from_tag = MakePose(Eigen::Quaterniond(rotation), 0.25 * (p1 + p2 + p3 + p4));
  const auto fitted = TagCornersInWorld(*tag);
  for (size_t i = 0; i < 4; ++i) {
    const double off_m = (fitted[i] - corners[i]).norm();
    if (!(off_m <= kTolerance * tag->size_m)) {
      return node.Refuse("the corners of a square, got p" + std::to_string(i + 1) + " " +
                         MillimetresText(off_m) + " off");
    }
  }
  return Ok();
}

void ReadPlacedTag(YamlSection* section, Tag* tag) {
  section->Require("size_m", &tag->size_m);
  const auto centre = ReadVector3(section->Require("position_m"), section);
  const YamlValue* yaw_node = section->Find("yaw_rad");
  std::optional<Eigen::Quaterniond> rotation = ReadRotation(section);
  if (yaw_node != nullptr) {
    double yaw_rad = 0;
    section->Keep(ReadValue(*yaw_node, &yaw_rad));
    if (rotation) section->Keep(yaw_node->Refuse("either yaw_rad or another rotation, got both"));
    rotation = Eigen::Quaterniond(Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()));
  }
  if (!centre) return;
  tag->world_from_tag = MakePose(rotation.value_or(Eigen::Quaterniond::Identity()), *centre);
}

Status ReadTag(const YamlValue& node, const Family& family, Tag* tag) {
  YamlSection section(node);
  section.Require("id", &tag->id);
  std::string family_name = family.name;
  section("family", family_name);
  if (family_name != family.name) {
    section.KeepProblem("family: expected " + family.name + " like all tags of the map, got " +
                        family_name);
  }
  if (const YamlValue* corners = section.Find("corners_m"); corners != nullptr) {
    section.Keep(FitTag(*corners, tag));
  } else {
    ReadPlacedTag(&section, tag);
    if (!(tag->size_m > 0)) {
      section.KeepProblem("size_m: expected > 0, got " + std::to_string(tag->size_m));
    }
    section("bend_m", tag->bend_m);
    section.KeepProblem(BendProblem(*tag));
  }
  if (tag->id < 0 || tag->id >= family.size) {
    section.KeepProblem("id: expected " + family.Ids() + ", got " + std::to_string(tag->id));
  }
  return section.Finish();
}

Result<TagMap> ReadTags(const YamlValue& node, const Family& family) {
  if (node.kind != YamlValue::Kind::kList || node.items.empty()) {
    return node.Refuse("a list of tags");
  }
  std::vector<Tag> tags;
  std::set<int> ids;
  for (const YamlValue& item : node.items) {
    Tag tag;
    if (Status status = ReadTag(item, family, &tag); !status) return status.error();
    if (!ids.insert(tag.id).second) {
      return item.Refuse("each id once, got " + std::to_string(tag.id) + " again");
    }
    tags.push_back(tag);
  }
  return TagMap(family.name, std::move(tags));
}

}  // namespace

std::optional<Eigen::Vector3d> ReadVector3(const YamlValue* node, YamlSection* section) {
  if (node == nullptr) return std::nullopt;
  std::vector<double> numbers;
  if (Status status = ReadNumbers(*node, 3, &numbers); !status) {
    section->Keep(status);
    return std::nullopt;
  }
  return Eigen::Vector3d(numbers[0], numbers[1], numbers[2]);
}

Eigen::Vector3d ReadXyz(const YamlValue* node, YamlSection* parent) {
  Eigen::Vector3d out = Eigen::Vector3d::Zero();
  if (node == nullptr) return out;
  YamlSection section(*node);
  section.Require("x", &out.x());
  section.Require("y", &out.y());
  section.Require("z", &out.z());
  parent->Keep(section.FirstFault());
  return out;
}

std::optional<Eigen::Quaterniond> ReadRotation(YamlSection* section) {
  const YamlValue* matrix_node = section->Find("rotation");
  const YamlValue* quaternion_node = section->Find("quaternion_xyzw");
  if (matrix_node != nullptr && quaternion_node != nullptr) {
    section->Keep(quaternion_node->Refuse("either rotation or quaternion_xyzw, got both"));
    return std::nullopt;
  }
  std::vector<double> n;
  if (matrix_node != nullptr) {
    if (Status status = ReadNumbers(*matrix_node, 9, &n); !status) {
      section->Keep(status);
      return std::nullopt;
    }
    Eigen::Matrix3d matrix;
    matrix << n[0], n[1], n[2], n[3], n[4], n[5], n[6], n[7], n[8];
    const double off = (matrix.transpose() * matrix - Eigen::Matrix3d::Identity()).norm();
    if (!(off < kUnitTolerance) || !(matrix.determinant() > 0)) {
      section->Keep(matrix_node->Refuse("an orthonormal matrix with determinant +1, got another"));
      return std::nullopt;
    }
    return Eigen::Quaterniond(matrix).normalized();
  }
  if (quaternion_node == nullptr) return std::nullopt;
  if (Status status = ReadNumbers(*quaternion_node, 4, &n); !status) {
    section->Keep(status);
    return std::nullopt;
  }
  const Eigen::Quaterniond quaternion(n[3], n[0], n[1], n[2]);
  if (!(std::abs(quaternion.norm() - 1) < kUnitTolerance)) {
    section->Keep(quaternion_node->Refuse("a unit quaternion, got norm " +
                                          std::to_string(quaternion.norm())));
    return std::nullopt;
  }
  return quaternion.normalized();
}

Result<TagMap> ReadTagMap(const YamlValue& node) {
  YamlSection section(node);
  Family family;
  section("family", family.name);
  if (const Result<int> size = TagFamilySize(family.name); size) {
    family.size = *size;
  } else {
    std::string names;
    for (const std::string& name : TagFamilyNames()) names += (names.empty() ? "" : ", ") + name;
    section.KeepProblem("family: expected one of " + names + ", got " + family.name);
  }
  section.Find("sigma_m");  // of the estimate, not of the map
  const YamlValue* grid = section.Find("grid");
  const YamlValue* tags = section.Find("tags");
  if ((grid == nullptr) == (tags == nullptr)) {
    section.Keep(node.Refuse(grid == nullptr ? "grid or tags, got neither"
                                             : "either grid or tags, got both"));
  }
  if (Status status = section.Finish(); !status) return status.error();
  return grid != nullptr ? ReadGrid(*grid, family) : ReadTags(*tags, family);
}

}  // namespace tagtwist::internal

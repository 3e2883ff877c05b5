#include "frontend/io/setup/field_maps.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <utility>
#include <vector>

#include "frontend/io/setup/tag_map_reader.h"
#include "frontend/io/tables/csv.h"
#include "frontend/io/tables/text_grid.h"
#include "frontend/types/tag_family.h"

namespace tagtwist::internal {
namespace {

// WPILib: x out of the tag's face, y to the right as printed, z up.
Pose FromFace(const Eigen::Quaterniond& world_from_face, const Eigen::Vector3d& position) {
  Eigen::Matrix3d face_from_tag;
  face_from_tag << 0, 0, 1, 1, 0, 0, 0, 1, 0;
  return MakePose(world_from_face * Eigen::Quaterniond(face_from_tag), position);
}

Status ReadWpilibTag(const YamlValue& node, double size_m, Tag* tag) {
  YamlSection section(node);
  tag->size_m = size_m;
  section.Require("ID", &tag->id);
  const YamlValue* pose = section.Require(std::string("pose"));
  if (pose == nullptr) return section.FirstFault();
  YamlSection parts(*pose);
  const Eigen::Vector3d position = ReadXyz(parts.Require(std::string("translation")), &parts);
  const YamlValue* rotation = parts.Require(std::string("rotation"));
  if (rotation == nullptr) return parts.FirstFault();
  YamlSection turn(*rotation);
  const YamlValue* quaternion_node = turn.Require(std::string("quaternion"));
  if (quaternion_node == nullptr) return turn.FirstFault();
  YamlSection wxyz(*quaternion_node);
  Eigen::Quaterniond world_from_face(0, 0, 0, 0);
  wxyz.Require("W", &world_from_face.w());
  wxyz.Require("X", &world_from_face.x());
  wxyz.Require("Y", &world_from_face.y());
  wxyz.Require("Z", &world_from_face.z());
  if (!(std::abs(world_from_face.norm() - 1) < 1e-3)) {
    wxyz.Keep(quaternion_node->Refuse("a unit quaternion, got another"));
  }
  for (YamlSection* each : {&section, &parts, &wxyz}) {
    if (Status status = each->FirstFault(); !status) return status;
  }
  tag->world_from_tag = FromFace(world_from_face.normalized(), position);
  return Ok();
}

// apriltag_ros' tags.yaml: x y z and a quaternion in the bundle, tag frames as ours.
Status ReadBundleTag(const YamlValue& node, Tag* tag) {
  YamlSection section(node);
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  section.Require("id", &tag->id);
  section.Require("size", &tag->size_m);
  section("x", position.x());
  section("y", position.y());
  section("z", position.z());
  section("qw", rotation.w());
  section("qx", rotation.x());
  section("qy", rotation.y());
  section("qz", rotation.z());
  if (!(std::abs(rotation.norm() - 1) < 1e-2)) {
    section.Keep(node.Refuse("a unit quaternion, got another"));
  }
  tag->world_from_tag = MakePose(rotation.normalized(), position);
  return section.FirstFault();
}

// Limelight's field: sizes in mm, world from face as WPILib has it, row by row.
Status ReadFiducial(const YamlValue& node, std::string* family, Tag* tag) {
  YamlSection section(node);
  std::vector<double> n;
  double size_mm = 0;
  section.Require("id", &tag->id);
  section.Require("size", &size_mm);
  section("family", *family);
  const YamlValue* transform = section.Require(std::string("transform"));
  if (transform != nullptr) section.Keep(ReadNumbers(*transform, 16, &n));
  if (Status status = section.FirstFault(); !status) return status;
  Eigen::Matrix3d world_from_face;
  world_from_face << n[0], n[1], n[2], n[4], n[5], n[6], n[8], n[9], n[10];
  const double off =
      (world_from_face.transpose() * world_from_face - Eigen::Matrix3d::Identity()).norm();
  if (!(off < 1e-2) || !(world_from_face.determinant() > 0)) {
    return transform->Refuse("a rigid 4 x 4 matrix, got another");
  }
  tag->size_m = 1e-3 * size_mm;
  tag->world_from_tag =
      FromFace(Eigen::Quaterniond(world_from_face).normalized(), {n[3], n[7], n[11]});
  return Ok();
}

// "apriltag3_36h11_classic" -> "tag36h11"
std::string LimelightFamily(const std::string& name) {
  for (const std::string& family : TagFamilyNames()) {
    if (name.find(family.substr(3)) != std::string::npos) return family;
  }
  return "tag36h11";
}

Error NeedsSize(const std::string& path) {
  return Error{path +
               ": the size of the tags is not in such a file: expected --tag_size_m or tag_size_m"};
}

}  // namespace

Result<TagMap> ReadWpilib(const YamlValue& root, std::optional<double> tag_size_m,
                          const std::string& family) {
  if (!tag_size_m) return NeedsSize(root.file);
  YamlSection section(root);
  const YamlValue* list = section.Require(std::string("tags"));
  std::vector<Tag> tags;
  for (const YamlValue& item : list->items) {
    Tag tag;
    if (Status status = ReadWpilibTag(item, *tag_size_m, &tag); !status) return status.error();
    tags.push_back(tag);
  }
  return TagMap(family.empty() ? "tag36h11" : family, std::move(tags));
}

bool IsFieldCsv(const std::string& text) {
  return text.substr(0, 200).find("ID,X,Y,Z") < 4;  // behind a byte order mark, perhaps
}

Result<TagMap> ReadFieldCsv(std::string text, const std::string& path,
                            std::optional<double> tag_size_m, const std::string& family) {
  constexpr double kInchM = 0.0254, kDegree = M_PI / 180;
  if (!tag_size_m) return NeedsSize(path);
  auto decoded = DecodeText(std::move(text), path);
  if (!decoded) return decoded.error();
  const auto table = CsvTable::Parse(std::move(*decoded), path);
  if (!table) return table.error();
  if (table->columns().size() != 6) {
    return Error{path + ":1: expected ID,X,Y,Z,Z-Rotation,Y-Rotation, got " +
                 std::to_string(table->columns().size()) + " columns"};
  }
  std::vector<Tag> tags;
  for (size_t row = 0; row < table->rows(); ++row) {
    const auto id = table->Integer(row, 0);
    if (!id) return id.error();
    if (*id < 0 || *id > 100000) return table->ErrorAt(row, "ID: expected one of the family's");
    const auto n = table->Numbers(row, {1, 2, 3, 4, 5});
    if (!n) return n.error();
    const Eigen::Quaterniond turn(Eigen::AngleAxisd((*n)[3] * kDegree, Eigen::Vector3d::UnitZ()) *
                                  Eigen::AngleAxisd((*n)[4] * kDegree, Eigen::Vector3d::UnitY()));
    Tag tag;
    tag.id = static_cast<int>(*id);
    tag.size_m = *tag_size_m;
    tag.world_from_tag = FromFace(turn, kInchM * Eigen::Vector3d((*n)[0], (*n)[1], (*n)[2]));
    tags.push_back(tag);
  }
  return TagMap(family.empty() ? "tag36h11" : family, std::move(tags));
}

Result<TagMap> ReadBundle(const YamlValue& bundles, const std::string& family) {
  if (bundles.kind != YamlValue::Kind::kList || bundles.items.size() != 1) {
    return bundles.Refuse("one bundle: where several lie to each other the file does not tell");
  }
  YamlSection section(bundles.items[0]);
  const YamlValue* layout = section.Require(std::string("layout"));
  if (layout == nullptr) return section.FirstFault().error();
  std::vector<Tag> tags;
  for (const YamlValue& item : layout->items) {
    Tag tag;
    if (Status status = ReadBundleTag(item, &tag); !status) return status.error();
    tags.push_back(tag);
  }
  return TagMap(family.empty() ? "tag36h11" : family, std::move(tags));
}

Result<TagMap> ReadLimelight(const YamlValue& fiducials, const std::string& family) {
  std::vector<Tag> tags;
  std::string named;
  for (const YamlValue& item : fiducials.items) {
    Tag tag;
    if (Status status = ReadFiducial(item, &named, &tag); !status) return status.error();
    tags.push_back(tag);
  }
  return TagMap(family.empty() ? LimelightFamily(named) : family, std::move(tags));
}

}  // namespace tagtwist::internal

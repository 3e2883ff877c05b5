#include "frontend/io/setup/field_maps.h"

#include <Eigen/LU>
#include <cmath>
#include <utility>
#include <vector>

#include "frontend/types/tag_family.h"

namespace tagtwist::internal {
namespace {

// The members x, y, z of a mapping.
Eigen::Vector3d ReadTranslation(const YamlValue* node, YamlSection* parent) {
  Eigen::Vector3d out = Eigen::Vector3d::Zero();
  if (node == nullptr) return out;
  YamlSection section(*node);
  section.Require("x", &out.x());
  section.Require("y", &out.y());
  section.Require("z", &out.z());
  parent->Keep(section.FirstFault());
  return out;
}

// WPILib: x out of the tag's face, y to the right as printed, z up.
Status ReadWpilibTag(const YamlValue& node, double size_m, Tag* tag) {
  YamlSection section(node);
  tag->size_m = size_m;
  section.Require("ID", &tag->id);
  const YamlValue* pose = section.Require(std::string("pose"));
  if (pose == nullptr) return section.FirstFault();
  YamlSection parts(*pose);
  const Eigen::Vector3d position =
      ReadTranslation(parts.Require(std::string("translation")), &parts);
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
  Eigen::Matrix3d face_from_tag;
  face_from_tag << 0, 0, 1, 1, 0, 0, 0, 1, 0;
  tag->world_from_tag =
      MakePose(world_from_face.normalized() * Eigen::Quaterniond(face_from_tag), position);
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
  Eigen::Matrix3d world_from_face, face_from_tag;
  world_from_face << n[0], n[1], n[2], n[4], n[5], n[6], n[8], n[9], n[10];
  face_from_tag << 0, 0, 1, 1, 0, 0, 0, 1, 0;
  const double off =
      (world_from_face.transpose() * world_from_face - Eigen::Matrix3d::Identity()).norm();
  if (!(off < 1e-2) || !(world_from_face.determinant() > 0)) {
    return transform->Refuse("a rigid 4 x 4 matrix, got another");
  }
  tag->size_m = 1e-3 * size_mm;
  tag->world_from_tag =
      MakePose(Eigen::Quaterniond(Eigen::Matrix3d(world_from_face * face_from_tag)).normalized(),
               {n[3], n[7], n[11]});
  return Ok();
}

// "apriltag3_36h11_classic" -> "tag36h11"
std::string LimelightFamily(const std::string& name) {
  for (const std::string& family : TagFamilyNames()) {
    if (name.find(family.substr(3)) != std::string::npos) return family;
  }
  return "tag36h11";
}

}  // namespace

Result<TagMap> ReadWpilib(const YamlValue& root, std::optional<double> tag_size_m,
                          const std::string& family) {
  if (!tag_size_m) {
    return Error{root.file +
                 ": the size of the tags is not in such a file: expected --tag_size_m "
                 "or tag_size_m"};
  }
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

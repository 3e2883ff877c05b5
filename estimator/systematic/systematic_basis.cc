#include "estimator/systematic/systematic_basis.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "estimator/systematic/given_errors.h"
#include "estimator/systematic/map_field.h"
#include "frontend/base/statistics/robust.h"
#include "frontend/base/take_shape.h"
#include "frontend/types/so3.h"
#include "residuals/corner_whitener.h"
#include "residuals/tag_reprojection_residual.h"

namespace tagtwist::internal {
namespace {

using Corners = Eigen::Matrix<double, 2, 4>;

// From the tag's centre to each corner, of unit length.
Eigen::Matrix<double, 8, 1> Outwards(const Corners& corners) {
  const Corners arms = corners.colwise() - corners.rowwise().mean();
  return arms.colwise().normalized().reshaped();
}

constexpr size_t kMostTags = 128;

}  // namespace

std::vector<int> TagsSeenMost(const std::vector<GraphFrame>& frames) {
  std::map<int, int> views;
  for (const GraphFrame& frame : frames) {
    for (const TagDetection& tag : frame.tags) ++views[tag.id];
  }
  std::vector<int> ids;
  for (const auto& [id, count] : views) ids.push_back(id);
  std::stable_sort(ids.begin(), ids.end(), [&](int a, int b) { return views[a] > views[b]; });
  if (ids.size() > kMostTags) ids.resize(kMostTags);
  std::sort(ids.begin(), ids.end());
  return ids;
}

SystematicBasis::SystematicBasis(const EstimatorSetup& setup, const std::vector<int>& tags,
                                 bool mounts_are_right)
    : setup_(setup), cameras_(setup), mounts_are_right_(mounts_are_right), ids_(tags) {
  for (const Camera& camera : setup.Cameras()) fields_.emplace_back(camera.width, camera.height);
  for (int i = 0; i < setup.n_cameras(); ++i) {
    given_.push_back(RootOfGiven(setup_.CameraOf(i), setup.options));
  }
  for (const int id : tags) tags_.emplace(id, static_cast<int>(tags_.size()));
}

int SystematicBasis::field_size() const {
  int out = 0;
  for (const ImageField& field : fields_) out += 2 * field.knots();
  return out;
}

int SystematicBasis::field_modes() const {
  int out = 0;
  for (const ImageField& field : fields_) out += 2 * static_cast<int>(field.modes().cols());
  return out;
}

int SystematicBasis::tag_size() const { return kTagParameters * static_cast<int>(tags_.size()); }

int SystematicBasis::tag_modes() const { return 3 * static_cast<int>(tags_.size()); }

int SystematicBasis::mount_size() const { return 3 * (static_cast<int>(fields_.size()) - 1); }

int SystematicBasis::given_size() const {
  Eigen::Index out = 0;
  for (const Eigen::MatrixXd& root : given_) out += root.cols();
  return static_cast<int>(out);
}

int SystematicBasis::size() const {
  return field_size() + tag_size() + 2 * mount_size() + 1 + given_size();
}

bool SystematicBasis::CameraIsGiven() const {
  return std::any_of(given_.begin(), given_.end(),
                     [](const Eigen::MatrixXd& root) { return !root.isZero(0); });
}

bool SystematicBasis::AnyIsGiven() const {
  const EstimatorOptions& o = setup_.options;
  return o.lens_field_sigma_px || o.tag_sigma_m || o.corner_bias_sigma_px || CameraIsGiven();
}

// A mount turned and moved in the body is as if the body were turned and moved the other way; one
// in W as if the body were turned and moved likewise there, where a turn about W's origin moves it.
Eigen::Matrix<double, 8, 6> SystematicBasis::ByMount(
    const Pose& world_from_body, const Eigen::Matrix<double, 8, 6>& by_pose) const {
  const Eigen::Matrix3d rotation = world_from_body.rotation().toRotationMatrix();
  Eigen::Matrix<double, 8, 6> out;
  if (setup_.mounted_on == MountedOn::kBody) {
    out << -by_pose.leftCols<3>(), -by_pose.rightCols<3>() * rotation;
  } else {
    out << by_pose.leftCols<3>() * rotation.transpose() -
               by_pose.rightCols<3>() * Hat(world_from_body.translation()),
        by_pose.rightCols<3>();
  }
  return out;
}

void SystematicBasis::AddTag(int id, const Pose& world_from_body,
                             const Eigen::Matrix<double, 8, 6>& by_pose, Columns* columns) const {
  const auto first = FirstOfTag(id);
  if (!first) return;
  // A tag further along in W is seen as if the body stood as much further back; a tag of the
  // body's further along in B as if all of it had gone there.
  Eigen::Matrix<double, 8, 3> by_place = -by_pose.rightCols<3>();
  if (setup_.mounted_on == MountedOn::kWorld) {
    by_place *= -world_from_body.rotation().toRotationMatrix();
  }
  const Eigen::Matrix<double, 12, 2> by_slopes = CornersBySlopes(*setup_.map.Find(id));
  for (int a = 0; a < 3; ++a) (*columns)[*first + a] = by_place.col(a);
  for (int a = 0; a < 2; ++a) {
    Eigen::Matrix<double, 8, 1>& column = (*columns)[*first + 3 + a];
    for (int c = 0; c < 4; ++c) {
      column.segment<2>(2 * c) = by_place.middleRows<2>(2 * c) * by_slopes.block<3, 1>(3 * c, a);
    }
  }
}

void SystematicBasis::AddMount(int camera, const Eigen::Matrix<double, 8, 6>& by_mount,
                               Columns* columns) const {
  if (camera == 0) return;  // it says where the body is
  const int first = field_size() + tag_size() + 3 * (camera - 1);
  for (int a = 0; a < 3; ++a) {
    (*columns)[first + a] = by_mount.col(a);
    (*columns)[first + mount_size() + a] = by_mount.col(3 + a);
  }
}

void SystematicBasis::AddGiven(const Pose& world_from_body, const TagDetection& tag,
                               const Eigen::Matrix<double, 8, 6>& by_mount,
                               Columns* columns) const {
  const Eigen::MatrixXd& root = given_[static_cast<size_t>(tag.camera)];
  if (root.isZero(0)) return;
  const Eigen::MatrixXd by_columns =
      CornersByEntries(setup_, world_from_body, tag, by_mount) * root;
  int first = size() - given_size();
  for (int i = 0; i < tag.camera; ++i) {
    first += static_cast<int>(given_[static_cast<size_t>(i)].cols());
  }
  for (int k = 0; k < by_columns.cols(); ++k) (*columns)[first + k] = by_columns.col(k);
}

std::vector<int> SystematicBasis::OfMount(int camera) const {
  const int first = field_size() + tag_size() + 3 * (camera - 1);
  const int shift = first + mount_size();
  return {first, first + 1, first + 2, shift, shift + 1, shift + 2};
}

bool SystematicBasis::Linearize(const NoiseModel& noise, const Pose& world_from_body,
                                const TagDetection& tag, TagTerms* out) const {
  const TagReprojection in_px(
      {setup_.map.CornersInWorld(tag.id), tag.corners, Eigen::Matrix<double, 8, 8>::Identity()},
      cameras_.Of(tag.camera));
  if (!in_px.Linearize(world_from_body.params.data(), &out->residual, &out->by_pose)) return false;
  // Where the corners should be: at the places where they were seen the noise of a residual would
  // be in its own derivative, and a field that poses make up for would seem to explain it.
  Corners corners;
  for (int c = 0; c < 4; ++c) {
    corners.col(c) = tag.corners[static_cast<size_t>(c)] + out->residual.segment<2>(2 * c);
  }
  Columns columns;
  const auto add = [&](int column, int row, double value) {
    columns.try_emplace(column, Eigen::Matrix<double, 8, 1>::Zero()).first->second(row) += value;
  };
  const FieldBlock u = FieldBlocks()[2 * static_cast<size_t>(tag.camera)];
  for (int c = 0; c < 4; ++c) {
    const ImageField::Place place = u.field->At(corners.col(c));
    for (size_t k = 0; k < place.knots.size(); ++k) {
      const int knot = static_cast<int>(u.knot) + place.knots[k];
      add(knot, 2 * c, place.shares[k]);
      add(knot + u.field->knots(), 2 * c + 1, place.shares[k]);
    }
  }
  AddTag(tag.id, world_from_body, out->by_pose, &columns);
  const Eigen::Matrix<double, 8, 6> by_mount = ByMount(world_from_body, out->by_pose);
  AddMount(tag.camera, by_mount, &columns);
  columns[size() - given_size() - 1] = Outwards(corners);
  AddGiven(world_from_body, tag, by_mount, &columns);
  const Eigen::Matrix<double, 8, 8> whitener =
      CornerWhitener(CornerCovariance(setup_, tag, noise.corner_sigma_px));
  const double norm = (whitener * out->residual).norm();
  const double root_weight =
      std::sqrt(std::min(1.0, HuberDelta(setup_.options.robust_scale, 8) / norm));
  const Eigen::Matrix<double, 8, 8> scale = root_weight * whitener;
  out->residual = scale * out->residual;
  out->by_pose = scale * out->by_pose;
  out->columns.clear();
  TakeShape(8, static_cast<Eigen::Index>(columns.size()), &out->by_parameters);
  for (const auto& [column, effect] : columns) {
    out->by_parameters.col(static_cast<Eigen::Index>(out->columns.size())) = scale * effect;
    out->columns.push_back(column);
  }
  return true;
}

}  // namespace tagtwist::internal

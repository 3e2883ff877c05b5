#include "estimator/systematic/systematic_basis.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "estimator/systematic/given_errors.h"
#include "frontend/base/statistics/robust.h"
#include "frontend/base/take_shape.h"
#include "frontend/types/so3.h"
#include "residuals/corner_whitener.h"
#include "residuals/tag_reprojection_residual.h"

namespace tagtwist::internal {
namespace {

// Where a search for the variances starts: a lens, a map and corners as they often are.
constexpr double kFieldPx = 0.1, kTagM = 1e-3, kBiasPx = 0.2, kMountRad = 1e-3, kMountM = 1e-3;

using Corners = Eigen::Matrix<double, 2, 4>;

// From the tag's centre to each corner, of unit length.
Eigen::Matrix<double, 8, 1> Outwards(const Corners& corners) {
  const Corners arms = corners.colwise() - corners.rowwise().mean();
  return arms.colwise().normalized().reshaped();
}

constexpr size_t kMostTags = 128;
constexpr int kTagParameters = 3;

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

SystematicBasis::SystematicBasis(const EstimatorSetup& setup, const std::vector<int>& tags)
    : setup_(setup) {
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

std::vector<ParameterGroup> SystematicBasis::Groups() const {
  const int field = field_modes(), tags = tag_size(), mounts = mount_size();
  const auto group = [](int first, int size, const std::optional<double>& given, double start) {
    return ParameterGroup{first, size, given.value_or(start), given.has_value()};
  };
  const EstimatorOptions& o = setup_.options;
  const int after = field + tags + 2 * mounts;
  std::vector<ParameterGroup> out = {group(0, field, o.lens_field_sigma_px, kFieldPx),
                                     group(field, tags, o.tag_sigma_m, kTagM),
                                     group(after, 1, o.corner_bias_sigma_px, kBiasPx),
                                     {after + 1, given_size(), CameraIsGiven() ? 1.0 : 0.0, true}};
  out[1].is_given = false;  // residuals may show more, never less, than what is given of the tags
  out[1].least = o.tag_sigma_m.value_or(0);
  if (mounts == 0) return out;
  out.push_back(group(field + tags, mounts, std::nullopt, kMountRad));
  out.push_back(group(field + tags + mounts, mounts, std::nullopt, kMountM));
  return out;
}

// The u of a field's knots, and then their v; likewise its modes, and one camera's after another's.
std::vector<SystematicBasis::FieldBlock> SystematicBasis::FieldBlocks() const {
  std::vector<FieldBlock> out;
  Eigen::Index knots = 0, modes = 0;
  for (const ImageField& field : fields_) {
    for (int axis = 0; axis < 2; ++axis) {
      out.push_back({knots, modes, &field});
      knots += field.knots();
      modes += field.modes().cols();
    }
  }
  return out;
}

Eigen::MatrixXd SystematicBasis::TimesGivenSigmas(const Eigen::MatrixXd& effects) const {
  const EstimatorOptions& o = setup_.options;
  const Eigen::Index knots = field_size(), modes = field_modes(), tags = tag_size();
  const Eigen::Index others = effects.cols() - knots;
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(effects.rows(), modes + others);
  const double field_px = o.lens_field_sigma_px.value_or(0);
  for (const FieldBlock& block : FieldBlocks()) {
    out.middleCols(block.mode, block.field->modes().cols()) =
        field_px * effects.middleCols(block.knot, block.field->knots()) * block.field->modes();
  }
  out.middleCols(modes, tags) = o.tag_sigma_m.value_or(0) * effects.middleCols(knots, tags);
  const Eigen::Index bias = tags + 2 * mount_size(), given = given_size();
  out.col(modes + bias) = o.corner_bias_sigma_px.value_or(0) * effects.col(knots + bias);
  out.rightCols(given) = effects.rightCols(given);
  return out;
}

Eigen::MatrixXd SystematicBasis::FromModes(const Eigen::MatrixXd& of_modes) const {
  const Eigen::Index others = of_modes.rows() - field_modes();
  Eigen::MatrixXd out(field_size() + others, of_modes.cols());
  for (const FieldBlock& block : FieldBlocks()) {
    out.middleRows(block.knot, block.field->knots()) =
        block.field->modes() * of_modes.middleRows(block.mode, block.field->modes().cols());
  }
  out.bottomRows(others) = of_modes.bottomRows(others);
  return out;
}

Eigen::MatrixXd SystematicBasis::ToModes(const Eigen::MatrixXd& of_knots) const {
  const auto transposed = [&](const Eigen::MatrixXd& rows) {
    const Eigen::Index others = rows.rows() - field_size();
    Eigen::MatrixXd out(field_modes() + others, rows.cols());
    for (const FieldBlock& block : FieldBlocks()) {
      out.middleRows(block.mode, block.field->modes().cols()) =
          block.field->modes().transpose() * rows.middleRows(block.knot, block.field->knots());
    }
    out.bottomRows(others) = rows.bottomRows(others);
    return out;
  };
  return transposed(transposed(of_knots).transpose());
}

LinearEvidence SystematicBasis::ToModes(const LinearEvidence& of_knots) const {
  LinearEvidence out = of_knots;
  const Eigen::Index others = of_knots.gradient.size() - field_size();
  out.gradient.resize(field_modes() + others);
  for (const FieldBlock& block : FieldBlocks()) {
    out.gradient.segment(block.mode, block.field->modes().cols()) =
        block.field->modes().transpose() *
        of_knots.gradient.segment(block.knot, block.field->knots());
  }
  out.gradient.tail(others) = of_knots.gradient.tail(others);
  out.information = ToModes(of_knots.information);
  return out;
}

std::optional<int> SystematicBasis::FirstOfTag(int id) const {
  const auto at = tags_.find(id);
  if (at == tags_.end()) return std::nullopt;
  return field_size() + kTagParameters * at->second;
}

Eigen::MatrixXd SystematicBasis::RowsOf(const SystematicBasis& other,
                                        const Eigen::MatrixXd& rows) const {
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(size(), rows.cols());
  out.topRows(field_size()) = rows.topRows(field_size());
  for (const auto& [id, place] : other.tags_) {
    out.middleRows<kTagParameters>(*FirstOfTag(id)) =
        rows.middleRows<kTagParameters>(other.field_size() + kTagParameters * place);
  }
  const int after = size() - field_size() - tag_size();
  out.bottomRows(after) = rows.bottomRows(after);
  return out;
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

bool SystematicBasis::Linearize(const NoiseModel& noise, const Pose& world_from_body,
                                const TagDetection& tag, TagTerms* out) const {
  const MountedCamera seen_by = setup_.CameraOf(tag.camera);
  const TagReprojectionResidual in_px(
      {setup_.map.CornersInWorld(tag.id), tag.corners, Eigen::Matrix<double, 8, 8>::Identity()},
      seen_by.camera, seen_by.cam_from_body, seen_by.mounted_on);
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
  if (const auto first = FirstOfTag(tag.id)) {
    // A tag further along in W is seen as if the body stood as much further back; a tag of the
    // body's further along in B as if all of it had gone there.
    Eigen::Matrix<double, 8, 3> by_place = -out->by_pose.rightCols<3>();
    if (seen_by.mounted_on == MountedOn::kWorld) {
      by_place *= -world_from_body.rotation().toRotationMatrix();
    }
    for (int a = 0; a < kTagParameters; ++a) {
      columns[*first + a] = by_place.col(a);
    }
  }
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

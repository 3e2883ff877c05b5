#include "estimator/systematic/systematic_basis.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "frontend/base/statistics/robust.h"
#include "residuals/corner_whitener.h"
#include "residuals/tag_reprojection_residual.h"

namespace tagtwist::internal {
namespace {

// Where a search for the variances starts: a lens, a map and corners as they often are.
constexpr double kFieldPx = 0.1, kTagM = 1e-3, kBiasPx = 0.2;

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
    : setup_(setup), field_(setup.camera.width, setup.camera.height) {
  for (const int id : tags) tags_.emplace(id, static_cast<int>(tags_.size()));
}

int SystematicBasis::size() const {
  return 2 * field_.knots() + kTagParameters * static_cast<int>(tags_.size()) + 2;
}

std::vector<ParameterGroup> SystematicBasis::Groups() const {
  const auto field = static_cast<int>(2 * field_.modes().cols());
  const auto tags = kTagParameters * static_cast<int>(tags_.size());
  const auto group = [](int first, int size, const std::optional<double>& given, double start) {
    return ParameterGroup{first, size, given.value_or(start), given.has_value()};
  };
  const EstimatorOptions& o = setup_.options;
  return {group(0, field, o.lens_field_sigma_px, kFieldPx),
          group(field, tags, o.tag_sigma_m, kTagM),
          group(field + tags, 1, o.corner_bias_sigma_px, kBiasPx),
          {field + tags + 1, 1, o.focal_sigma.value_or(0), true}};
}

Eigen::MatrixXd SystematicBasis::TimesGivenSigmas(const Eigen::MatrixXd& effects) const {
  const EstimatorOptions& o = setup_.options;
  const Eigen::Index knots = field_.knots(), modes = field_.modes().cols();
  const Eigen::Index tags = effects.cols() - 2 * knots - 2;
  Eigen::MatrixXd out(effects.rows(), 2 * modes + tags + 2);
  const double field_px = o.lens_field_sigma_px.value_or(0);
  out.leftCols(modes) = field_px * effects.leftCols(knots) * field_.modes();
  out.middleCols(modes, modes) = field_px * effects.middleCols(knots, knots) * field_.modes();
  out.middleCols(2 * modes, tags) = o.tag_sigma_m.value_or(0) * effects.middleCols(2 * knots, tags);
  out.col(2 * modes + tags) = o.corner_bias_sigma_px.value_or(0) * effects.col(2 * knots + tags);
  out.rightCols(1) = o.focal_sigma.value_or(0) * effects.rightCols(1);
  return out;
}

// The knots' u and v lie side by side, and so do the modes'.
Eigen::MatrixXd SystematicBasis::FromModes(const Eigen::MatrixXd& of_modes) const {
  const Eigen::Index knots = field_.knots(), modes = field_.modes().cols();
  const Eigen::Index others = of_modes.rows() - 2 * modes;
  Eigen::MatrixXd out(2 * knots + others, of_modes.cols());
  out.topRows(knots) = field_.modes() * of_modes.topRows(modes);
  out.middleRows(knots, knots) = field_.modes() * of_modes.middleRows(modes, modes);
  out.bottomRows(others) = of_modes.bottomRows(others);
  return out;
}

Eigen::MatrixXd SystematicBasis::ToModes(const Eigen::MatrixXd& of_knots) const {
  const Eigen::Index knots = field_.knots(), modes = field_.modes().cols();
  const auto transposed = [&](const Eigen::MatrixXd& rows) {
    const Eigen::Index others = rows.rows() - 2 * knots;
    Eigen::MatrixXd out(2 * modes + others, rows.cols());
    out.topRows(modes) = field_.modes().transpose() * rows.topRows(knots);
    out.middleRows(modes, modes) = field_.modes().transpose() * rows.middleRows(knots, knots);
    out.bottomRows(others) = rows.bottomRows(others);
    return out;
  };
  return transposed(transposed(of_knots).transpose());
}

LinearEvidence SystematicBasis::ToModes(const LinearEvidence& of_knots) const {
  LinearEvidence out = of_knots;
  const Eigen::Index knots = field_.knots(), modes = field_.modes().cols();
  const Eigen::Index others = of_knots.gradient.size() - 2 * knots;
  out.gradient.resize(2 * modes + others);
  out.gradient << field_.modes().transpose() * of_knots.gradient.head(knots),
      field_.modes().transpose() * of_knots.gradient.segment(knots, knots),
      of_knots.gradient.tail(others);
  out.information = ToModes(of_knots.information);
  return out;
}

bool SystematicBasis::Linearize(const NoiseModel& noise, const Pose& world_from_body,
                                const TagDetection& tag, TagTerms* out) const {
  const TagReprojectionResidual in_px(
      {setup_.map.CornersInWorld(tag.id), tag.corners, Eigen::Matrix<double, 8, 8>::Identity()},
      setup_.camera, setup_.cam_from_body);
  if (!in_px.Linearize(world_from_body.params.data(), &out->residual, &out->by_pose)) return false;
  // Where the corners should be: at the places where they were seen the noise of a residual would
  // be in its own derivative, and a field that poses make up for would seem to explain it.
  Corners corners;
  for (int c = 0; c < 4; ++c) {
    corners.col(c) = tag.corners[static_cast<size_t>(c)] + out->residual.segment<2>(2 * c);
  }
  const int knots = field_.knots();
  std::map<int, Eigen::Matrix<double, 8, 1>> columns;
  const auto add = [&](int column, int row, double value) {
    columns.try_emplace(column, Eigen::Matrix<double, 8, 1>::Zero()).first->second(row) += value;
  };
  for (int c = 0; c < 4; ++c) {
    const ImageField::Place place = field_.At(corners.col(c));
    for (size_t k = 0; k < place.knots.size(); ++k) {
      add(place.knots[k], 2 * c, place.shares[k]);
      add(knots + place.knots[k], 2 * c + 1, place.shares[k]);
    }
  }
  if (const auto at = tags_.find(tag.id); at != tags_.end()) {
    // A tag further along in W is seen as if the body stood as much further back.
    for (int a = 0; a < kTagParameters; ++a) {
      columns[2 * knots + kTagParameters * at->second + a] = -out->by_pose.col(3 + a);
    }
  }
  columns[size() - 2] = Outwards(corners);
  columns[size() - 1] =
      (corners.colwise() - Eigen::Vector2d(setup_.camera.cx, setup_.camera.cy)).reshaped();
  const Eigen::Matrix<double, 8, 8> whitener =
      CornerWhitener(CornerCovariance(setup_, tag, noise.corner_sigma_px));
  const double norm = (whitener * out->residual).norm();
  const double root_weight =
      std::sqrt(std::min(1.0, HuberDelta(setup_.options.robust_scale, 8) / norm));
  const Eigen::Matrix<double, 8, 8> scale = root_weight * whitener;
  out->residual = scale * out->residual;
  out->by_pose = scale * out->by_pose;
  out->columns.clear();
  out->by_parameters.resize(8, static_cast<Eigen::Index>(columns.size()));
  for (const auto& [column, effect] : columns) {
    out->by_parameters.col(static_cast<Eigen::Index>(out->columns.size())) = scale * effect;
    out->columns.push_back(column);
  }
  return true;
}

}  // namespace tagtwist::internal

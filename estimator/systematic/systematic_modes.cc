// The parameters of a SystematicBasis by modes that have one prior each.
#include <algorithm>

#include "estimator/systematic/systematic_basis.h"

namespace tagtwist::internal {
namespace {

// Where a search for the variances starts: a lens, a map and corners as they often are.
constexpr double kFieldPx = 0.1, kTagM = 1e-3, kBiasPx = 0.2, kMountRad = 1e-3, kMountM = 1e-3;

}  // namespace

const Tag& SystematicBasis::TagAt(int place) const {
  return *setup_.map.Find(ids_[static_cast<size_t>(place)]);
}

int SystematicBasis::modes() const {
  return field_modes() + tag_modes() + 2 * mount_size() + 1 + given_size();
}

std::vector<ParameterGroup> SystematicBasis::Groups() const {
  const int field = field_modes(), tags = tag_modes(), mounts = mount_size();
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
  const std::optional<double> given = mounts_are_right_ ? std::optional(0.0) : std::nullopt;
  out.push_back(group(field + tags, mounts, given, kMountRad));
  out.push_back(group(field + tags + mounts, mounts, given, kMountM));
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
  const double tag_m = o.tag_sigma_m.value_or(0);
  Eigen::MatrixXd out = ToModes(Eigen::MatrixXd(effects.transpose()), nullptr).transpose();
  out.leftCols(field_modes()) *= o.lens_field_sigma_px.value_or(0);
  out.middleCols(field_modes(), tag_modes()) *= tag_m;
  const Eigen::Index bias = field_modes() + tag_modes() + 2 * mount_size();
  out.middleCols(bias - 2 * mount_size(), 2 * mount_size()).setZero();
  out.col(bias) *= o.corner_bias_sigma_px.value_or(0);
  return out;
}

Eigen::MatrixXd SystematicBasis::FromModes(const Eigen::MatrixXd& of_modes,
                                           const MapField* map) const {
  Eigen::MatrixXd out(size(), of_modes.cols());
  for (const FieldBlock& block : FieldBlocks()) {
    out.middleRows(block.knot, block.field->knots()) =
        block.field->modes() * of_modes.middleRows(block.mode, block.field->modes().cols());
  }
  for (int place = 0; place < static_cast<int>(ids_.size()); ++place) {
    auto rows = out.middleRows(field_size() + kTagParameters * place, kTagParameters);
    rows.topRows(3) = of_modes.middleRows(field_modes() + 3 * place, 3);
    rows.bottomRows(2).setZero();
    if (map == nullptr) continue;
    rows += map->OfTag(TagAt(place)) * of_modes.bottomRows(map->modes());
  }
  const int others = size() - field_size() - tag_size();
  out.bottomRows(others) = of_modes.middleRows(field_modes() + tag_modes(), others);
  return out;
}

Eigen::MatrixXd SystematicBasis::ToModes(const Eigen::MatrixXd& rows, const MapField* map) const {
  Eigen::MatrixXd out(modes() + (map == nullptr ? 0 : map->modes()), rows.cols());
  for (const FieldBlock& block : FieldBlocks()) {
    out.middleRows(block.mode, block.field->modes().cols()) =
        block.field->modes().transpose() * rows.middleRows(block.knot, block.field->knots());
  }
  if (map != nullptr) out.bottomRows(map->modes()).setZero();
  for (int place = 0; place < static_cast<int>(ids_.size()); ++place) {
    const auto of_tag = rows.middleRows(field_size() + kTagParameters * place, kTagParameters);
    out.middleRows(field_modes() + 3 * place, 3) = of_tag.topRows(3);
    if (map == nullptr) continue;
    out.bottomRows(map->modes()) += map->OfTag(TagAt(place)).transpose() * of_tag;
  }
  const int others = size() - field_size() - tag_size();
  out.middleRows(field_modes() + tag_modes(), others) = rows.bottomRows(others);
  return out;
}

LinearEvidence SystematicBasis::ToModes(const LinearEvidence& of_knots, const MapField* map) const {
  LinearEvidence out = of_knots;
  out.gradient = ToModes(Eigen::MatrixXd(of_knots.gradient), map);
  out.information = BothToModes(of_knots.information, map);
  return out;
}

Eigen::MatrixXd SystematicBasis::BothToModes(const Eigen::MatrixXd& of_knots,
                                             const MapField* map) const {
  return ToModes(Eigen::MatrixXd(ToModes(of_knots, map).transpose()), map);
}

std::vector<Eigen::Vector3d> SystematicBasis::TagPlaces() const {
  std::vector<Eigen::Vector3d> out;
  for (size_t i = 0; i < ids_.size(); ++i) {
    out.push_back(TagAt(static_cast<int>(i)).world_from_tag.translation());
  }
  return out;
}

std::optional<int> SystematicBasis::FirstOfTag(int id) const {
  const auto at = tags_.find(id);
  if (at == tags_.end()) return std::nullopt;
  return field_size() + kTagParameters * at->second;
}

Eigen::MatrixXd SystematicBasis::RowsOf(const SystematicBasis& other, const Eigen::MatrixXd& rows,
                                        const MapField* map, const Eigen::MatrixXd& of_map) const {
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(size(), rows.cols());
  out.topRows(field_size()) = rows.topRows(field_size());
  for (const int id : ids_) {
    auto of_tag = out.middleRows<kTagParameters>(*FirstOfTag(id));
    if (const auto there = other.FirstOfTag(id)) {
      of_tag = rows.middleRows<kTagParameters>(*there);
    } else if (map != nullptr) {
      of_tag = map->OfTag(*setup_.map.Find(id)) * of_map;
    }
  }
  const int after = size() - field_size() - tag_size();
  out.bottomRows(after) = rows.bottomRows(after);
  return out;
}

}  // namespace tagtwist::internal

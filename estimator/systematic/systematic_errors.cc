#include "estimator/systematic/systematic_errors.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace tagtwist::internal {
namespace {

constexpr size_t kMostFrames = 500;
// Share of the errors' effect on the states that may be neglected; where errors are given, which
// may be many times the noise, of a frame's own noise where that is less.
constexpr double kNeglected = 0.002;
// Of errors that neighbouring tags share: over which length, of the tags' extent, where the search
// for their size starts, and how many tags say anything of them.
constexpr double kMapLength = 1, kMapM = 1e-3;
constexpr size_t kLeastTags = 6;
// Of a pose's information, each direction in its own unit: below it the frame's tags leave it open.
constexpr double kLeastPivot = 1e-9;

using TagTerms = SystematicBasis::TagTerms;

// What all frames' tags say of the parameters: with each pose eliminated, and if poses were known.
struct Sums {
  LinearEvidence eliminated;
  Eigen::MatrixXd known_poses;  // F'F, lower triangle
  int frames = 0;
};

// nullopt where a corner cannot be predicted.
std::optional<std::vector<TagTerms>> LinearizeTags(const SystematicBasis& basis,
                                                   const NoiseModel& noise,
                                                   const GraphFrame& frame) {
  std::vector<TagTerms> out(frame.tags.size());
  for (size_t i = 0; i < out.size(); ++i) {
    if (!basis.Linearize(noise, frame.state.world_from_body, frame.tags[i], &out[i])) {
      return std::nullopt;
    }
  }
  return out;
}

// All of a frame's, ascending.
std::vector<int> ColumnsOf(const std::vector<TagTerms>& tags) {
  std::vector<int> out;
  for (const TagTerms& tag : tags) out.insert(out.end(), tag.columns.begin(), tag.columns.end());
  std::sort(out.begin(), out.end());
  out.erase(std::unique(out.begin(), out.end()), out.end());
  return out;
}

// Takes out of the sums what a frame's pose takes of its residuals; false where its tags leave the
// pose open.
bool EliminatePose(const std::vector<TagTerms>& tags, LinearEvidence* out) {
  Eigen::Matrix<double, 6, 6> information = Eigen::Matrix<double, 6, 6>::Zero();
  Eigen::Matrix<double, 6, 1> gradient = Eigen::Matrix<double, 6, 1>::Zero();
  for (const TagTerms& tag : tags) {
    information += tag.by_pose.transpose() * tag.by_pose;
    gradient -= tag.by_pose.transpose() * tag.residual;
  }
  const Eigen::Matrix<double, 6, 1> scale = information.diagonal().cwiseSqrt().cwiseInverse();
  if (!scale.allFinite()) return false;
  const Eigen::LLT<Eigen::Matrix<double, 6, 6>> llt(scale.asDiagonal() * information *
                                                    scale.asDiagonal());
  if (llt.info() != Eigen::Success || llt.rcond() < kLeastPivot) return false;
  const std::vector<int> columns = ColumnsOf(tags);
  Eigen::MatrixXd by = Eigen::MatrixXd::Zero(6, static_cast<Eigen::Index>(columns.size()));
  for (const TagTerms& tag : tags) {
    const Eigen::MatrixXd of_tag = scale.asDiagonal() * tag.by_pose.transpose() * tag.by_parameters;
    for (size_t j = 0; j < tag.columns.size(); ++j) {
      const auto at = std::lower_bound(columns.begin(), columns.end(), tag.columns[j]);
      by.col(at - columns.begin()) += of_tag.col(static_cast<Eigen::Index>(j));
    }
  }
  llt.matrixL().solveInPlace(by);
  const Eigen::VectorXd taken = llt.matrixL().solve(scale.cwiseProduct(gradient));
  const Eigen::MatrixXd square = by.transpose() * by;
  for (size_t j = 0; j < columns.size(); ++j) {
    const auto b = static_cast<Eigen::Index>(j);
    out->gradient(columns[j]) -= by.col(b).dot(taken);
    for (size_t i = j; i < columns.size(); ++i) {
      out->information(columns[i], columns[j]) -= square(static_cast<Eigen::Index>(i), b);
    }
  }
  out->square_sum -= taken.squaredNorm();
  out->dof -= 6;
  return true;
}

void AddTag(const TagTerms& tag, Sums* sums) {
  const Eigen::MatrixXd square = tag.by_parameters.transpose() * tag.by_parameters;
  const Eigen::VectorXd gradient = -tag.by_parameters.transpose() * tag.residual;
  for (size_t j = 0; j < tag.columns.size(); ++j) {
    const auto b = static_cast<Eigen::Index>(j);
    sums->eliminated.gradient(tag.columns[j]) += gradient(b);
    for (size_t i = j; i < tag.columns.size(); ++i) {
      sums->known_poses(tag.columns[i], tag.columns[j]) += square(static_cast<Eigen::Index>(i), b);
    }
  }
  sums->eliminated.square_sum += tag.residual.squaredNorm();
  sums->eliminated.dof += 8;
}

Sums SumUp(const SystematicBasis& basis, const NoiseModel& noise,
           const std::vector<GraphFrame>& frames) {
  const int n = basis.size();
  Sums sums{{Eigen::MatrixXd::Zero(n, n), Eigen::VectorXd::Zero(n), 0, 0},
            Eigen::MatrixXd::Zero(n, n)};
  const size_t count = std::min(frames.size(), kMostFrames);
  for (size_t i = 0; i < count; ++i) {
    const GraphFrame& frame = frames[i * frames.size() / count];
    const auto tags = LinearizeTags(basis, noise, frame);
    if (!tags || !EliminatePose(*tags, &sums.eliminated)) continue;
    for (const TagTerms& tag : *tags) AddTag(tag, &sums);
    ++sums.frames;
  }
  sums.eliminated.information.triangularView<Eigen::Lower>() += sums.known_poses;
  for (Eigen::MatrixXd* m : {&sums.eliminated.information, &sums.known_poses}) {
    *m = Eigen::MatrixXd(m->selfadjointView<Eigen::Lower>());
  }
  return sums;
}

// Columns of which a symmetric matrix, none of whose eigenvalues is below zero, is all but the sum
// of the squares: by pivots, until no more than `rest` is left of its trace (Higham, Cholesky
// factorization, 2009).
Eigen::MatrixXd PivotColumns(const Eigen::MatrixXd& a, double rest) {
  const Eigen::Index n = a.rows();
  Eigen::VectorXd left = a.diagonal().cwiseMax(0);
  Eigen::MatrixXd out(n, n);
  Eigen::Index k = 0;
  for (; k < n && left.sum() > rest; ++k) {
    Eigen::Index pivot = 0;
    const double most = left.maxCoeff(&pivot);
    out.col(k) = a.col(pivot);
    out.col(k).noalias() -= out.leftCols(k) * out.row(pivot).head(k).transpose();
    out.col(k) /= std::sqrt(most);
    left = (left - out.col(k).cwiseAbs2()).cwiseMax(0);
    left(pivot) = 0;
  }
  return out.leftCols(k);
}

// Columns whose squares sum up to the second moment, but for those that hardly move a pose: by no
// more than a share of all of them, or of `noise`, if that is less.
Eigen::MatrixXd RootOf(const EvidenceFit& fit, const Eigen::MatrixXd& taken_by_poses,
                       double noise) {
  Eigen::MatrixXd root(fit.root.rows(), fit.root.cols() + 1);
  root << fit.root, fit.mean;
  const Eigen::MatrixXd effect = root.transpose() * (taken_by_poses * root);
  const double most = kNeglected * std::min(noise, effect.trace());
  // Of what pivots find, a little more than is wanted, the largest directions.
  const Eigen::MatrixXd columns = PivotColumns(effect, most / 4);
  if (columns.cols() == 0) return Eigen::MatrixXd::Zero(root.rows(), 0);
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(columns);
  const Eigen::MatrixXd found =
      qr.householderQ() * Eigen::MatrixXd::Identity(columns.rows(), columns.cols());
  const Eigen::MatrixXd found_effect = found.transpose() * effect * found;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> own(found_effect);
  const Eigen::VectorXd& sizes = own.eigenvalues();  // ascending
  Eigen::Index neglected = 0;
  double sum = std::max(0.0, effect.trace() - sizes.sum());
  while (neglected < sizes.size() && sum + std::max(0.0, sizes(neglected)) <= most) {
    sum += std::max(0.0, sizes(neglected++));
  }
  return root * (found * own.eigenvectors().rightCols(sizes.size() - neglected));
}

struct Found {
  LinearEvidence data;
  EvidenceFit fit;
  std::optional<MapField> map;  // whose modes are the last ones
};

std::optional<MapField> FieldOver(const std::vector<Eigen::Vector3d>& tags) {
  if (tags.size() < kLeastTags) return std::nullopt;
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& tag : tags) box.extend(tag);
  const double extent_m = box.sizes().maxCoeff();
  if (!(extent_m > 0)) return std::nullopt;
  return MapField(tags, kMapLength * extent_m);
}

// The groups with those of a field over the map, from what was found without it.
std::vector<ParameterGroup> GroupsWith(const MapField& map, const SystematicBasis& basis,
                                       const EvidenceFit& without) {
  constexpr double kOwn = 0.3;  // of what tags seem to have for themselves
  std::vector<ParameterGroup> out = basis.Groups();
  for (size_t i = 0; i < out.size(); ++i) {
    const double found = without.groups[i].sigma;
    if (!out[i].is_given && found > 0) out[i].sigma = std::max(out[i].least, found);
  }
  ParameterGroup& tags = out[1];
  const double start_m = std::max(kMapM, tags.sigma);
  tags.sigma = std::max(tags.least, kOwn * tags.sigma);
  out.push_back({basis.modes(), map.bend_modes(), start_m});
  out.push_back({basis.modes() + map.bend_modes(), map.stretch_modes(), start_m});
  for (size_t i = out.size() - 2; i < out.size(); ++i) out[i].comes_back = false;
  return out;
}

// With what neighbouring tags have in common, where anything is found at all, if it is likelier so.
Found FindErrors(const SystematicBasis& basis, const LinearEvidence& of_knots) {
  Found out;
  out.data = basis.ToModes(of_knots, nullptr);
  out.fit = FitByEvidence(out.data, basis.Groups());
  const bool are_right = basis.Groups()[1].sigma == 0;  // the tags, it is said
  if (out.fit.IsEmpty() || are_right) return out;
  std::optional<MapField> map = FieldOver(basis.TagPlaces());
  if (!map) return out;
  LinearEvidence data = basis.ToModes(of_knots, &*map);
  EvidenceFit fit = FitByEvidence(data, GroupsWith(*map, basis, out.fit));
  const size_t n = fit.groups.size();
  const bool is_seen = fit.groups[n - 2].sigma > 0 || fit.groups[n - 1].sigma > 0;
  if (!is_seen || fit.log_evidence <= out.fit.log_evidence) return out;
  out = {std::move(data), std::move(fit), std::move(map)};
  return out;
}

}  // namespace

SystematicErrors LearnSystematicErrors(const SystematicBasis& basis, const NoiseModel& noise,
                                       const std::vector<GraphFrame>& frames) {
  const Sums sums = SumUp(basis, noise, frames);
  SystematicErrors out;
  if (!(sums.eliminated.dof > 0)) return out;
  const Found found = FindErrors(basis, sums.eliminated);
  const EvidenceFit& fit = found.fit;
  const MapField* map = found.map ? &*found.map : nullptr;
  out.noise_scale = fit.noise_scale;
  if (fit.IsEmpty()) return out;
  out.field_sigma_px = fit.groups[0].sigma;
  out.tag_sigma_m = fit.groups[1].sigma;
  out.bias_sigma_px = fit.groups[2].sigma;
  if (map != nullptr) {
    out.map_sigma_m = std::hypot(fit.groups.back().sigma, fit.groups[fit.groups.size() - 2].sigma);
  }
  if (basis.Groups().size() > 4) {  // of a rig
    out.mount_sigma_rad = fit.groups[4].sigma;
    out.mount_sigma_m = fit.groups[5].sigma;
  }
  const Eigen::MatrixXd taken = basis.BothToModes(sums.known_poses, map) - found.data.information;
  const double of_noise = basis.AnyIsGiven() ? 6.0 * sums.frames : HUGE_VAL;
  const Eigen::MatrixXd of_modes = RootOf(fit, taken, of_noise);
  out.root = basis.FromModes(of_modes, map);
  if (map != nullptr) out.map_root = of_modes.bottomRows(map->modes());
  out.map = found.map;
  return out;
}

}  // namespace tagtwist::internal

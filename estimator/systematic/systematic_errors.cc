#include "estimator/systematic/systematic_errors.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <optional>

namespace tagtwist::internal {
namespace {

constexpr size_t kMostFrames = 500;
// Share of the errors' effect on the states that may be neglected; where errors are given, which
// may be many times the noise, of a frame's own noise where that is less.
constexpr double kNeglected = 0.002;
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
  Eigen::MatrixXd by = Eigen::MatrixXd::Zero(6, out->gradient.size());
  for (const TagTerms& tag : tags) {
    const Eigen::MatrixXd of_tag = scale.asDiagonal() * tag.by_pose.transpose() * tag.by_parameters;
    for (size_t j = 0; j < tag.columns.size(); ++j) {
      by.col(tag.columns[j]) += of_tag.col(static_cast<Eigen::Index>(j));
    }
  }
  llt.matrixL().solveInPlace(by);
  const Eigen::VectorXd taken = llt.matrixL().solve(scale.cwiseProduct(gradient));
  out->information.selfadjointView<Eigen::Lower>().rankUpdate(by.transpose(), -1);
  out->gradient -= by.transpose() * taken;
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

// Columns whose squares sum up to the second moment, but for those that hardly move a pose: by no
// more than a share of all of them, or of `noise`, if that is less.
Eigen::MatrixXd RootOf(const EvidenceFit& fit, const Eigen::MatrixXd& taken_by_poses,
                       double noise) {
  const Eigen::MatrixXd moment = fit.covariance + fit.mean * fit.mean.transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> own(moment);
  const Eigen::MatrixXd root =
      own.eigenvectors() * own.eigenvalues().cwiseMax(0).cwiseSqrt().asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> effect(root.transpose() * taken_by_poses *
                                                              root);
  const Eigen::VectorXd& sizes = effect.eigenvalues();  // ascending
  const double all = std::min(noise, sizes.cwiseMax(0).sum());
  Eigen::Index neglected = 0;
  double sum = 0;
  while (neglected < sizes.size() && sum + std::max(0.0, sizes(neglected)) <= kNeglected * all) {
    sum += std::max(0.0, sizes(neglected++));
  }
  return root * effect.eigenvectors().rightCols(sizes.size() - neglected);
}

}  // namespace

SystematicErrors LearnSystematicErrors(const SystematicBasis& basis, const NoiseModel& noise,
                                       const std::vector<GraphFrame>& frames) {
  const Sums sums = SumUp(basis, noise, frames);
  SystematicErrors out;
  if (!(sums.eliminated.dof > 0)) return out;
  const EvidenceFit fit = FitByEvidence(basis.ToModes(sums.eliminated), basis.Groups());
  out.noise_scale = fit.noise_scale;
  if (fit.IsEmpty()) return out;
  out.field_sigma_px = fit.groups[0].sigma;
  out.tag_sigma_m = fit.groups[1].sigma;
  out.bias_sigma_px = fit.groups[2].sigma;
  if (fit.groups.size() > 4) {  // of a rig
    out.mount_sigma_rad = fit.groups[4].sigma;
    out.mount_sigma_m = fit.groups[5].sigma;
  }
  const Eigen::MatrixXd taken = sums.known_poses - sums.eliminated.information;
  const double of_noise = basis.AnyIsGiven() ? 6.0 * sums.frames : HUGE_VAL;
  out.root = basis.FromModes(RootOf(fit, basis.ToModes(taken), of_noise));
  return out;
}

}  // namespace tagtwist::internal

#include "estimator/systematic/mount_border.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "estimator/graph/linear_system.h"
#include "estimator/linear/block_banded.h"

namespace tagtwist::internal {
namespace {

constexpr int kStateSize = BlockBandedMatrix::kSize;

// Parameters are the basis' modes, and last the clocks. Scaled to unit prior variance.
struct Scales {
  Eigen::VectorXd sigmas;
  int turns = 0, shifts = 0, clocks = 0;  // where the mounts' and the clocks' begin
  int others = 0;                         // cameras after the first
};

Scales ScalesOf(const SystematicBasis& basis, const SystematicErrors& errors,
                const MountPriors& priors) {
  const std::vector<ParameterGroup> groups = basis.Groups();
  const int map_modes = errors.map ? errors.map->modes() : 0;
  Scales out;
  out.turns = groups[4].first;
  out.shifts = groups[5].first;
  out.others = groups[4].size / 3;
  out.clocks = basis.modes() + map_modes;
  out.sigmas = Eigen::VectorXd::Zero(out.clocks + out.others);
  const double sigmas[] = {errors.field_sigma_px, errors.tag_sigma_m,  errors.bias_sigma_px,
                           groups[3].sigma,       priors.rotation_rad, priors.position_m};
  for (size_t i = 0; i < 6; ++i) {
    out.sigmas.segment(groups[i].first, groups[i].size).setConstant(sigmas[i]);
  }
  out.sigmas.segment(basis.modes(), map_modes).setConstant(errors.map_sigma_m);
  out.sigmas.tail(out.others).setConstant(priors.clock_s);
  return out;
}

// Over all tags, F what a unit of the parameters adds to their seen corners, r the residual,
// predicted less seen, which they take F z from: by the basis' knots, and last the clocks.
struct Normals {
  Eigen::MatrixXd own;                 // F'F, lower triangle
  Eigen::VectorXd gradient;            // F'r
  std::vector<Eigen::MatrixXd> cross;  // of each frame F'J, parameters x 6
};

// What a frame's pose does in a second [rad/s], [m/s].
PoseStep MotionOf(const BodyState& state) {
  PoseStep out;
  out << state.twist.omega_body, state.twist.v_world;
  return out;
}

void AddTag(const SystematicBasis::TagTerms& tag, int camera, int n_knots, const PoseStep& motion,
            Normals* out, Eigen::MatrixXd* cross) {
  std::vector<int> columns = tag.columns;
  Eigen::MatrixXd by = tag.by_parameters;
  if (camera > 0) {
    columns.push_back(n_knots + camera - 1);
    by.conservativeResize(Eigen::NoChange, by.cols() + 1);
    by.rightCols<1>() = tag.by_pose * motion;
  }
  const Eigen::MatrixXd square = by.transpose() * by;
  const Eigen::VectorXd gradient = by.transpose() * tag.residual;
  const Eigen::MatrixXd with_pose = by.transpose() * tag.by_pose;
  for (size_t j = 0; j < columns.size(); ++j) {
    const auto b = static_cast<Eigen::Index>(j);
    out->gradient(columns[j]) += gradient(b);
    cross->row(columns[j]) += with_pose.row(b);
    for (size_t i = j; i < columns.size(); ++i) {
      out->own(columns[i], columns[j]) += square(static_cast<Eigen::Index>(i), b);
    }
  }
}

// Rows by knots and clocks to rows by modes and clocks.
Eigen::MatrixXd ToModes(const SystematicBasis& basis, const MapField* map,
                        const Eigen::MatrixXd& rows) {
  const Eigen::Index clocks = rows.rows() - basis.size();
  const Eigen::MatrixXd of_modes = basis.ToModes(Eigen::MatrixXd(rows.topRows(basis.size())), map);
  Eigen::MatrixXd out(of_modes.rows() + clocks, rows.cols());
  out << of_modes, rows.bottomRows(clocks);
  return out;
}

Normals SumUp(const SystematicBasis& basis, const MapField* map, int n_clocks,
              const NoiseModel& noise, const std::vector<GraphFrame>& frames) {
  const int n = basis.size() + n_clocks;
  Normals out{Eigen::MatrixXd::Zero(n, n), Eigen::VectorXd::Zero(n), {}};
  SystematicBasis::TagTerms terms;
  for (const GraphFrame& frame : frames) {
    Eigen::MatrixXd cross = Eigen::MatrixXd::Zero(n, 6);
    for (const TagDetection& tag : frame.tags) {
      if (!basis.Linearize(noise, frame.state.world_from_body, tag, &terms)) continue;
      AddTag(terms, tag.camera, basis.size(), MotionOf(frame.state), &out, &cross);
    }
    out.cross.push_back(ToModes(basis, map, cross));
  }
  const Eigen::MatrixXd own = out.own.selfadjointView<Eigen::Lower>();
  out.own = ToModes(basis, map, Eigen::MatrixXd(ToModes(basis, map, own).transpose()));
  out.gradient = ToModes(basis, map, Eigen::MatrixXd(out.gradient));
  return out;
}

// Takes out of the normal equations what the states take of them.
void EliminateStates(const LinearSystem& system, const BlockBandedCholesky& cholesky,
                     Normals* out) {
  const auto n = static_cast<Eigen::Index>(out->cross.size());
  const auto with_cross = [&](const Eigen::VectorXd& states) {
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(out->gradient.size());
    for (Eigen::Index k = 0; k < n; ++k) {
      sum += out->cross[static_cast<size_t>(k)] * states.segment<6>(k * kStateSize);
    }
    return sum;
  };
  out->gradient -= with_cross(cholesky.Solve(system.gradient));
  Eigen::VectorXd push = Eigen::VectorXd::Zero(n * kStateSize);
  for (Eigen::Index j = 0; j < out->own.cols(); ++j) {
    for (Eigen::Index k = 0; k < n; ++k) {
      push.segment<6>(k * kStateSize) = out->cross[static_cast<size_t>(k)].row(j).transpose();
    }
    if (!push.isZero(0)) out->own.col(j) -= with_cross(cholesky.Solve(push));
  }
}

}  // namespace

double MountBorder::StepInSigmas() const {
  double out = 0;
  for (Eigen::Index i = 0; i < step.size(); ++i) {
    if (covariance(i, i) > 0) out = std::max(out, std::abs(step(i)) / std::sqrt(covariance(i, i)));
  }
  return out;
}

std::optional<MountBorder> MakeMountBorder(const SystematicBasis& basis,
                                           const SystematicErrors& errors,
                                           const MountPriors& priors, const NoiseModel& noise,
                                           const Graph& graph,
                                           const std::vector<GraphFrame>& frames) {
  const Scales scales = ScalesOf(basis, errors, priors);
  const MapField* map = errors.map ? &*errors.map : nullptr;
  const LinearSystem system = Linearize(graph);
  const BlockBandedCholesky cholesky(system.hessian);
  if (!cholesky.ok()) return std::nullopt;
  Normals normals = SumUp(basis, map, scales.others, noise, frames);
  EliminateStates(system, cholesky, &normals);
  // In units of the priors: what is held has none of it.
  const auto& sigmas = scales.sigmas;
  Eigen::MatrixXd scaled = sigmas.asDiagonal() * normals.own * sigmas.asDiagonal();
  scaled.diagonal().array() += 1;
  const Eigen::LLT<Eigen::MatrixXd> llt(scaled);
  if (llt.info() != Eigen::Success) return std::nullopt;
  const Eigen::VectorXd mean =
      -sigmas.cwiseProduct(llt.solve(sigmas.cwiseProduct(normals.gradient)));
  std::vector<int> entries;
  for (int camera = 0; camera < scales.others; ++camera) {
    for (int a = 0; a < 3; ++a) entries.push_back(scales.turns + 3 * camera + a);
    for (int a = 0; a < 3; ++a) entries.push_back(scales.shifts + 3 * camera + a);
    entries.push_back(scales.clocks + camera);
  }
  const auto n = static_cast<Eigen::Index>(entries.size());
  Eigen::MatrixXd chosen = Eigen::MatrixXd::Zero(sigmas.size(), n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const int entry = entries[static_cast<size_t>(i)];
    chosen(entry, i) = sigmas(entry);
  }
  MountBorder out;
  out.step.resize(n);
  for (Eigen::Index i = 0; i < n; ++i) out.step(i) = mean(entries[static_cast<size_t>(i)]);
  const Eigen::MatrixXd covariance = chosen.transpose() * llt.solve(chosen);
  out.covariance = 0.5 * (covariance + covariance.transpose());
  return out;
}

}  // namespace tagtwist::internal

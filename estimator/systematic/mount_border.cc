#include "estimator/systematic/mount_border.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "estimator/graph/linear_system.h"
#include "estimator/linear/block_banded.h"

namespace tagtwist::internal {
namespace {

constexpr int kStateSize = BlockBandedMatrix::kSize;

// Of the entries of a MountBorder which of the basis' parameters, and of the clocks after these.
std::vector<int> EntriesOf(const SystematicBasis& basis, int n_cameras) {
  std::vector<int> out;
  for (int camera = 1; camera < n_cameras; ++camera) {
    for (const int parameter : basis.OfMount(camera)) out.push_back(parameter);
    out.push_back(basis.size() + camera - 1);
  }
  return out;
}

Eigen::VectorXd SigmasOf(const MountPriors& priors, int n_cameras) {
  Eigen::VectorXd out(MountBorder::kEntries * (n_cameras - 1));
  for (int camera = 1; camera < n_cameras; ++camera) {
    out.segment<MountBorder::kEntries>(MountBorder::kEntries * (camera - 1)) << priors.rotation_rad,
        priors.rotation_rad, priors.rotation_rad, priors.position_m, priors.position_m,
        priors.position_m, priors.clock_s;
  }
  return out;
}

// Over all tags, F what a unit of the parameters adds to their seen corners, r the residual,
// predicted less seen, which they take F z from. All by all parameters, and last the clocks.
struct Normals {
  Eigen::MatrixXd with_entries;        // F' (F of the entries)
  Eigen::VectorXd gradient;            // F' r
  std::vector<Eigen::MatrixXd> cross;  // of each frame F' J, parameters x 6
};

// What a frame's pose does in a second [rad/s], [m/s].
PoseStep MotionOf(const BodyState& state) {
  PoseStep out;
  out << state.twist.omega_body, state.twist.v_world;
  return out;
}

void AddTag(const SystematicBasis::TagTerms& tag, int camera, int n_parameters,
            const std::vector<int>& entries, const PoseStep& motion, Normals* out,
            Eigen::MatrixXd* cross) {
  std::vector<int> columns = tag.columns;
  Eigen::MatrixXd by = tag.by_parameters;
  if (camera > 0) {
    columns.push_back(n_parameters + camera - 1);
    by.conservativeResize(Eigen::NoChange, by.cols() + 1);
    by.rightCols<1>() = tag.by_pose * motion;
  }
  const Eigen::VectorXd gradient = by.transpose() * tag.residual;
  const Eigen::MatrixXd with_pose = by.transpose() * tag.by_pose;
  for (size_t j = 0; j < columns.size(); ++j) {
    const auto b = static_cast<Eigen::Index>(j);
    out->gradient(columns[j]) += gradient(b);
    cross->row(columns[j]) += with_pose.row(b);
    const auto entry = std::find(entries.begin(), entries.end(), columns[j]);
    if (entry == entries.end()) continue;
    const Eigen::VectorXd square = by.transpose() * by.col(b);
    for (size_t i = 0; i < columns.size(); ++i) {
      out->with_entries(columns[i], entry - entries.begin()) +=
          square(static_cast<Eigen::Index>(i));
    }
  }
}

Normals SumUp(const SystematicBasis& basis, const std::vector<int>& entries, int n_cameras,
              const NoiseModel& noise, const std::vector<GraphFrame>& frames) {
  const int n = basis.size() + n_cameras - 1;
  Normals out{Eigen::MatrixXd::Zero(n, static_cast<Eigen::Index>(entries.size())),
              Eigen::VectorXd::Zero(n),
              {}};
  SystematicBasis::TagTerms terms;
  for (const GraphFrame& frame : frames) {
    Eigen::MatrixXd cross = Eigen::MatrixXd::Zero(n, 6);
    for (const TagDetection& tag : frame.tags) {
      if (!basis.Linearize(noise, frame.state.world_from_body, tag, &terms)) continue;
      AddTag(terms, tag.camera, basis.size(), entries, MotionOf(frame.state), &out, &cross);
    }
    out.cross.push_back(std::move(cross));
  }
  return out;
}

// Takes out of the normal equations what the states take of them.
void EliminateStates(const LinearSystem& system, const BlockBandedCholesky& cholesky,
                     const std::vector<int>& entries, Normals* out) {
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
  for (size_t j = 0; j < entries.size(); ++j) {
    for (Eigen::Index k = 0; k < n; ++k) {
      push.segment<6>(k * kStateSize) =
          out->cross[static_cast<size_t>(k)].row(entries[j]).transpose();
    }
    out->with_entries.col(static_cast<Eigen::Index>(j)) -= with_cross(cholesky.Solve(push));
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
                                           const MountPriors& priors, int n_cameras,
                                           const NoiseModel& noise, const Graph& graph,
                                           const std::vector<GraphFrame>& frames) {
  const LinearSystem system = Linearize(graph);
  const BlockBandedCholesky cholesky(system.hessian);
  if (!cholesky.ok()) return std::nullopt;
  const std::vector<int> entries = EntriesOf(basis, n_cameras);
  const Eigen::VectorXd sigmas = SigmasOf(priors, n_cameras);
  Normals normals = SumUp(basis, entries, n_cameras, noise, frames);
  EliminateStates(system, cholesky, entries, &normals);
  const auto n = static_cast<Eigen::Index>(entries.size());
  Eigen::MatrixXd own(n, n);
  Eigen::VectorXd gradient(n);
  const Eigen::MatrixXd& lasting = errors.root;
  for (Eigen::Index i = 0; i < n; ++i) {
    const int entry = entries[static_cast<size_t>(i)];
    own.row(i) = normals.with_entries.row(entry);
    gradient(i) = normals.gradient(entry);
  }
  // In units of the priors: what is held has none of it.
  Eigen::MatrixXd scaled = sigmas.asDiagonal() * own * sigmas.asDiagonal();
  scaled.diagonal().array() += 1;
  const Eigen::LLT<Eigen::MatrixXd> llt(0.5 * (scaled + scaled.transpose()));
  if (llt.info() != Eigen::Success) return std::nullopt;
  const auto solve = [&](const Eigen::MatrixXd& right) -> Eigen::MatrixXd {
    return sigmas.asDiagonal() * llt.solve(sigmas.asDiagonal() * right);
  };
  MountBorder out;
  out.step = -solve(gradient);
  out.covariance = solve(Eigen::MatrixXd::Identity(n, n));
  if (errors.None()) return out;
  const Eigen::MatrixXd by_errors =
      solve(normals.with_entries.topRows(lasting.rows()).transpose() * lasting);
  out.covariance += by_errors * by_errors.transpose();
  return out;
}

}  // namespace tagtwist::internal

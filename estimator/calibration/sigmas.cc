#include "estimator/calibration/sigmas.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <vector>

#include "estimator/calibration/normals.h"
#include "estimator/calibration/observability.h"
#include "frontend/base/statistics/chi_square.h"

namespace tagtwist::internal {
namespace {

// First frames of the blocks, and the end of the last one.
std::vector<size_t> BlockBounds(const std::vector<CalibrationFrame>& frames) {
  constexpr double kBlockS = 2, kShortestS = 0.5;
  constexpr int kFewest = 4, kWanted = 10, kMost = 40;
  if (frames.size() < 2) return {};
  const double length_s = ToSeconds(frames.back().t_ns - frames.front().t_ns);
  const double block_s =
      std::max({std::min(kBlockS, length_s / kWanted), kShortestS, length_s / kMost});
  std::vector<size_t> out = {0};
  const auto block_of = [&](size_t i) {
    return std::floor(ToSeconds(frames[i].t_ns - frames.front().t_ns) / block_s);
  };
  for (size_t i = 1; i < frames.size(); ++i) {
    if (block_of(i) != block_of(i - 1)) out.push_back(i);
  }
  if (static_cast<int>(out.size()) < kFewest) return {};
  out.push_back(frames.size());
  return out;
}

// What one block adds to the normal equations of the free entries.
struct BlockNormals {
  Eigen::MatrixXd information;
  Eigen::VectorXd gradient;
};

class Blocks {
 public:
  Blocks(const CalibrationProblem& problem, const CalibrationSolution& solution)
      : problem_(problem), solution_(solution), free_(FreeEntries(problem.prior_sigmas)) {
    const Eigen::VectorXd sigmas = problem.prior_sigmas(free_);
    prior_information_ = sigmas.cwiseAbs2().cwiseInverse();
    const Eigen::VectorXd change = Difference(solution.state, problem.prior)(free_);
    prior_gradient_ = prior_information_.cwiseProduct(change);
  }

  const std::vector<int>& free() const { return free_; }
  const Eigen::VectorXd& prior_information() const { return prior_information_; }

  BlockNormals Of(size_t begin, size_t end) const {
    const std::vector<CalibrationFrame> frames(
        solution_.frames.begin() + static_cast<std::ptrdiff_t>(begin),
        solution_.frames.begin() + static_cast<std::ptrdiff_t>(end));
    const CalibrationNormals normals =
        LinearizeCalibration(problem_, solution_.state, frames, solution_.noise, 0);
    BlockNormals out{normals.information(free_, free_), normals.gradient(free_)};
    out.information.diagonal() -= prior_information_;
    out.gradient -= prior_gradient_;
    return out;
  }

 private:
  const CalibrationProblem& problem_;
  const CalibrationSolution& solution_;
  std::vector<int> free_;
  Eigen::VectorXd prior_information_, prior_gradient_;
};

// All blocks together: their information without the prior's, and a column a block of gradients.
struct AllBlocks {
  Eigen::MatrixXd information, gradients;
};

AllBlocks SumUp(const Blocks& blocks, const std::vector<size_t>& bounds) {
  const Eigen::Index n = blocks.prior_information().size();
  AllBlocks out{Eigen::MatrixXd::Zero(n, n),
                Eigen::MatrixXd(n, static_cast<Eigen::Index>(bounds.size()) - 1)};
  for (size_t b = 0; b + 1 < bounds.size(); ++b) {
    const BlockNormals block = blocks.Of(bounds[b], bounds[b + 1]);
    out.information += block.information;
    out.gradients.col(static_cast<Eigen::Index>(b)) = block.gradient;
  }
  return out;
}

// Of the free entries, by leaving out each block in turn.
Eigen::VectorXd JackknifeVariances(const Blocks& blocks, const std::vector<size_t>& bounds,
                                   const AllBlocks& all) {
  const Eigen::VectorXd mean_gradient = all.gradients.rowwise().mean();
  Eigen::MatrixXd moves(all.gradients.rows(), all.gradients.cols());
  for (size_t b = 0; b + 1 < bounds.size(); ++b) {
    const auto column = static_cast<Eigen::Index>(b);
    Eigen::MatrixXd left = all.information - blocks.Of(bounds[b], bounds[b + 1]).information;
    left.diagonal() += blocks.prior_information();
    moves.col(column) = left.llt().solve(all.gradients.col(column) - mean_gradient);
  }
  const Eigen::VectorXd mean = moves.rowwise().mean();
  moves.colwise() -= mean;
  const auto count = static_cast<double>(moves.cols());
  return (count - 1) / count * moves.rowwise().squaredNorm();
}

// Places among the free entries of those that share a ratio: an entry alone, and of all tags those
// of one kind.
std::vector<std::vector<Eigen::Index>> AlikeEntries(const CalibrationLayout& layout,
                                                    const std::vector<int>& free) {
  std::vector<std::vector<Eigen::Index>> out, of_tags(kTagEntries);
  for (size_t i = 0; i < free.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    if (free[i] < layout.tag(0)) {
      out.push_back({k});
    } else {
      of_tags[static_cast<size_t>((free[i] - layout.tag(0)) % kTagEntries)].push_back(k);
    }
  }
  for (const auto& kind : of_tags) {
    if (!kind.empty()) out.push_back(kind);
  }
  return out;
}

// What a ratio of variances stays below by chance, 99 times of 100.
double ChanceOf(double dof) { return ChiSquareQuantile(0.99, dof) / dof; }

// The covariance without what the map moved by as a whole, which the priors of its tags alone tell.
Eigen::MatrixXd WithoutMotionsOfMap(const CalibrationState& state, const KnownSigmas& known) {
  const Eigen::VectorXd& sigmas = known.prior_sigmas;
  const Eigen::VectorXd units =
      (sigmas.array() > 0).select(Eigen::VectorXd::Ones(sigmas.size()), 0.0);
  const Eigen::MatrixXd common = RigidMotionsOfMap(state, units);
  const Eigen::MatrixXd half = known.covariance - common * (common.transpose() * known.covariance);
  return half - (half * common) * common.transpose();
}

}  // namespace

Eigen::MatrixXd BlockCovariance(const CalibrationProblem& problem,
                                const CalibrationSolution& solution) {
  const std::vector<size_t> bounds = BlockBounds(solution.frames);
  const Blocks blocks(problem, solution);
  if (bounds.empty() || blocks.free().empty()) return solution.covariance;
  const AllBlocks all = SumUp(blocks, bounds);
  const Eigen::MatrixXd white = solution.covariance(blocks.free(), blocks.free());
  const Eigen::MatrixXd by_data = white * all.information * white;
  const Eigen::VectorXd by_blocks = JackknifeVariances(blocks, bounds, all);
  const double dof = static_cast<double>(bounds.size()) - 2;
  const CalibrationLayout layout = LayoutOf(solution.state);
  Eigen::VectorXd growth = Eigen::VectorXd::Ones(white.rows());
  for (const std::vector<Eigen::Index>& alike : AlikeEntries(layout, blocks.free())) {
    const double ratio = by_blocks(alike).sum() / by_data.diagonal()(alike).sum();
    if (!(ratio > ChanceOf(dof * std::sqrt(static_cast<double>(alike.size()))))) continue;
    for (const Eigen::Index k : alike) growth(k) = std::sqrt(ratio);
  }
  Eigen::MatrixXd out = solution.covariance;
  if (!(growth.maxCoeff() > 1)) return out;
  const Eigen::MatrixXd by_prior = white * blocks.prior_information().asDiagonal() * white;
  const Eigen::MatrixXd grown = by_prior + growth.asDiagonal() * by_data * growth.asDiagonal();
  out(blocks.free(), blocks.free()) = grown;
  return out;
}

Eigen::MatrixXd AboutRefined(const Eigen::MatrixXd& covariance, const CalibrationState& refined,
                             const CalibrationState& all, const Eigen::VectorXd& prior_sigmas) {
  const Eigen::VectorXd off = Difference(refined, all);
  const Eigen::MatrixXd out = covariance + off * off.transpose();
  const Eigen::ArrayXd sigmas = out.diagonal().cwiseMax(0).cwiseSqrt().array();
  const Eigen::ArrayXd shrunk = prior_sigmas.array() / sigmas;
  const Eigen::VectorXd scale = (sigmas > prior_sigmas.array()).select(shrunk, 1.0);
  return scale.asDiagonal() * out * scale.asDiagonal();
}

double TagSigma(const CalibrationState& refined, const KnownSigmas& known) {
  const CalibrationLayout layout = LayoutOf(refined);
  const Eigen::VectorXd variances =
      (known.has_truth ? known.covariance : WithoutMotionsOfMap(refined, known)).diagonal();
  double sum = 0;
  int tags = 0;
  for (int i = 0; i < layout.n_tags; ++i) {
    const int first = layout.tag(i) + 3;
    if (!(known.covariance(first, first) > 0)) continue;
    sum += std::max(0.0, variances.segment<3>(first).mean());
    ++tags;
  }
  return tags > 0 ? std::sqrt(sum / tags) : 0;
}

Eigen::MatrixXd CameraCovariance(const CalibrationState& refined, const KnownSigmas& known,
                                 const Eigen::MatrixXd& given) {
  constexpr int kMountEntries = 6;
  const CalibrationLayout layout = LayoutOf(refined);
  const Eigen::Index lens = layout.lens_size, all = lens + kMountEntries;
  std::vector<int> entries;
  for (int i = 0; i < layout.lens_size; ++i) entries.push_back(i);
  for (int i = 0; i < kMountEntries; ++i) entries.push_back(layout.mount() + i);
  Eigen::MatrixXd out = known.covariance(entries, entries);
  if (given.rows() == all && out.topLeftCorner(lens, lens).isZero(0)) {
    out.topLeftCorner(lens, lens) = given.topLeftCorner(lens, lens);
  }
  if (given.rows() == all && out.bottomRightCorner<kMountEntries, kMountEntries>().isZero(0)) {
    out.bottomRightCorner<kMountEntries, kMountEntries>() =
        given.bottomRightCorner<kMountEntries, kMountEntries>();
  }
  return out.isZero(0) ? Eigen::MatrixXd() : out;
}

}  // namespace tagtwist::internal

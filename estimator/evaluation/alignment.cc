#include "estimator/evaluation/alignment.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "estimator/evaluation/hand_eye.h"

namespace tagtwist::internal {
namespace {

constexpr size_t kMinMatches = 3;

// Mean of rotations by the largest eigenvector of sum of q q' (Markley et al. 2007).
Eigen::Quaterniond MeanRotation(const std::vector<Eigen::Quaterniond>& rotations) {
  Eigen::Matrix4d sum = Eigen::Matrix4d::Zero();
  for (const Eigen::Quaterniond& q : rotations) sum += q.coeffs() * q.coeffs().transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> solver(sum);
  return Eigen::Quaterniond(Eigen::Vector4d(solver.eigenvectors().col(3)));
}

// Given the rotation of truth_from_world, the translation that fits the positions.
Pose WithFittedTranslation(const Eigen::Quaterniond& rotation,
                           const std::vector<TruthMatch>& matches) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const TruthMatch& m : matches) {
    sum +=
        m.truth.world_from_body.translation() - rotation * m.estimate.world_from_body.translation();
  }
  return MakePose(rotation, sum / static_cast<double>(matches.size()));
}

double PositionCost(const std::vector<TruthMatch>& matches, const Pose& truth_from_world) {
  double sum = 0;
  for (const TruthMatch& m : matches) {
    sum += (m.truth.world_from_body.translation() -
            truth_from_world * m.estimate.world_from_body.translation())
               .squaredNorm();
  }
  return sum / static_cast<double>(matches.size());
}

// Mean squared position misfit at a time offset, the world aligned unless that is not wanted;
// infinite where the overlap is too small to compare.
double OffsetCost(const PoseSeries& series, const std::vector<TruthSample>& truth, double offset_s,
                  size_t min_matches, const AlignmentOptions& options) {
  const auto matches = MatchTruth(series, truth, offset_s, options.max_truth_gap_s);
  if (matches.size() < min_matches) return std::numeric_limits<double>::infinity();
  return PositionCost(matches,
                      options.kind == AlignmentKind::kNone ? Pose() : AlignPositions(matches));
}

PoseSeries Subsample(const PoseSeries& series, size_t max_size) {
  const size_t step = (series.size() + max_size - 1) / max_size;
  PoseSeries out;
  for (size_t i = 0; i < series.size(); i += std::max<size_t>(step, 1)) {
    out.push_back(series[i]);
    out.back().covariance.reset();
  }
  return out;
}

// A grid of 10 ms over the whole range, then golden sections around its best point.
double SearchTimeOffset(const PoseSeries& series, const std::vector<TruthSample>& truth,
                        const AlignmentOptions& options) {
  constexpr double kGridStepS = 0.01, kGolden = 0.6180339887498949;
  const PoseSeries some = Subsample(series, 1000);
  const size_t overlap =
      MatchTruth(some, truth, options.time_offset_s, options.max_truth_gap_s).size();
  const size_t min_matches = std::max(kMinMatches, overlap / 2);
  const auto cost = [&](double offset_s) {
    return OffsetCost(some, truth, offset_s, min_matches, options);
  };
  const int half = static_cast<int>(std::ceil(options.max_time_offset_s / kGridStepS));
  double best = options.time_offset_s, best_cost = cost(best);
  for (int i = -half; i <= half; ++i) {
    const double offset = options.time_offset_s + i * kGridStepS, c = cost(offset);
    if (c < best_cost) {
      best = offset;
      best_cost = c;
    }
  }
  double low = best - kGridStepS, high = best + kGridStepS;
  while (high - low > 1e-7) {
    const double a = high - kGolden * (high - low), b = low + kGolden * (high - low);
    if (cost(a) < cost(b)) {
      high = b;
    } else {
      low = a;
    }
  }
  return 0.5 * (low + high);
}

// Two starts of a hand-eye alignment, for positions alone may leave the rotation open, and
// rotations alone cannot tell the two sides apart.
std::vector<Alignment> HandEyeStarts(const std::vector<TruthMatch>& matches, double time_offset_s) {
  Alignment by_position, by_rotation;
  by_position.time_offset_s = by_rotation.time_offset_s = time_offset_s;
  by_position.truth_from_world = AlignPositions(matches);
  std::vector<Eigen::Quaterniond> right, left;
  for (const TruthMatch& m : matches) {
    const Eigen::Quaterniond r(m.estimate.world_from_body.rotation());
    const Eigen::Quaterniond t(m.truth.world_from_body.rotation());
    right.push_back((by_position.truth_from_world.rotation() * r).conjugate() * t);
    left.push_back(t * r.conjugate());
  }
  by_position.body_from_marker = MakePose(MeanRotation(right), Eigen::Vector3d::Zero());
  by_rotation.truth_from_world = WithFittedTranslation(MeanRotation(left), matches);
  return {by_position, by_rotation};
}

}  // namespace

Pose AlignPositions(const std::vector<TruthMatch>& matches) {
  const auto n = static_cast<Eigen::Index>(matches.size());
  Eigen::Matrix3Xd from(3, n), to(3, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const TruthMatch& m = matches[static_cast<size_t>(i)];
    from.col(i) = m.estimate.world_from_body.translation();
    to.col(i) = m.truth.world_from_body.translation();
  }
  const Eigen::Matrix4d t = Eigen::umeyama(from, to, /*with_scaling=*/false);
  return MakePose(Eigen::Quaterniond(Eigen::Matrix3d(t.topLeftCorner<3, 3>())),
                  t.topRightCorner<3, 1>());
}

Result<Alignment> EstimateAlignment(const PoseSeries& series, const std::vector<TruthSample>& truth,
                                    const AlignmentOptions& options) {
  Alignment out;
  out.time_offset_s = options.time_offset_s;
  if (options.kind == AlignmentKind::kNone && !options.estimate_time_offset) return out;
  if (options.estimate_time_offset) out.time_offset_s = SearchTimeOffset(series, truth, options);
  const auto matches = MatchTruth(series, truth, out.time_offset_s, options.max_truth_gap_s);
  if (matches.size() < kMinMatches) {
    return Error{"alignment needs at least " + std::to_string(kMinMatches) +
                 " poses with ground truth, got " + std::to_string(matches.size())};
  }
  if (options.kind == AlignmentKind::kSe3) out.truth_from_world = AlignPositions(matches);
  if (options.kind == AlignmentKind::kHandEye) {
    return AlignHandEye(series, truth, HandEyeStarts(matches, out.time_offset_s), options);
  }
  return out;
}

std::vector<TruthMatch> AlignedMatches(const PoseSeries& series,
                                       const std::vector<TruthSample>& truth,
                                       const Alignment& alignment, double max_truth_gap_s) {
  auto matches = MatchTruth(series, truth, alignment.time_offset_s, max_truth_gap_s);
  for (TruthMatch& m : matches) {
    m.estimate = Transform(m.estimate, alignment.truth_from_world, alignment.body_from_marker);
  }
  return matches;
}

}  // namespace tagtwist::internal

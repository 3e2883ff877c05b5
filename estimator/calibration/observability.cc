#include "estimator/calibration/observability.h"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <map>

#include "frontend/types/so3.h"

namespace tagtwist::internal {

namespace {

constexpr const char* kWholeMap = "the map as a whole";

// Tags with a free position.
std::vector<int> FreeTags(const CalibrationLayout& layout, const Eigen::VectorXd& sigmas) {
  std::vector<int> out;
  for (int i = 0; i < layout.n_tags; ++i) {
    if (sigmas(layout.tag(i) + 3) > 0) out.push_back(i);
  }
  return out;
}

Eigen::Vector3d CentreOf(const CalibrationState& state, const std::vector<int>& tags) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const int i : tags) sum += state.tags[static_cast<size_t>(i)].world_from_tag.translation();
  return sum / static_cast<double>(std::max<size_t>(1, tags.size()));
}

// Kinds and shares of a unit vector over all entries.
std::vector<UnseenDirection::Part> PartsOf(const Eigen::VectorXd& direction,
                                           const Eigen::MatrixXd& rigid,
                                           const std::vector<CalibrationParameter>& parameters) {
  constexpr double kLeastShare = 0.05;
  const Eigen::VectorXd as_whole = rigid.transpose() * direction;
  const Eigen::VectorXd rest = direction - rigid * as_whole;
  std::map<std::string, double> shares;
  shares[kWholeMap] = as_whole.squaredNorm();
  for (size_t i = 0; i < parameters.size(); ++i) {
    const double entry = rest(static_cast<Eigen::Index>(i));
    shares[parameters[i].kind] += entry * entry;
  }
  std::vector<UnseenDirection::Part> out;
  for (const auto& [kind, share] : shares) {
    if (share >= kLeastShare) out.push_back({kind, share});
  }
  std::sort(out.begin(), out.end(), [](const auto& a, const auto& b) { return a.share > b.share; });
  return out;
}

}  // namespace

std::vector<UnseenDirection> FindUnseen(const CalibrationState& reference,
                                        const std::vector<CalibrationParameter>& parameters,
                                        const Eigen::VectorXd& prior_sigmas,
                                        const Eigen::MatrixXd& covariance) {
  constexpr double kUnseen = 0.5;
  std::vector<int> free;
  for (Eigen::Index i = 0; i < prior_sigmas.size(); ++i) {
    if (prior_sigmas(i) > 0) free.push_back(static_cast<int>(i));
  }
  std::vector<UnseenDirection> out;
  if (free.empty()) return out;
  const Eigen::VectorXd inverse = prior_sigmas(free).cwiseInverse();
  const Eigen::MatrixXd whitened =
      inverse.asDiagonal() * covariance(free, free) * inverse.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(whitened);
  const Eigen::MatrixXd rigid = RigidMotionsOfMap(reference, prior_sigmas);
  for (Eigen::Index k = eigen.eigenvalues().size() - 1; k >= 0; --k) {
    if (!(eigen.eigenvalues()(k) > kUnseen)) break;
    Eigen::VectorXd direction = Eigen::VectorXd::Zero(prior_sigmas.size());
    const Eigen::VectorXd of_free = eigen.eigenvectors().col(k);
    direction(free) = of_free;
    out.push_back({eigen.eigenvalues()(k), PartsOf(direction, rigid, parameters)});
  }
  return out;
}

Eigen::MatrixXd RigidMotionsOfMap(const CalibrationState& reference, const Eigen::VectorXd& units) {
  const CalibrationLayout layout = LayoutOf(reference);
  const std::vector<int> tags = FreeTags(layout, units);
  const Eigen::Vector3d centre = CentreOf(reference, tags);
  Eigen::MatrixXd motions = Eigen::MatrixXd::Zero(layout.size(), 6);
  for (const int i : tags) {
    const Pose& pose = reference.tags[static_cast<size_t>(i)].world_from_tag;
    const int first = layout.tag(i);
    motions.block<3, 3>(first, 3) = pose.rotation().toRotationMatrix().transpose();
    motions.block<3, 3>(first + 3, 3) = -Hat(pose.translation() - centre);
    motions.block<3, 3>(first + 3, 0).setIdentity();
    for (int k = first; k < first + 6; ++k) {
      motions.row(k) *= units(k) > 0 ? 1 / units(k) : 0.0;
    }
  }
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(motions);
  const Eigen::MatrixXd q = qr.householderQ() * Eigen::MatrixXd::Identity(layout.size(), 6);
  return q.leftCols(qr.rank());
}

std::string WhatWouldShow(const std::string& kind) {
  if (kind == "focal length" || kind == "aspect fy/fx") {
    return "views that tilt against the tags, or tags at several depths in one image";
  }
  if (kind.rfind("principal point", 0) == 0) return "tilted views from several sides";
  if (kind == "line time") return "faster turns, and tags from the first row to the last";
  if (kind == "print scale") return "ground truth over a wider range";
  if (kind == "clock") return "faster and changing motion";
  if (kind.rfind("mount tilt", 0) == 0) return "turns about several axes";
  if (kind.rfind("mount", 0) == 0) return "turns about the other axes";
  if (kind == kWholeMap) return "ground truth or a tag that is known to stay";
  if (kind.rfind("world", 0) == 0) return "turns and way in all directions";
  if (kind.rfind("tags", 0) == 0) return "the same tags in more frames and from more sides";
  return "tags all over the image, to its corners";
}

Eigen::VectorXd MapScaleDirection(const CalibrationState& reference,
                                  const Eigen::VectorXd& prior_sigmas) {
  const CalibrationLayout layout = LayoutOf(reference);
  Eigen::VectorXd out = Eigen::VectorXd::Zero(layout.size());
  const std::vector<int> seen = FreeTags(layout, prior_sigmas);
  const Eigen::Vector3d mean = CentreOf(reference, seen);
  if (prior_sigmas(layout.scale()) > 0) out(layout.scale()) = 1;
  if (seen.size() < 2) return out;
  double squares = 0;
  for (const int i : seen) {
    const Eigen::Vector3d arm =
        reference.tags[static_cast<size_t>(i)].world_from_tag.translation() - mean;
    out.segment<3>(layout.tag(i) + 3) = arm;
    squares += arm.squaredNorm();
  }
  for (const int i : seen) out.segment<3>(layout.tag(i) + 3) /= squares;
  return out;
}

}  // namespace tagtwist::internal

#include "frontend/geometry/hand_eye_start.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

namespace tagtwist::internal {
namespace {

constexpr size_t kMostFrames = 200;                        // that a pair begins with
constexpr double kLeastTurnRad = 0.1, kMostTurnRad = 2.8;  // of a pair
constexpr double kAlikeRad = 0.1;  // by how much both turns of a pair may differ
constexpr size_t kLeastPairs = 10;
constexpr double kLeastShare = 0.5;   // of the pairs with a turn: those whose turns are alike
constexpr double kSecondAxis = 1e-2;  // of the pairs' mean square: a rotation left open is less

struct Pair {
  Pose cam, body;  // from the second frame's to the first one's
};

double RotationAngle(const Pose& pose) {
  const Eigen::Quaterniond q = pose.rotation();
  return 2 * std::atan2(q.vec().norm(), std::abs(q.w()));
}

// Pairs with a turn, as far as both paths show the same one.
std::vector<Pair> FindPairs(const std::vector<Pose>& cams, const std::vector<Pose>& bodies) {
  const size_t n = cams.size(), count = std::min(n, kMostFrames);
  std::vector<Pair> out;
  size_t turned = 0;
  for (size_t k = 0; k < count; ++k) {
    for (const size_t apart : {n / 3, n / 7, n / 50}) {
      const size_t i = k * n / count, j = i + apart;
      if (apart == 0 || j >= n) continue;
      const Pair pair{Inverse(cams[i]) * cams[j], Inverse(bodies[i]) * bodies[j]};
      const double turn = RotationAngle(pair.body);
      if (turn < kLeastTurnRad || turn > kMostTurnRad) continue;
      ++turned;
      if (std::abs(turn - RotationAngle(pair.cam)) < kAlikeRad) out.push_back(pair);
    }
  }
  const bool enough = out.size() >= kLeastPairs &&
                      static_cast<double>(out.size()) > kLeastShare * static_cast<double>(turned);
  return enough ? out : std::vector<Pair>();
}

// q * x as a matrix times x, and x * q.
Eigen::Matrix4d TimesOnRight(const Eigen::Quaterniond& q, bool q_first) {
  Eigen::Matrix4d out;
  for (int k = 0; k < 4; ++k) {
    const Eigen::Vector4d unit = Eigen::Vector4d::Unit(k);
    const Eigen::Quaterniond x(unit);
    out.col(k) = (q_first ? q * x : x * q).coeffs();
  }
  return out;
}

Eigen::Quaterniond Positive(Eigen::Quaterniond q) {
  if (q.w() < 0) q.coeffs() *= -1;
  return q;
}

std::optional<Eigen::Quaterniond> FindRotation(const std::vector<Pair>& pairs) {
  Eigen::Matrix4d sum = Eigen::Matrix4d::Zero();
  for (const Pair& pair : pairs) {
    const Eigen::Matrix4d d = TimesOnRight(Positive(pair.cam.rotation()), true) -
                              TimesOnRight(Positive(pair.body.rotation()), false);
    sum += d.transpose() * d;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> eigen(sum);
  if (!(eigen.eigenvalues()(1) > kSecondAxis * eigen.eigenvalues()(3))) return std::nullopt;
  const Eigen::Vector4d smallest = eigen.eigenvectors().col(0);
  return Eigen::Quaterniond(smallest).normalized();
}

Eigen::Vector3d FindTranslation(const std::vector<Pair>& pairs,
                                const Eigen::Quaterniond& rotation) {
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
  for (const Pair& pair : pairs) {
    const Eigen::Matrix3d a = pair.cam.rotation().toRotationMatrix() - Eigen::Matrix3d::Identity();
    information += a.transpose() * a;
    gradient += a.transpose() * (rotation * pair.body.translation() - pair.cam.translation());
  }
  Eigen::JacobiSVD<Eigen::Matrix3d> svd(information, Eigen::ComputeFullU | Eigen::ComputeFullV);
  svd.setThreshold(1e-4);
  return svd.solve(gradient);
}

// The mean over frames of where the map lies.
Pose FindWorld(const std::vector<Pose>& cams, const std::vector<Pose>& bodies,
               const Pose& cam_from_body) {
  Eigen::Matrix4d squares = Eigen::Matrix4d::Zero();
  Eigen::Vector3d place = Eigen::Vector3d::Zero();
  for (size_t i = 0; i < cams.size(); ++i) {
    const Pose at = bodies[i] * Inverse(cams[i] * cam_from_body);
    const Eigen::Vector4d q = at.rotation().coeffs();
    squares += q * q.transpose();
    place += at.translation() / static_cast<double>(cams.size());
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> eigen(squares);
  const Eigen::Vector4d mean = eigen.eigenvectors().col(3);
  return MakePose(Eigen::Quaterniond(mean).normalized(), place);
}

}  // namespace

std::optional<HandEyeStart> FindHandEyeStart(const std::vector<Pose>& world_from_cam,
                                             const std::vector<Pose>& truth_from_body) {
  const std::vector<Pair> pairs = FindPairs(world_from_cam, truth_from_body);
  if (pairs.empty()) return std::nullopt;
  const auto rotation = FindRotation(pairs);
  if (!rotation) return std::nullopt;
  HandEyeStart out;
  out.cam_from_body = MakePose(*rotation, FindTranslation(pairs, *rotation));
  out.truth_from_world = FindWorld(world_from_cam, truth_from_body, out.cam_from_body);
  return out;
}

}  // namespace tagtwist::internal

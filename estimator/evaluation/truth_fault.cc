#include "estimator/evaluation/truth_fault.h"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <cmath>

#include "estimator/evaluation/truth_match.h"
#include "frontend/base/format_text.h"

namespace tagtwist::internal {
namespace {

constexpr double kPlainM = 0.05, kPlainRad = 0.2;  // errors that no noise makes
constexpr double kExplained = 0.2;                 // what may be left of them

using Matches = std::vector<TruthMatch>;
using Found = std::optional<Fault>;

// Of positions and attitudes.
struct Rms {
  double position_m = 0, attitude_rad = 0;
};

template <typename PoseOfTruth, typename PoseOfEstimate>
Rms RmsOf(const Matches& matches, const PoseOfEstimate& estimate, const PoseOfTruth& truth) {
  Rms out;
  for (const TruthMatch& match : matches) {
    const Pose a = estimate(match.estimate.world_from_body), b = truth(match.truth.world_from_body);
    out.position_m += (a.translation() - b.translation()).squaredNorm();
    const double angle = a.rotation().angularDistance(b.rotation());
    out.attitude_rad += angle * angle;
  }
  const auto count = static_cast<double>(matches.size());
  return {std::sqrt(out.position_m / count), std::sqrt(out.attitude_rad / count)};
}

Pose Same(const Pose& pose) { return pose; }

// Positions of the truth as a similarity of the estimate's.
struct Similarity {
  double scale = 1;
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  double spread_m = 0;          // of the estimate: RMS distance from its middle
  double left = 1;              // RMS that the similarity leaves, over the truth's spread,
  double rigid_left = 1;        // and what it leaves without its scale
  bool fixes_rotation = false;  // positions are on no line
};

Similarity FitSimilarity(const Matches& matches) {
  Eigen::Vector3d mean_e = Eigen::Vector3d::Zero(), mean_t = mean_e;
  const auto count = static_cast<double>(matches.size());
  for (const TruthMatch& m : matches) {
    mean_e += m.estimate.world_from_body.translation() / count;
    mean_t += m.truth.world_from_body.translation() / count;
  }
  Eigen::Matrix3d cross = Eigen::Matrix3d::Zero();
  double squares_e = 0, squares_t = 0;
  for (const TruthMatch& m : matches) {
    const Eigen::Vector3d e = m.estimate.world_from_body.translation() - mean_e;
    const Eigen::Vector3d t = m.truth.world_from_body.translation() - mean_t;
    cross += t * e.transpose();
    squares_e += e.squaredNorm();
    squares_t += t.squaredNorm();
  }
  Similarity out;
  if (!(squares_e > 0 && squares_t > 0)) return out;
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(cross, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d sign = Eigen::Matrix3d::Identity();
  if ((svd.matrixU() * svd.matrixV().transpose()).determinant() < 0) sign(2, 2) = -1;
  out.rotation = svd.matrixU() * sign * svd.matrixV().transpose();
  const double common = (svd.singularValues().asDiagonal() * sign).trace();
  out.scale = common / squares_e;
  out.spread_m = std::sqrt(squares_e / count);
  out.left = std::sqrt(std::max(0.0, squares_t - out.scale * common) / squares_t);
  out.rigid_left = std::sqrt(std::max(0.0, squares_t + squares_e - 2 * common) / squares_t);
  out.fixes_rotation = svd.singularValues()(1) > 1e-3 * svd.singularValues()(0);
  return out;
}

Found FindUnit(const Similarity& fit) {
  constexpr double kSame = 0.05;
  if (!(fit.spread_m > 0.01 && fit.left < kSame)) return std::nullopt;
  for (const auto& [scale, unit] :
       {std::pair(1e3, "millimetres"), std::pair(1e2, "centimetres"), std::pair(1e-3, "kilometres"),
        std::pair(39.3701, "inches"), std::pair(3.28084, "feet")}) {
    if (!(std::abs(fit.scale / scale - 1) < kSame)) continue;
    return Fault{Format("The ground truth moves %.0f times as far as the estimate: it is in %s.",
                        fit.scale, unit),
                 "Give it in metres, or name the unit over its columns: x [mm]."};
  }
  return std::nullopt;
}

// "x, -z, y": along which of our axes those of the truth run; empty where not along any.
std::string AxesText(const Eigen::Matrix3d& truth_from_world) {
  constexpr double kAlong = 0.985;  // 10 degrees
  std::string out;
  for (int i = 0; i < 3; ++i) {
    int axis = 0;
    truth_from_world.row(i).cwiseAbs().maxCoeff(&axis);
    const double value = truth_from_world(i, axis);
    if (!(std::abs(value) > kAlong)) return "";
    out += std::string(i == 0 ? "" : ", ") + (value < 0 ? "-" : "") + "xyz"[axis];
  }
  return out;
}

Found FindWorld(const Similarity& fit, const Rms& given) {
  const double angle_rad = std::abs(Eigen::AngleAxisd(fit.rotation).angle());
  const bool explains = fit.left * fit.spread_m < kExplained * given.position_m;
  if (!(fit.fixes_rotation && given.position_m > kPlainM && explains && angle_rad > 0.3 &&
        std::abs(fit.scale - 1) < 0.1)) {
    return std::nullopt;
  }
  const std::string axes = AxesText(fit.rotation);
  const std::string is_y_up = axes == "x, z, -y" || axes == "-x, z, y" ? ": y is up there" : "";
  std::string fact = Format("The ground truth's world is turned against the map's by %.0f deg",
                            57.29578 * angle_rad);
  if (!axes.empty()) fact += "; its x, y, z run along our " + axes + is_y_up;
  return Fault{
      fact + Format(" (%.3f m are left of %.3f m).", fit.left * fit.spread_m, given.position_m),
      "Turn it, or compare with tagtwist_compare --align se3, which judges without it."};
}

// Positions that are larger by one factor: corners do not tell how large a map is as a whole.
Found FindScale(const Similarity& fit, const Rms& given) {
  constexpr double kLeast = 0.008, kMostTurnRad = 0.1;
  const bool explains = fit.left * fit.spread_m < kExplained * given.position_m &&
                        fit.left < kExplained * fit.rigid_left;
  const double angle_rad = std::abs(Eigen::AngleAxisd(fit.rotation).angle());
  const bool is_turned = fit.fixes_rotation && angle_rad > kMostTurnRad;
  if (!(fit.spread_m > 0.05 && explains && !is_turned && std::abs(fit.scale - 1) > kLeast)) {
    return std::nullopt;
  }
  const bool is_inches = std::abs(fit.scale / 0.0254 - 1) < 0.05;
  return Fault{Format("The ground truth moves %.4f times as far as the estimate (%.1f mm are left "
                      "of %.1f mm).",
                      fit.scale, 1e3 * fit.left * fit.spread_m, 1e3 * given.position_m),
               is_inches ? "The map is in inches: give it in metres."
                         : "Measure the map: if its sizes and gaps are all off by that factor (a "
                           "sheet printed to fit the page) multiply them by it; else truth's unit "
                           "or scale is another."};
}

// The quaternion whose w was taken for its x.
Pose WithWFirst(const Pose& pose) {
  const Eigen::Vector4d q = pose.rotation().coeffs();
  return MakePose(Eigen::Quaterniond(q(0), q(1), q(2), q(3)), pose.translation());
}
Pose Conjugated(const Pose& pose) {
  return MakePose(pose.rotation().conjugate(), pose.translation());
}

Found FindQuaternion(const Matches& matches, const Rms& given) {
  if (!(given.attitude_rad > kPlainRad)) return std::nullopt;
  const double w_first = RmsOf(matches, Same, WithWFirst).attitude_rad;
  const double inverse = RmsOf(matches, Same, Conjugated).attitude_rad;
  const double most = kExplained * given.attitude_rad;
  const std::string off =
      Format("The ground truth's attitudes are %.0f deg off while ", 57.29578 * given.attitude_rad);
  if (w_first < most && w_first < inverse) {
    return Fault{off + Format("%.1f deg are left when w is read first.", 57.29578 * w_first),
                 "Write qx qy qz qw, or names over the columns."};
  }
  if (inverse < most) {
    return Fault{off + Format("%.1f deg are left of their inverses.", 57.29578 * inverse),
                 "Quaternions are body to world here."};
  }
  return std::nullopt;
}

Found FindMount(const Matches& matches, const Pose& cam_from_body, const Rms& given) {
  const Pose body_from_cam = Inverse(cam_from_body);
  const auto otherwise = [&](const Pose& world_from_body) {
    return world_from_body * body_from_cam * body_from_cam;
  };
  const Rms inverted = RmsOf(matches, otherwise, Same);
  const bool position =
      given.position_m > 0.01 && inverted.position_m < kExplained * given.position_m;
  const bool attitude = inverted.attitude_rad < std::max(0.05, kExplained * given.attitude_rad);
  if (!(position && attitude)) return std::nullopt;
  return Fault{Format("With the mount inverted %.1f mm and %.1f deg are left of %.1f mm and "
                      "%.1f deg.",
                      1e3 * inverted.position_m, 57.29578 * inverted.attitude_rad,
                      1e3 * given.position_m, 57.29578 * given.attitude_rad),
               "cam_from_body maps a point from the body to the camera (Kalibr's T_cam_imu); "
               "T_imu_cam and T_BS are its inverses."};
}

double PositionRmsAt(const PoseSeries& series, const std::vector<TruthSample>& truth,
                     double offset_s, double max_gap_s, size_t least) {
  double squares = 0;
  size_t count = 0;
  for (const PoseSample& sample : series) {
    const auto at = InterpolateTruth(truth, sample.t_ns + std::llround(1e9 * offset_s), max_gap_s);
    if (!at) continue;
    squares +=
        (at->world_from_body.translation() - sample.world_from_body.translation()).squaredNorm();
    ++count;
  }
  return count < least ? INFINITY : std::sqrt(squares / static_cast<double>(count));
}

Found FindClock(const PoseSeries& estimate, const std::vector<TruthSample>& truth, double max_gap_s,
                const Rms& given) {
  constexpr double kMostS = 3, kStepS = 0.02;
  constexpr size_t kSamples = 150;
  if (!(given.position_m > 0.03)) return std::nullopt;
  PoseSeries some;
  const size_t step = std::max<size_t>(1, estimate.size() / kSamples);
  for (size_t i = 0; i < estimate.size(); i += step) some.push_back(estimate[i]);
  double best_s = 0, best_m = INFINITY;
  for (double offset_s = -kMostS; offset_s <= kMostS; offset_s += kStepS) {
    const double rms_m = PositionRmsAt(some, truth, offset_s, max_gap_s, some.size() / 2);
    if (rms_m < best_m) {
      best_m = rms_m;
      best_s = offset_s;
    }
  }
  for (double half = kStepS / 2; half > 1e-4; half /= 2) {
    for (const double offset_s : {best_s - half, best_s + half}) {
      const double rms_m = PositionRmsAt(some, truth, offset_s, max_gap_s, some.size() / 2);
      if (rms_m < best_m) {
        best_m = rms_m;
        best_s = offset_s;
      }
    }
  }
  if (!(best_m < kExplained * given.position_m)) return std::nullopt;
  return Fault{Format("The ground truth's clock is %.3f s %s: %.1f mm are left of %.1f mm when "
                      "it is moved.",
                      std::abs(best_s), best_s > 0 ? "ahead" : "behind", 1e3 * best_m,
                      1e3 * given.position_m),
               "Bring both to one clock, or compare with tagtwist_compare --time_offset "
               "estimate."};
}

}  // namespace

std::optional<Fault> FindTruthFault(const PoseSeries& estimate,
                                    const std::vector<TruthSample>& truth,
                                    const Pose& cam_from_body, double max_gap_s) {
  const Matches matches = MatchTruth(estimate, truth, 0, max_gap_s);
  if (matches.size() < 10) return std::nullopt;
  const Rms given = RmsOf(matches, Same, Same);
  if (!(given.position_m > 0.01 || given.attitude_rad > kPlainRad)) return std::nullopt;
  const Similarity fit = FitSimilarity(matches);
  if (auto unit = FindUnit(fit)) return unit;
  if (auto mount = FindMount(matches, cam_from_body, given)) return mount;
  if (auto quaternion = FindQuaternion(matches, given)) return quaternion;
  if (auto world = FindWorld(fit, given)) return world;
  if (auto scale = FindScale(fit, given)) return scale;
  return FindClock(estimate, truth, max_gap_s, given);
}

}  // namespace tagtwist::internal

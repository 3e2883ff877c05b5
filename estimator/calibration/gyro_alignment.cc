#include "estimator/calibration/gyro_alignment.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "frontend/base/format_text.h"
#include "frontend/base/statistics/robust.h"
#include "frontend/types/so3.h"

namespace tagtwist::internal {
namespace {

constexpr double kLongestTurnS = 0.3, kLongestGapS = 0.1;  // between frames, between samples
constexpr int kFewestTurns = 20;

// The gyro's attitude from its first sample on, rates straight between samples.
class GyroPath {
 public:
  explicit GyroPath(std::vector<ImuSample> imu) : imu_(std::move(imu)) {
    for (size_t i = 0; i < imu_.size(); ++i) {
      if (i == 0) {
        attitudes_.push_back(Eigen::Quaterniond::Identity());
        continue;
      }
      const Eigen::Vector3d rate = 0.5 * (imu_[i - 1].gyro_radps + imu_[i].gyro_radps);
      const double dt_s = ToSeconds(imu_[i].t_ns - imu_[i - 1].t_ns);
      attitudes_.push_back((attitudes_.back() * ExpSo3(dt_s * rate)).normalized());
    }
  }

  std::optional<Eigen::Quaterniond> At(int64_t t_ns) const {
    const auto after =
        std::lower_bound(imu_.begin(), imu_.end(), t_ns,
                         [](const ImuSample& sample, int64_t t) { return sample.t_ns < t; });
    if (after == imu_.begin() || after == imu_.end()) return std::nullopt;
    const ImuSample &a = *(after - 1), &b = *after;
    const double gap_s = ToSeconds(b.t_ns - a.t_ns);
    if (!(gap_s <= kLongestGapS)) return std::nullopt;
    const double dt_s = ToSeconds(t_ns - a.t_ns), w = 0.5 * dt_s / gap_s;
    const Eigen::Vector3d rate = (1 - w) * a.gyro_radps + w * b.gyro_radps;  // mean over dt
    return attitudes_[static_cast<size_t>(after - 1 - imu_.begin())] * ExpSo3(dt_s * rate);
  }

  // From one time to another, as a rotation vector.
  std::optional<Eigen::Vector3d> Turn(int64_t from_ns, int64_t to_ns) const {
    const auto from = At(from_ns), to = At(to_ns);
    if (!from || !to) return std::nullopt;
    return LogSo3(from->conjugate() * *to);
  }

 private:
  std::vector<ImuSample> imu_;
  std::vector<Eigen::Quaterniond> attitudes_;
};

// Between two successive frames.
struct CameraTurn {
  int64_t from_ns = 0, to_ns = 0;
  Eigen::Vector3d turn;
  double dt_s = 0;
  Eigen::Matrix3d world_from_cam;  // at its end
};

std::vector<CameraTurn> Turns(const std::vector<TimedRotation>& camera) {
  std::vector<CameraTurn> out;
  for (size_t i = 1; i < camera.size(); ++i) {
    const TimedRotation &a = camera[i - 1], &b = camera[i];
    const double dt_s = ToSeconds(b.t_ns - a.t_ns);
    if (!(dt_s > 0 && dt_s <= kLongestTurnS)) continue;
    out.push_back({a.t_ns, b.t_ns, LogSo3(a.world_from_cam.conjugate() * b.world_from_cam), dt_s,
                   b.world_from_cam.toRotationMatrix()});
  }
  return out;
}

// A turn against the gyro, linear in the seven unknowns; in the world, where a frame's error enters
// the next turn as it left this one.
struct TurnMisfit {
  int64_t from_ns = 0, to_ns = 0;
  Eigen::Vector3d misfit;
  Eigen::Matrix<double, 3, 7> by_unknowns;
};

std::vector<TurnMisfit> Linearize(const std::vector<CameraTurn>& turns, const GyroPath& path,
                                  const GyroAlignment& at) {
  constexpr int64_t kStepNs = 5'000'000;
  const int64_t offset_ns = std::llround(1e9 * at.time_offset_s);
  const Eigen::Matrix3d rotation = at.cam_from_imu.toRotationMatrix();
  std::vector<TurnMisfit> out;
  for (const CameraTurn& turn : turns) {
    const int64_t from_ns = turn.from_ns + offset_ns, to_ns = turn.to_ns + offset_ns;
    const auto now = path.Turn(from_ns, to_ns);
    const auto before = path.Turn(from_ns - kStepNs, to_ns - kStepNs);
    const auto after = path.Turn(from_ns + kStepNs, to_ns + kStepNs);
    if (!now || !before || !after) continue;
    const Eigen::Vector3d gyro = *now - turn.dt_s * at.bias_radps, predicted = rotation * gyro;
    TurnMisfit misfit{turn.from_ns, turn.to_ns, {}, {}};
    misfit.misfit = turn.world_from_cam * LogSo3(ExpSo3(-predicted) * ExpSo3(turn.turn));
    Eigen::Matrix<double, 3, 7> by_unknowns;  // of the predicted turn
    by_unknowns << -rotation * Hat(gyro), -turn.dt_s * rotation,
        rotation * (*after - *before) / ToSeconds(2 * kStepNs);
    misfit.by_unknowns =
        -turn.world_from_cam * RightJacobianInverseSo3(predicted).inverse() * by_unknowns;
    out.push_back(misfit);
  }
  return out;
}

// The rotation of least squares (Kabsch 1976); nullopt where the turns leave it open.
std::optional<Eigen::Quaterniond> RotationBetween(const std::vector<CameraTurn>& turns,
                                                  const GyroPath& path, int64_t offset_ns,
                                                  double* misfit) {
  Eigen::Matrix3d products = Eigen::Matrix3d::Zero();
  double squares = 0;
  int n = 0;
  for (const CameraTurn& turn : turns) {
    const auto gyro = path.Turn(turn.from_ns + offset_ns, turn.to_ns + offset_ns);
    if (!gyro) continue;
    products += turn.turn * gyro->transpose();
    squares += turn.turn.squaredNorm() + gyro->squaredNorm();
    ++n;
  }
  constexpr double kLeastRatio = 1e-3;  // of the second axis to the first
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(products, Eigen::ComputeFullU | Eigen::ComputeFullV);
  if (n < kFewestTurns || !(svd.singularValues()(1) > kLeastRatio * svd.singularValues()(0))) {
    return std::nullopt;
  }
  Eigen::Vector3d signs(1, 1, 1);
  signs(2) = (svd.matrixU() * svd.matrixV().transpose()).determinant();
  *misfit = (squares - 2 * signs.dot(svd.singularValues())) / n;
  return Eigen::Quaterniond(svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose());
}

struct GyroNormals {
  Eigen::Matrix<double, 7, 7> information = Eigen::Matrix<double, 7, 7>::Zero();
  Eigen::Matrix<double, 7, 1> gradient = Eigen::Matrix<double, 7, 1>::Zero();
  double squares = 0, rows = 0;
  double log_pivots = 0;  // half the logarithm of the correlation's determinant

  // Minus the logarithm of the restricted likelihood (Patterson and Thompson 1971), the scale at
  // its best: what the unknowns take up does not count for less noise.
  double Misfit() const {
    const Eigen::Matrix<double, 7, 1> pivots = information.ldlt().vectorD();
    return 0.5 * (rows - 7) * std::log(squares / (rows - 7)) + log_pivots +
           0.5 * pivots.array().log().sum();
  }
};

// Whitened by the Cholesky factor of the tridiagonal correlation, turn after turn, then robust.
GyroNormals Accumulate(const std::vector<TurnMisfit>& misfits, const GyroAlignment& at) {
  constexpr double kHuber = 3;  // in sigmas of a turn
  const double delta = HuberDelta(kHuber * at.turn_sigma_rad, 3);
  GyroNormals out;
  double pivot = 1;
  Eigen::Vector3d last_misfit = Eigen::Vector3d::Zero();
  Eigen::Matrix<double, 3, 7> last = Eigen::Matrix<double, 3, 7>::Zero();
  for (size_t i = 0; i < misfits.size(); ++i) {
    const bool chained = i > 0 && misfits[i - 1].to_ns == misfits[i].from_ns;
    const double below = chained ? at.turn_correlation / pivot : 0;
    pivot = std::sqrt(1 - below * below);
    last_misfit = ((misfits[i].misfit - below * last_misfit) / pivot).eval();
    last = ((misfits[i].by_unknowns - below * last) / pivot).eval();
    const double weight = Huber(last_misfit.squaredNorm(), delta).weight;
    out.information += weight * last.transpose() * last;
    out.gradient += weight * last.transpose() * last_misfit;
    out.squares += weight * last_misfit.squaredNorm();
    out.rows += 3;
    out.log_pivots += 3 * std::log(pivot);
  }
  return out;
}

// The normal equations under the likeliest correlation. Errors of a frame alone give -0.5, the
// gyro's noise 0; no nearer to -0.5 than a few hundred turns can tell.
GyroNormals LearnCorrelation(const std::vector<TurnMisfit>& misfits, GyroAlignment* at) {
  std::optional<GyroNormals> best;
  for (const double correlation :
       {0.4, 0.2, 0.0, -0.2, -0.35, -0.45, -0.48, -0.49, -0.495, -0.498, -0.499, -0.4995}) {
    GyroAlignment tried = *at;
    tried.turn_correlation = correlation;
    const GyroNormals normals = Accumulate(misfits, tried);
    if (best && !(normals.Misfit() < best->Misfit())) continue;
    best = normals;
    at->turn_correlation = correlation;
  }
  return *best;
}

}  // namespace

Result<GyroAlignment> AlignGyro(const std::vector<TimedRotation>& camera,
                                const std::vector<ImuSample>& imu, double max_offset_s) {
  constexpr int kRounds = 10;
  constexpr double kGridS = 0.01;
  const std::vector<CameraTurn> turns = Turns(camera);
  const GyroPath path(imu);
  GyroAlignment out;
  double least = 0;
  bool found = false;
  const int steps = static_cast<int>(std::lround(max_offset_s / kGridS));
  for (int k = -steps; k <= steps; ++k) {
    double misfit = 0;
    const auto rotation = RotationBetween(turns, path, std::llround(1e9 * kGridS * k), &misfit);
    if (!rotation || (found && !(misfit < least))) continue;
    found = true;
    least = misfit;
    out.cam_from_imu = *rotation;
    out.time_offset_s = kGridS * k;
  }
  if (!found) return Error{"the gyro's mount stays open: too few turns, or about one axis alone"};
  for (int round = 0; round < kRounds; ++round) {
    const auto misfits = Linearize(turns, path, out);
    if (static_cast<int>(misfits.size()) < kFewestTurns) {
      return Error{"the gyro's mount stays open: its samples miss the frames"};
    }
    out.turns = static_cast<int>(misfits.size());
    const GyroNormals normals = LearnCorrelation(misfits, &out);
    const Eigen::LDLT<Eigen::Matrix<double, 7, 7>> ldlt(normals.information);
    out.turn_sigma_rad = std::sqrt(normals.squares / (normals.rows - 7));
    out.covariance = out.turn_sigma_rad * out.turn_sigma_rad *
                     ldlt.solve(Eigen::Matrix<double, 7, 7>::Identity());
    const Eigen::Matrix<double, 7, 1> step = -ldlt.solve(normals.gradient);
    out.cam_from_imu = (out.cam_from_imu * ExpSo3(step.head<3>())).normalized();
    out.bias_radps += step.segment<3>(3);
    out.time_offset_s = std::clamp(out.time_offset_s + step(6), -max_offset_s, max_offset_s);
  }
  return out;
}

std::string GyroText(const GyroAlignment& g) {
  const auto sigma = [&](int i) { return std::sqrt(g.covariance(i, i)); };
  const double mount_rad = std::sqrt(g.covariance.topLeftCorner<3, 3>().trace());
  return Format(
      "gyro: cam_from_imu quaternion_xyzw [%.6f, %.6f, %.6f, %.6f] +- %.3f deg; stamps + %.1f +- "
      "%.1f ms are its time; bias %+.4f %+.4f %+.4f +- %.4f rad/s; %d turns miss by %.3f deg an "
      "axis",
      g.cam_from_imu.x(), g.cam_from_imu.y(), g.cam_from_imu.z(), g.cam_from_imu.w(),
      mount_rad * 180 / M_PI, 1e3 * g.time_offset_s, 1e3 * sigma(6), g.bias_radps.x(),
      g.bias_radps.y(), g.bias_radps.z(), std::max({sigma(3), sigma(4), sigma(5)}), g.turns,
      g.turn_sigma_rad * 180 / M_PI);
}

}  // namespace tagtwist::internal

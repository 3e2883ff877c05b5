#include "estimator/motion/unfollowed_motion.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "estimator/graph/pose_bound.h"

namespace tagtwist::internal {
namespace {

constexpr double kMostSquared = 12;    // of r in its noise: one frame alone is no scatter
constexpr double kMostAmongTags = 4;   // of what no pose explains, a degree of freedom
constexpr double kLoosestRad = 0.035;  // an attitude that is known worse has errors of other kinds
constexpr double kLeastFrames = 24;
constexpr int64_t kLongestPairNs = 250'000'000;

// What is added of an error in x and in its rate.
struct Unfollowed {
  Eigen::Matrix3d of_x = Eigen::Matrix3d::Zero(), of_rate = Eigen::Matrix3d::Zero();
};

// A part in multiples of its noise.
class Whitened {
 public:
  // `noise` is that of the tags in multiples of what was taken for it.
  Whitened(const UnfollowedPart& part, double noise) : part_(part) {
    if (!(part.frames >= kLeastFrames) || !(part.pairs >= kLeastFrames)) return;
    const Eigen::LLT<Eigen::Matrix3d> llt(noise / part.weight * part.noise);
    is_known_ = llt.info() == Eigen::Success;
    if (!is_known_) return;
    const auto whitened = [&](const Eigen::Matrix3d& sum, double weight) -> Eigen::Matrix3d {
      const Eigen::Matrix3d half = llt.matrixL().solve(sum / weight);
      return llt.matrixL().solve(half.transpose());
    };
    root_ = llt.matrixL();
    next_ = whitened(part.next, part.weight_of_pairs);
    square_ = whitened(part.square, part.weight);
  }

  // Beyond what chance leaves of the largest of three directions, once in some thousand times.
  bool StandsOut() const {
    if (!is_known_) return false;
    const double n = part_.AsMany();
    return LargestOf(square_) > std::pow(1 + std::sqrt(3 / n), 2) + 4 / std::sqrt(n) ||
           LargestOf(next_) > 4.75 / std::sqrt(n);
  }

  Unfollowed Added() const {
    Unfollowed out;
    if (!is_known_) return out;
    const double chance = std::sqrt(2 / part_.AsMany());
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(square_);
    for (int i = 0; i < 3; ++i) {
      const Eigen::Vector3d along = eigen.eigenvectors().col(i), direction = root_ * along;
      const double more = std::max(eigen.eigenvalues()(i) - 1, 0.0) + chance,
                   change = 2 * std::max(more - std::max(along.dot(next_ * along), 0.0), chance);
      out.of_x += more * direction * direction.transpose();
      out.of_rate += change * part_.pairs / part_.dt2_s2 * direction * direction.transpose();
    }
    return out;
  }

 private:
  static double LargestOf(const Eigen::Matrix3d& symmetric) {
    Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen;
    return eigen.computeDirect(symmetric, Eigen::EigenvaluesOnly).eigenvalues()(2);
  }

  const UnfollowedPart& part_;
  bool is_known_ = false;
  Eigen::Matrix3d root_ = Eigen::Matrix3d::Zero(), square_ = Eigen::Matrix3d::Zero(),
                  next_ = Eigen::Matrix3d::Zero();
};

Eigen::Vector3d Clipped(const Eigen::Vector3d& r, const Eigen::Matrix3d& noise) {
  const double squared = r.dot(noise.llt().solve(r));
  return squared > kMostSquared ? Eigen::Vector3d(std::sqrt(kMostSquared / squared) * r) : r;
}

void AddFrame(const Eigen::Vector3d& r, const Eigen::Matrix3d& noise, UnfollowedPart* part) {
  const double weight = 1 / noise.trace();
  part->frames += 1;
  part->squares += 1;
  part->weight += weight;
  part->square += weight * r * r.transpose();
  part->noise += weight * noise;
}

void AddPair(const Eigen::Vector3d& before, const Eigen::Vector3d& r, const Eigen::Matrix3d& noise,
             double dt_s, UnfollowedPart* part) {
  const double weight = 1 / noise.trace();
  const Eigen::Matrix3d product = before * r.transpose();
  part->pairs += 1;
  part->weight_of_pairs += weight;
  part->next += 0.5 * weight * (product + product.transpose());
  part->dt2_s2 += dt_s * dt_s;
}

}  // namespace

UnfollowedPart& UnfollowedPart::operator+=(const UnfollowedPart& other) {
  frames += other.frames;
  squares += other.squares;
  weight += other.weight;
  pairs += other.pairs;
  weight_of_pairs += other.weight_of_pairs;
  dt2_s2 += other.dt2_s2;
  square += other.square;
  noise += other.noise;
  next += other.next;
  return *this;
}

UnfollowedPart& UnfollowedPart::operator*=(double by) {
  for (double* number : {&frames, &weight, &pairs, &weight_of_pairs, &dt2_s2}) *number *= by;
  squares *= by * by;
  for (Eigen::Matrix3d* sum : {&square, &noise, &next}) *sum *= by;
  return *this;
}

std::optional<ShownPose> ShownBy(const EstimatorSetup& setup, double corner_sigma_px, int64_t t_ns,
                                 const Pose& state, const std::vector<TagDetection>& tags) {
  if (tags.size() < 2) return std::nullopt;
  const auto told = InformationOfTags(setup, corner_sigma_px, state, tags);
  const auto noise = told ? InverseInformation(told->information) : std::nullopt;
  if (!noise || !(noise->topLeftCorner<3, 3>().trace() < kLoosestRad * kLoosestRad)) {
    return std::nullopt;
  }
  const PoseStep step = *noise * told->score;
  if (!step.allFinite()) return std::nullopt;
  const double freedom = 8 * static_cast<double>(tags.size()) - 6;
  const double among_tags =
      std::clamp(told->squared - told->score.dot(step), 0.0, kMostAmongTags * freedom);
  return ShownPose{t_ns, step, *noise, among_tags, freedom};
}

void UnfollowedMotion::Add(const ShownPose& shown) {
  freedom_ += shown.freedom;
  among_tags_ += shown.among_tags;
  const bool goes_on =
      last_ && shown.t_ns > last_->t_ns && shown.t_ns - last_->t_ns < kLongestPairNs;
  ShownPose now = shown;
  const auto add = [&](int first, UnfollowedPart* part) {
    const Eigen::Matrix3d noise = shown.noise.block<3, 3>(first, first);
    const Eigen::Vector3d r = Clipped(shown.step.segment<3>(first), noise);
    now.step.segment<3>(first) = r;
    AddFrame(r, noise, part);
    if (!goes_on) return;
    AddPair(last_->step.segment<3>(first), r, noise, ToSeconds(shown.t_ns - last_->t_ns), part);
  };
  add(0, &attitude_);
  add(3, &position_);
  last_ = now;
}

void UnfollowedMotion::Fade(double by) {
  among_tags_ *= by;
  freedom_ *= by;
  attitude_ *= by;
  position_ *= by;
}

UnfollowedMotion& UnfollowedMotion::operator+=(const UnfollowedMotion& other) {
  among_tags_ += other.among_tags_;
  freedom_ += other.freedom_;
  attitude_ += other.attitude_;
  position_ += other.position_;
  return *this;
}

StateCovariance UnfollowedMotion::Covariance(const MotionParts& of) const {
  StateCovariance out = StateCovariance::Zero();
  const double noise = among_tags_ / freedom_;
  const Whitened of_attitude(attitude_, noise), of_position(position_, noise);
  if (!(of.angular && of_attitude.StandsOut()) && !(of.linear && of_position.StandsOut())) {
    return out;
  }
  const Unfollowed attitude = of.angular ? of_attitude.Added() : Unfollowed(),
                   position = of.linear ? of_position.Added() : Unfollowed();
  out.block<3, 3>(0, 0) = attitude.of_x;
  out.block<3, 3>(3, 3) = position.of_x;
  out.block<3, 3>(6, 6) = position.of_rate;
  out.block<3, 3>(9, 9) = attitude.of_rate;
  return out;
}

void UnfollowedByWindow::Add(const ShownPose& shown, const MotionParts& of) {
  constexpr double kNear = 60, kWide = 240;  // frames
  near_.Fade(1 - 1 / kNear);
  wide_.Fade(1 - 1 / kWide);
  near_.Add(shown);
  wide_.Add(shown);
  covariance_ = near_.Covariance(of);
  if (!(covariance_.trace() > 0)) covariance_ = wide_.Covariance(of);
}

// Stretch by stretch, each with its neighbours, or, where these show nothing, with more of them.
void AddUnfollowedMotion(const EstimatorSetup& setup, double corner_sigma_px, const MotionParts& of,
                         const std::vector<GraphState>& states,
                         const std::vector<GraphFrame>& frames,
                         std::vector<StateCovariance>* covariances) {
  constexpr size_t kStretch = 40;
  std::vector<UnfollowedMotion> stretches((states.size() + kStretch - 1) / kStretch);
  setup.for_ranges(stretches.size(), [&](size_t first, size_t last) {
    for (size_t k = first * kStretch; k < std::min(last * kStretch, states.size()); ++k) {
      const auto shown =
          ShownBy(setup, corner_sigma_px, states[k].t_ns, states[k].pose, frames[k].tags);
      if (shown) stretches[k / kStretch].Add(*shown);
    }
  });
  for (size_t i = 0; i < stretches.size(); ++i) {
    const auto within = [&](size_t reach) {
      UnfollowedMotion around;
      for (size_t j = i - std::min(i, reach); j < std::min(i + reach + 1, stretches.size()); ++j) {
        around += stretches[j];
      }
      return around.Covariance(of);
    };
    StateCovariance more = within(1);
    if (!(more.trace() > 0)) more = within(6);
    const size_t end = std::min((i + 1) * kStretch, states.size());
    for (size_t k = i * kStretch; k < end; ++k) (*covariances)[k] += more;
  }
}

}  // namespace tagtwist::internal

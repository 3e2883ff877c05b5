#include "estimator/motion/turn_or_move.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "estimator/graph/pose_bound.h"
#include "frontend/base/format_text.h"
#include "frontend/base/statistics/quantile.h"
#include "frontend/types/so3.h"

namespace tagtwist::internal {
namespace {

double DistanceToTags(const EstimatorSetup& setup, const GraphFrame& frame) {
  double sum = 0;
  for (const TagDetection& tag : frame.tags) {
    const Eigen::Vector3d tag_in_world = setup.map.Find(tag.id)->world_from_tag.translation();
    sum += (tag_in_world - frame.state.world_from_body.translation()).norm();
  }
  return sum / static_cast<double>(frame.tags.size());
}

// Standard deviation of the position along which a frame's tags leave it open most [m].
double MostOpen(const EstimatorSetup& setup, const NoiseModel& noise, const GraphFrame& frame) {
  const auto bound =
      PoseBound(setup, noise.corner_sigma_px, frame.state.world_from_body, frame.tags);
  if (!bound) return std::numeric_limits<double>::infinity();
  const Eigen::Matrix3d of_position = bound->bottomRightCorner<3, 3>();
  return std::sqrt(
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(of_position, Eigen::EigenvaluesOnly)
          .eigenvalues()
          .maxCoeff());
}

// Squares of what a stretch of frames moved and turned by, about its mean: [m^2], [rad^2].
struct Swing {
  double moved = 0, turned = 0;
};

Swing SwingOf(const std::vector<const GraphFrame*>& stretch) {
  const auto n = static_cast<double>(stretch.size());
  const Pose& middle = stretch[stretch.size() / 2]->state.world_from_body;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero(), sum_turn = sum;
  Swing squares;
  for (const GraphFrame* frame : stretch) {
    const Pose& pose = frame->state.world_from_body;
    const Eigen::Vector3d move = pose.translation() - middle.translation();
    const Eigen::Vector3d turn = LogSo3(middle.rotation().conjugate() * pose.rotation());
    sum += move;
    sum_turn += turn;
    squares.moved += move.squaredNorm() / n;
    squares.turned += turn.squaredNorm() / n;
  }
  return {squares.moved - (sum / n).squaredNorm(), squares.turned - (sum_turn / n).squaredNorm()};
}

}  // namespace

double LeverOfUntold(const EstimatorSetup& setup, const NoiseModel& noise,
                     const std::vector<GraphFrame>& frames) {
  constexpr int64_t kStretchNs = 10'000'000'000;
  constexpr double kOpenShare = 0.5, kOpenRad = 0.0087;
  constexpr size_t kLooks = 200;
  if (setup.mounted_on != MountedOn::kBody) return 0;  // a board turns about itself
  std::vector<const GraphFrame*> with_tags;
  for (const GraphFrame& frame : frames) {
    if (!frame.tags.empty()) with_tags.push_back(&frame);
  }
  if (with_tags.empty()) return 0;
  std::vector<double> open_m, distances_m;
  for (size_t k = 0; k < with_tags.size(); k += 1 + with_tags.size() / kLooks) {
    open_m.push_back(MostOpen(setup, noise, *with_tags[k]));
    distances_m.push_back(DistanceToTags(setup, *with_tags[k]));
  }
  const double sigma_m = Quantile(open_m, 0.5), lever_m = Quantile(distances_m, 0.5);
  if (!(sigma_m > kOpenRad * lever_m)) return 0;
  std::vector<double> swings_m;
  for (auto first = with_tags.begin(); first != with_tags.end();) {
    const auto last = std::find_if(first, with_tags.end(), [&](const GraphFrame* frame) {
      return frame->t_ns - (*first)->t_ns > kStretchNs;
    });
    const Swing swing = SwingOf({first, last});
    swings_m.push_back(std::sqrt(swing.moved + lever_m * lever_m * swing.turned));
    first = last;
  }
  return sigma_m > kOpenShare * Quantile(swings_m, 0.5) ? lever_m : 0;
}

std::string TextOfUntold(double lever_m) {
  return Format(
      "in most frames the tags, some %.1f m away, hardly tell a body that turns from one that "
      "moves: either is taken to be as likely, and the sigmas hold what that leaves open",
      lever_m);
}

}  // namespace tagtwist::internal

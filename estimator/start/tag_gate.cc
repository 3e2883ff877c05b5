#include "estimator/start/tag_gate.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "frontend/base/statistics/quantile.h"
#include "frontend/geometry/quad_shape.h"

namespace tagtwist::internal {
namespace {

constexpr size_t kLatest = 200;       // quads that are learned from
constexpr size_t kLeastToLearn = 20;  // fewer tell no deviation
constexpr double kUsualSigmaPx = 1;
constexpr double kLeastSigmaPx = 0.1;
constexpr double kSigmas = 8;
// Of the side: what lens, bent paper and motion within an image do to a square.
constexpr double kShapeOfSide = 0.03;
constexpr double kMedianOfRayleigh = 1.1774;
// The approximation is within that factor of the distance where that matters.
constexpr double kSurelyNear = 0.4;

double MeanSidePx(const TagDetection& tag) {
  double sum = 0;
  for (size_t c = 0; c < 4; ++c) sum += (tag.corners[(c + 1) % 4] - tag.corners[c]).norm();
  return sum / 4;
}

}  // namespace

TagGate::TagGate(TagMap map, Camera camera) : map_(std::move(map)), camera_(std::move(camera)) {}

void TagGate::Learn(double misfit_px) {
  if (misfits_px_.size() < kLatest) {
    misfits_px_.push_back(misfit_px);
  } else {
    misfits_px_[next_] = misfit_px;
    next_ = (next_ + 1) % kLatest;
  }
}

double TagGate::SigmaPx() const {
  if (misfits_px_.size() < kLeastToLearn) return kUsualSigmaPx;
  return std::max(kLeastSigmaPx, Quantile(misfits_px_, 0.5) / kMedianOfRayleigh);
}

bool TagGate::Passes(const TagDetection& tag, double sigma_px) const {
  const QuadTurn turn = TurnOf(tag.corners);
  if (turn == QuadTurn::kClockwise || turn == QuadTurn::kNone) return false;
  const Tag* in_map = map_.Find(tag.id);
  double variance = sigma_px * sigma_px;
  if (tag.covariance) variance += tag.covariance->diagonal().maxCoeff();
  double limit_px = std::max(kSigmas * std::sqrt(variance), kShapeOfSide * MeanSidePx(tag));
  if (in_map != nullptr) limit_px += std::abs(in_map->bend_m) / in_map->size_m * MeanSidePx(tag);
  const auto about = ApproximateSquareMisfitPx(tag.corners, camera_);
  if (about && *about < kSurelyNear * limit_px) return true;
  const auto misfit_px = SquareMisfitPx(tag.corners, camera_);
  return misfit_px && *misfit_px < limit_px;
}

std::vector<TagDetection> TagGate::TakeRefused(std::vector<TagDetection>* tags) {
  const double sigma_px = SigmaPx();
  std::vector<TagDetection> kept, refused;
  for (const TagDetection& tag : *tags) {
    (Passes(tag, sigma_px) ? kept : refused).push_back(tag);
    if (TurnOf(tag.corners) != QuadTurn::kAnticlockwise) continue;
    if (const auto misfit_px = ApproximateSquareMisfitPx(tag.corners, camera_)) Learn(*misfit_px);
  }
  *tags = std::move(kept);
  return refused;
}

}  // namespace tagtwist::internal

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

TagGate::TagGate(TagMap map, std::vector<Camera> cameras)
    : map_(std::move(map)), cameras_(std::move(cameras)) {}

TagGate::TagGate(TagMap map, Camera camera)
    : TagGate(std::move(map), std::vector<Camera>{std::move(camera)}) {}

void TagGate::Learn(double misfit_px) {
  ++learned_;
  if (misfits_px_.size() < kLatest) {
    misfits_px_.push_back(misfit_px);
  } else {
    misfits_px_[next_] = misfit_px;
    next_ = (next_ + 1) % kLatest;
  }
}

// A median of so many changes little with a frame.
double TagGate::SigmaPx() {
  constexpr size_t kFew = kLatest / 10;
  if (misfits_px_.size() < kLeastToLearn) return kUsualSigmaPx;
  if (!sigma_px_ || learned_ >= kFew) {
    sigma_px_ = std::max(kLeastSigmaPx, Quantile(misfits_px_, 0.5) / kMedianOfRayleigh);
    learned_ = 0;
  }
  return *sigma_px_;
}

bool TagGate::Passes(const TagDetection& tag, const std::optional<double>& about_px,
                     double sigma_px) const {
  const Tag* in_map = map_.Find(tag.id);
  double variance = sigma_px * sigma_px;
  if (tag.covariance) variance += tag.covariance->diagonal().maxCoeff();
  double limit_px = std::max(kSigmas * std::sqrt(variance), kShapeOfSide * MeanSidePx(tag));
  if (in_map != nullptr) limit_px += std::abs(in_map->bend_m) / in_map->size_m * MeanSidePx(tag);
  if (about_px && *about_px < kSurelyNear * limit_px) return true;
  const auto misfit_px = SquareMisfitPx(tag.corners, cameras_.at(static_cast<size_t>(tag.camera)));
  return misfit_px && *misfit_px < limit_px;
}

std::vector<TagDetection> TagGate::TakeRefused(std::vector<TagDetection>* tags) {
  const double sigma_px = SigmaPx();
  std::vector<TagDetection> kept, refused;
  kept.reserve(tags->size());
  for (TagDetection& tag : *tags) {
    const QuadTurn turn = TurnOf(tag.corners);
    const bool may_be_one = turn != QuadTurn::kClockwise && turn != QuadTurn::kNone;
    std::optional<double> about_px;
    if (may_be_one) {
      about_px =
          ApproximateSquareMisfitPx(tag.corners, cameras_.at(static_cast<size_t>(tag.camera)));
    }
    const bool passes = may_be_one && Passes(tag, about_px, sigma_px);
    (passes ? kept : refused).push_back(std::move(tag));
    if (turn == QuadTurn::kAnticlockwise && about_px) Learn(*about_px);
  }
  *tags = std::move(kept);
  return refused;
}

}  // namespace tagtwist::internal

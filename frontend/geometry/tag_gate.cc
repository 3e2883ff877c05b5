#include "frontend/geometry/tag_gate.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "frontend/base/statistics/quantile.h"
#include "frontend/geometry/quad_shape.h"
#include "frontend/geometry/tag_outline.h"

namespace tagtwist::internal {
namespace {

constexpr size_t kLatest = 200;       // quads that are learned from
constexpr size_t kLeastToLearn = 20;  // fewer tell no deviation
constexpr double kUsualSigmaPx = 1;
constexpr double kLeastSigmaPx = 0.1;
constexpr double kRefusedSigmas = 8;
// Of the side: what lens, bent paper and motion within an image do to a square.
constexpr double kShapeOfSide = 0.03;
constexpr double kMedianOfRayleigh = 1.1774;
// The approximation is within that factor of the distance where that matters.
constexpr double kSurelyNear = 0.4;

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
    sigma_px_ = Quantile(misfits_px_, 0.5) / kMedianOfRayleigh;
    learned_ = 0;
  }
  return *sigma_px_;
}

bool TagGate::Passes(const TagDetection& tag, const std::optional<double>& about_px,
                     double sigma_px) const {
  const Tag* in_map = map_.Find(tag.id);
  double variance = std::pow(std::max(kLeastSigmaPx, sigma_px), 2);
  if (tag.covariance) variance += tag.covariance->diagonal().maxCoeff();
  double limit_px = std::max(kRefusedSigmas * std::sqrt(variance), kShapeOfSide * MeanSidePx(tag));
  if (in_map != nullptr) limit_px += std::abs(in_map->bend_m) / in_map->size_m * MeanSidePx(tag);
  if (about_px && *about_px < kSurelyNear * limit_px) return true;
  const auto misfit_px = SquareMisfitPx(tag.corners, cameras_.at(static_cast<size_t>(tag.camera)));
  return misfit_px && *misfit_px < limit_px;
}

// The approximation is good for little where the tag is small, or where it is of several
// deviations; the search, which is not, takes 60 times as long.
double TagGate::MisfitPx(const TagDetection& tag, double about_px, double sigma_px,
                         int* searches_left) const {
  constexpr double kSure = 3.5, kSmallPx = 25;
  const bool is_sure = misfits_px_.size() >= kLeastToLearn && about_px < kSure * sigma_px;
  if (is_sure && MeanSidePx(tag) > kSmallPx) return about_px;
  if ((*searches_left)-- <= 0) return 0;
  return SquareMisfitPx(tag.corners, cameras_.at(static_cast<size_t>(tag.camera))).value_or(0);
}

std::vector<TagDetection> TagGate::TakeRefused(std::vector<TagDetection>* tags,
                                               std::vector<double>* misfits_px) {
  const double sigma_px = SigmaPx();
  std::vector<TagDetection> kept, refused;
  kept.reserve(tags->size());
  if (misfits_px != nullptr) misfits_px->clear();
  int searches_left = 2;
  for (TagDetection& tag : *tags) {
    const QuadTurn turn = TurnOf(tag.corners);
    const bool may_be_one = turn != QuadTurn::kClockwise && turn != QuadTurn::kNone;
    std::optional<double> about_px;
    if (may_be_one) {
      about_px =
          ApproximateSquareMisfitPx(tag.corners, cameras_.at(static_cast<size_t>(tag.camera)));
    }
    const bool passes = may_be_one && Passes(tag, about_px, sigma_px);
    const bool tells = turn == QuadTurn::kAnticlockwise && about_px;
    if (passes && misfits_px != nullptr) {
      const bool is_asked = tells && !tag.covariance;
      misfits_px->push_back(is_asked ? MisfitPx(tag, *about_px, sigma_px, &searches_left) : 0);
    }
    (passes ? kept : refused).push_back(std::move(tag));
    if (tells) Learn(*about_px);
  }
  *tags = std::move(kept);
  return refused;
}

}  // namespace tagtwist::internal

#include "frontend/tags/detection_policy.h"

#include <algorithm>

namespace tagtwist::internal {
namespace {

constexpr int kFramesPerPart = 5;
constexpr int kColumns = 5, kRows = DetectionPolicy::kParts / kColumns;
// Parts overlap, so that a tag of a sixth of the image lies wholly in one of them.
constexpr double kWidth = 0.34, kHeight = 0.42;

}  // namespace

bool DetectionPolicy::AfterGuided(int expected, int found) {
  const bool lost = found == 0 || 2 * found < std::min(expected, last_found_);
  if (!lost) last_found_ = found;
  return lost;
}

void DetectionPolicy::AfterFull(int found) {
  last_found_ = found;
  frames_since_part_ = 0;
}

std::optional<Eigen::AlignedBox2d> DetectionPolicy::NextPart() {
  if (++frames_since_part_ < kFramesPerPart) return std::nullopt;
  frames_since_part_ = 0;
  return TakePart();
}

Eigen::AlignedBox2d DetectionPolicy::TakePart() {
  const int column = part_ % kColumns, row = part_ / kColumns;
  part_ = (part_ + 1) % kParts;
  const Eigen::Vector2d low(column * (1 - kWidth) / (kColumns - 1),
                            row * (1 - kHeight) / (kRows - 1));
  return {low, low + Eigen::Vector2d(kWidth, kHeight)};
}

}  // namespace tagtwist::internal

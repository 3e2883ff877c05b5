#include "estimator/evaluation/alignment_types.h"

namespace tagtwist {

const char* ToString(AlignmentKind kind) {
  if (kind == AlignmentKind::kSe3) return "se3";
  return kind == AlignmentKind::kHandEye ? "handeye" : "none";
}

std::optional<AlignmentKind> ParseAlignmentKind(const std::string& name) {
  for (const auto kind : {AlignmentKind::kNone, AlignmentKind::kSe3, AlignmentKind::kHandEye}) {
    if (name == ToString(kind)) return kind;
  }
  return std::nullopt;
}

}  // namespace tagtwist

#include "estimator/result/estimate.h"

namespace tagtwist {

const char* ToString(FrameStatus status) {
  switch (status) {
    case FrameStatus::kOk:
      return "ok";
    case FrameStatus::kHurried:
      return "hurried";
    case FrameStatus::kPredicted:
      return "predicted";
    case FrameStatus::kAmbiguous:
      return "ambiguous";
    case FrameStatus::kNoFix:
      return "no_fix";
  }
  return "";
}

const char* ToString(EstimateMode mode) {
  return mode == EstimateMode::kBatch ? "batch" : "sliding_window";
}

}  // namespace tagtwist

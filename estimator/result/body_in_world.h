#pragma once
#include "estimator/result/estimate.h"

namespace tagtwist::internal {

/// A body O that a moving carrier C sees, in W: of C in W, and of C about O as if O stood (O in
/// place of W), the state of O in W,
///   W_from_O = W_from_C (O_from_C)^-1,
/// and its twist. Both are of one time, each from tags of its own: their errors are independent but
/// for those of lens and mount that last, which are not counted here.
FrameEstimate BodyInWorld(const FrameEstimate& carrier_in_world,
                          const FrameEstimate& carrier_about_body);

/// All frames of an estimate about a body, which is of the same frames.
void PutInWorld(const Estimate& carrier_in_world, Estimate* about_body);

}  // namespace tagtwist::internal

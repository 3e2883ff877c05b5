#pragma once
#include <Eigen/Core>
#include <vector>

#include "estimator/batch/mirror_stretches.h"
#include "estimator/graph/graph_builder.h"
#include "estimator/graph/noise_model.h"

namespace tagtwist::internal {

/// The turn of a body from one frame to another, as one rotation vector in the body [rad], below
/// half a turn; and what of whole turns goes before it: the way is Exp(f whole) Exp(f rest), f from
/// 0 to 1.
struct GapTurn {
  Eigen::Vector3d whole = Eigen::Vector3d::Zero();  // a multiple of 2 pi long
  Eigen::Vector3d rest = Eigen::Vector3d::Zero();
};

/// Long intervals of a recording without a state: from the state before each (first) to the one
/// after it (last). States stand between these, bridges, where the body may have turned by half a
/// turn or more, for the motion prior holds for less from one state to the next: as of the frames'
/// rates on both sides or of the noise. Puts these bridges into the input, and counts states and
/// segments anew. An interval that a track ties is none.
std::vector<FrameRange> FindAndBridgeGaps(const NoiseModel& noise, std::vector<int>* state_of_frame,
                                          GraphInput* input);

/// Whether a body turned in a gap, by half a radian, and so much otherwise than the rates on both
/// sides of it say: then these tell nothing of the way.
inline bool IsUnexpected(const Eigen::Vector3d& turn, const Eigen::Vector3d& expected) {
  constexpr double kRad = 0.5;
  return turn.norm() > kRad && (turn - expected).norm() > kRad;
}

/// Whether bridges stand in the gap.
inline bool IsBridged(const FrameRange& gap) { return gap.last > gap.first + 1; }

/// How a gap's bridges turn from its first to its last frame.
GapTurn TurnThrough(const std::vector<GraphFrame>& frames, const FrameRange& gap);

/// The same with so many whole turns more, about the axis of the rest, or, where that is next to
/// nothing, of the rates on both sides.
GapTurn TurnedOn(const std::vector<GraphFrame>& frames, const FrameRange& gap, const GapTurn& turn,
                 int whole_turns);

/// Puts a gap's bridges evenly on that way, with the twist that it takes.
void LayBridges(const GapTurn& turn, const FrameRange& gap, std::vector<GraphFrame>* frames);

}  // namespace tagtwist::internal

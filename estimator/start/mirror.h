#pragma once
#include <optional>
#include <vector>

#include "estimator/graph/graph_builder.h"
#include "estimator/graph/noise_model.h"

namespace tagtwist::internal {

/// Half a difference of sums of squares that decides between two accounts: exp(-9), one in 8000.
inline constexpr double kDecidedCost = 9;

/// Half the sum of squares of a frame's whitened corners at a pose; nullopt where a corner cannot
/// be seen from there.
std::optional<double> CornerCost(const EstimatorSetup& setup, const NoiseModel& noise,
                                 const GraphFrame& frame, const Pose& world_from_body);

/// The other pose under which tags of one plane look the same from afar.
struct Mirror {
  double angle_rad = 0;  // between the two attitudes
  double cost = 0;       // half the sum of squares that it costs more, of whitened corners
};

/// The mirrored pose of a frame's state and tags; nullopt where there is none: no tags, tags on
/// several planes, a corner that comes to lie behind the camera. The cost need not be that of a
/// minimum: a tag seen nearly face-on makes one wide trough of both poses, and noise puts the
/// minimum anywhere in it.
std::optional<Mirror> MirrorOf(const EstimatorSetup& setup, const NoiseModel& noise,
                               const GraphFrame& frame);

/// Of the two minima that a frame's tags have by themselves, one near its state's pose and one near
/// the mirrored one, the latter.
struct OtherMinimum {
  Pose pose;
  double cost = 0;  // half the sum of squares that it has more than the first, of whitened corners
};

/// nullopt where the tags have no such minima.
std::optional<OtherMinimum> OtherMinimumOf(const EstimatorSetup& setup, const NoiseModel& noise,
                                           const GraphFrame& frame);

/// Below that angle between both poses [rad] they are one trough, and a path may change over.
inline constexpr double kTroughRad = 0.3;

/// Frames from the one to the other, both of them.
struct FrameRange {
  int first = 0, last = 0;
};

/// Puts those frames to their mirrored poses, with twists to match. A frame without tags moves as
/// the one beside it does.
void MirrorFrames(const EstimatorSetup& setup, const FrameRange& range,
                  std::vector<GraphFrame>* frames);

/// Probability that a window's states are the mirrored ones (MirrorOf), by its own frames' corners:
/// a body that was seen nearly face-on may have swung on or back, and a state, once on the wrong
/// side, keeps to it until the corners outweigh all that came before. As the states are those of
/// many that fit the corners best, the corners' costs count as a part of what they would otherwise.
/// Takes time only as long as the frames leave it open.
double MirrorDoubt(const EstimatorSetup& setup, const NoiseModel& noise,
                   const std::vector<GraphFrame>& frames);

/// Makes a frame's covariance that of a mixture with its mirrored state, which is as uncertain in
/// its own axes and has the twist that the mirrored poses beside it have.
void TakeMirrored(const EstimatorSetup& setup, const std::vector<GraphFrame>& frames, size_t frame,
                  double probability, StateCovariance* covariance);

}  // namespace tagtwist::internal

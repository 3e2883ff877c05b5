#pragma once
#include <optional>

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

}  // namespace tagtwist::internal

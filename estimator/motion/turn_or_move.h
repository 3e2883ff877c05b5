#pragma once
#include <string>
#include <vector>

#include "estimator/graph/graph_builder.h"
#include "estimator/graph/noise_model.h"

namespace tagtwist::internal {

/// Whether the tags of a recording tell a body that turns from one that moves: a small tag's place
/// in the image shows the sum of both well, and only its shape, badly, which it was. The densities'
/// likelihood then prefers one of the two, for that has less to explain: motion along the view,
/// which the tag's size does tell, is rare on floors and gantries, and takes the density of all
/// motion with it.
///
/// Of solved frames: 0 where the tags tell. Else the distance from body to tags [m], by which a
/// turn shows like a move. They do not tell where, in most frames, they leave the position more
/// open than half of what the body could have moved, if all of its turning was moving, and the
/// attitude, too, to more than half a degree.
double LeverOfUntold(const EstimatorSetup& setup, const NoiseModel& noise,
                     const std::vector<GraphFrame>& frames);

/// For people, of a lever above 0.
std::string TextOfUntold(double lever_m);

}  // namespace tagtwist::internal

#pragma once
#include <string>

#include "estimator/calibration/mapping.h"

namespace tagtwist::internal {

/// The map as a configuration's section with the tags' sigmas, and in words what came of it.
std::string MappingText(const Mapping& mapping);

}  // namespace tagtwist::internal

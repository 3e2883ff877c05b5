#pragma once
#include <string>

#include "estimator/calibration/mapping.h"

namespace tagtwist {

/// The map as a configuration's section with the tags' sigmas, and in words what came of it.
std::string MappingText(const Mapping& mapping);

}  // namespace tagtwist

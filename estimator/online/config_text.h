#pragma once
#include <string>

#include "estimator/online/config.h"

namespace tagtwist::internal {

/// The sections of a configuration behind camera, mount and map, as LoadConfig reads them: movable
/// tags where there are any, and all options. Each begins with an empty line.
std::string OptionsText(const Config& config);

}  // namespace tagtwist::internal

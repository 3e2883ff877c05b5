#pragma once
#include "estimator/online/config.h"
#include "frontend/io/recordings/data_source.h"

namespace tagtwist::internal {

/// The configuration with the error that the recording's stamps are known to have, where it says
/// none: of whole steps, uniform over one.
Config WithStampError(Config config, const DataSource& source);

}  // namespace tagtwist::internal

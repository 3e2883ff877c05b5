#pragma once
#include "apps/support/usage.h"
#include "estimator/online/config.h"

namespace tagtwist::internal {

/// The flags that say which camera and map there are, for the help text.
FlagGroup ConfigFlags();

/// The files that these flags name; an error is a wrong use of them.
Result<ConfigFiles> ConfigFilesFromFlags();

}  // namespace tagtwist::internal

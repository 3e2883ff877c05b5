#include "estimator/jobs/stamp_error.h"

#include <cmath>

namespace tagtwist::internal {

Config WithStampError(Config config, const DataSource& source) {
  const double step_s = source.stamp_step_s();
  auto& sigma_s = config.estimator.stamp_sigma_s;
  if (!sigma_s && step_s > 0) sigma_s = step_s / std::sqrt(12.0);
  return config;
}

}  // namespace tagtwist::internal

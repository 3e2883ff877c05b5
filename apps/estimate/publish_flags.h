#pragma once
#include <string>

#include "apps/estimate/estimate_job.h"
#include "estimator/publish/publisher.h"

namespace tagtwist::internal {

/// What --publish, --page, --listen and --record ask for.
struct PublishFlags {
  PublishOptions options;
  std::string csv;  // of --publish csv:PLACE: what --stream does
};

/// An error is a wrong use of them. `job`: as the other flags have it; `is_live`: its frames come
/// when they come.
Result<PublishFlags> PublishFromFlags(const EstimateJob& job, bool is_live);

}  // namespace tagtwist::internal

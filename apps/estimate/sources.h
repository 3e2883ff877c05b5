#pragma once
#include <iosfwd>
#include <memory>

#include "apps/estimate/estimate_flags.h"
#include "estimator/online/config.h"
#include "estimator/result/estimate.h"
#include "frontend/io/recordings/data_source.h"

namespace tagtwist::internal {

/// How the job's recording is opened.
DataSourceOptions SourceOptions(const EstimateJob& job, const Config& config);
/// The job's recording, or its camera.
Result<std::unique_ptr<DataSource>> OpenSource(const EstimateJob& job, const Config& config);

/// Whether what the job asks for can be had of the several cameras that the configuration has.
Status CheckRigOf(const EstimateJob& job, const Config& config);

/// Where figures are told: rows have standard output to themselves.
std::ostream& Messages(const EstimateJob& job);

/// Whether --overlay can be written, before anything takes its time; and the overlay itself, from
/// the recording read once more.
Status CheckOverlayOf(const EstimateJob& job, const Config& config);
Status WriteOverlayOf(const EstimateJob& job, const Config& config, const Estimate& estimate);

}  // namespace tagtwist::internal

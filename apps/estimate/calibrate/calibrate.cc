#include "apps/estimate/calibrate/calibrate.h"

#include <iostream>
#include <utility>

#include "apps/estimate/sources.h"
#include "estimator/jobs/calibrate_recording.h"
#include "estimator/online/config_text.h"
#include "estimator/report/files/calibration_config.h"
#include "estimator/report/files/calibration_text.h"
#include "frontend/base/spans.h"
#include "residuals/lens.h"

namespace tagtwist::internal {
namespace {

// The refined set-up, told on standard output.
Result<Calibration> CalibrateFirst(const EstimateJob& job, const Config& config,
                                   const std::vector<TruthSample>& truth) {
  auto source = OpenSource(job, config);
  if (!source) return source.error();
  auto calibration = CalibrateRecording(job.dataset, source->get(), config, job.run, truth);
  if (!calibration) return calibration;
  for (const std::string& line : CalibrationText(*calibration)) Messages(job) << line << "\n";
  Messages(job) << "\n";
  return calibration;
}

// What was refined is known as the calibration says, the lens and the mount in the set-up; that
// stands with it in what is written, and no longer in the options.
void TakeCalibratedSigmas(const Calibration& calibration, EstimatorOptions* of_run,
                          EstimatorOptions* written) {
  if (calibration.sigma(kLogFocal) > 0) {
    of_run->focal_sigma.reset();
    written->focal_sigma.reset();
  }
  const auto tag_m = TagSigmaOf(calibration);
  if (tag_m) of_run->tag_sigma_m = tag_m;
  if (tag_m) written->tag_sigma_m.reset();
}

// Of several cameras how they stand against the first, and their clocks.
Status CalibrateRigFirst(const EstimateJob& job, Config* config,
                         std::unique_ptr<DataSource>* source, ResultContext* context) {
  auto rig = CalibrateRigRecording(job.dataset, source->get(), *config, job.run);
  if (!rig) return rig.error();
  for (const std::string& line : RigText(*rig)) Messages(job) << line << "\n";
  Messages(job) << "\n";
  config->set_up = rig->set_up;
  context->rig = std::make_shared<const RigCalibration>(std::move(*rig));
  auto again = OpenSource(job, *config);  // by the clocks that were found
  if (!again) return again.error();
  *source = std::move(*again);
  return Ok();
}

}  // namespace

Status CalibrateIfAsked(const EstimateJob& job, bool configured_tracks, Config* config,
                        std::unique_ptr<DataSource>* source, ResultContext* context) {
  if (!job.calibrate) return Ok();
  const Span span(job.run.spans, "calibrate");
  if (config->set_up.rig.IsOfSeveral()) {
    if (const auto done = CalibrateRigFirst(job, config, source, context); !done) return done;
    Config to_go_on_with = *config;
    to_go_on_with.estimator.use_tracks = configured_tracks;
    context->options_text =
        CamerasSectionText(*config) + MapSectionText(*config) + OptionsText(to_go_on_with);
    return Ok();
  }
  auto calibration = CalibrateFirst(job, *config, context->truth);
  if (!calibration) return calibration.error();
  config->set_up = calibration->set_up;
  Config to_go_on_with = *config;
  TakeCalibratedSigmas(*calibration, &config->estimator, &to_go_on_with.estimator);
  to_go_on_with.estimator.use_tracks = configured_tracks;
  context->options_text = OptionsText(to_go_on_with);
  context->calibration = std::make_shared<const Calibration>(std::move(*calibration));
  return Ok();
}

}  // namespace tagtwist::internal

#pragma once
#include <optional>
#include <string>

#include "estimator/jobs/pieces/frame_range.h"
#include "estimator/jobs/run.h"
#include "estimator/publish/publisher.h"

namespace tagtwist::internal {

/// How a run that is done has gone; kNever is worse than any.
enum class Outcome { kClean, kFindings, kWarnings, kNever };

/// What the command line of tagtwist_estimate asks for.
struct EstimateJob {
  std::string dataset, topic, output, ground_truth;
  std::string truth_topic;  // --truth_topic; empty: the only one
  std::string overlay;      // --overlay; empty: none
  std::string profile;      // --profile; empty: none
  std::string stream;       // --stream; empty: none
  ConfigFiles config;
  bool read_images = true;
  bool write_covariance = false;
  bool write_detections = false;
  bool calibrate = false;
  bool map_unknown_tags = false;
  double unknown_tag_size_m = 0;  // 0: that of the map's tags
  bool realtime = false;
  std::optional<FrameMark> from, to;  // the frames that are taken
  bool only_detections = false;       // they are measured, and not estimated with
  std::string pieces;                 // --pieces; empty: none
  PublishOptions publish;             // --publish but for csv, --page, --listen, --record
  Outcome fail_on = Outcome::kNever;  // --fail_on: exit status 3 from there on
  RunOptions run;
};

}  // namespace tagtwist::internal

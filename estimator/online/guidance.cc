#include "estimator/online/guidance.h"

#include <algorithm>

#include "estimator/graph/track_segments.h"

namespace tagtwist::internal {

std::optional<PosePrediction> PredictPose(const SlidingWindow& window, int64_t t_ns) {
  const auto state = window.PredictAt(t_ns);
  if (!state) return std::nullopt;
  return PosePrediction{state->state.world_from_body, state->covariance.topLeftCorner<6, 6>(),
                        window.noise().corner_sigma_px};
}

Config ForOnlineUse(Config config) {
  KltOptions& klt = config.front_end.klt;
  const int most = config.estimator.use_tracks ? config.estimator.max_tracks_per_frame : 0;
  klt.max_points = std::min(klt.max_points, 2 * most);
  if (klt.enough_tags == 0) klt.enough_tags = TagsThatReplaceTracks(most);
  return config;
}

}  // namespace tagtwist::internal

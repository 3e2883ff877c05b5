// Frames in, states out: a simulated flight over the course's mat, estimated frame by frame and
// then as a whole. With images OnlineEstimator::AddImage finds the tags itself.
#include <cstdio>
#include <utility>
#include <vector>

#include "estimator/batch/batch.h"
#include "estimator/online/config.h"
#include "estimator/online/online_estimator.h"
#include "frontend/simulation/named_flights.h"
#include "frontend/simulation/simulator.h"

int main() {
  const tagtwist::Config config = tagtwist::DefaultConfig();
  const auto path = tagtwist::FlightPath("figure8", config.map, {3.0, 1.2});
  tagtwist::SimulatorOptions options;
  options.images = false;
  const auto simulator =
      tagtwist::Simulator::Make(config.camera, config.cam_from_body, config.map, *path, options);
  const auto setup = tagtwist::MakeEstimatorSetup(config.camera, config.cam_from_body, config.map,
                                                  config.estimator);

  auto online = tagtwist::OnlineEstimator::Create(config);
  if (!online) return std::fprintf(stderr, "%s\n", online.error().message.c_str()), 1;
  tagtwist::BatchEstimator batch(setup);
  double worst_m = 0;
  for (int i = 0; i < 120; ++i) {
    const auto frame = simulator->MakeFrame(i, path->first_ns() + 20'000'000LL * i);
    tagtwist::FrameMeasurements measurements;
    measurements.t_ns = frame.t_ns;
    measurements.tags = frame.detections;
    const auto now = online->AddTags(frame.t_ns, frame.detections);
    if (!now) return std::fprintf(stderr, "%s\n", now.error().message.c_str()), 1;
    const auto& state = now->current.state;
    const double off_m =
        (state.world_from_body.translation() - frame.truth.world_from_body.translation()).norm();
    if (off_m > worst_m) worst_m = off_m;
    batch.Add(std::move(measurements));
  }
  const auto result = batch.Solve();
  if (!result) return std::fprintf(stderr, "%s\n", result.error().message.c_str()), 1;
  std::printf("window: at most %.1f mm off; batch: %zu frames\n", 1e3 * worst_m,
              result->frames.size());
  return worst_m < 0.02 && result->frames.size() == 120 ? 0 : 1;
}

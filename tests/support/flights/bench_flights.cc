#include "tests/support/flights/bench_flights.h"

#include <algorithm>
#include <optional>

#include "frontend/base/statistics/random_stream.h"
#include "frontend/front_end.h"
#include "frontend/pattern/corner_refiner.h"
#include "frontend/simulation/named_flights.h"
#include "frontend/tags/find_tags.h"
#include "frontend/tags/tag_detector.h"

namespace tagtwist::internal {
namespace {

constexpr uint64_t kHeightPurpose = 0x6265;  // of the random stream: apart from the simulator's

// Tags of rendered images, as tagtwist_estimate finds them.
struct ImageTags {
  TagDetector detector;
  CornerRefiner refiner;

  static Result<ImageTags> Create(const Config& config) {
    auto detector = TagDetector::Create(config.set_up.map.family(), config.front_end.detector);
    if (!detector) return detector.error();
    auto refiner = CornerRefiner::Create(config.set_up.map, config.set_up.rig.front().camera);
    if (!refiner) return refiner.error();
    return ImageTags{std::move(*detector), std::move(*refiner)};
  }
};

Eigen::Vector2d Centre(const TagDetection& tag) {
  return 0.25 * (tag.corners[0] + tag.corners[1] + tag.corners[2] + tag.corners[3]);
}

void KeepTheMiddleOne(const Camera& camera, std::vector<TagDetection>* tags) {
  if (tags->empty()) return;
  const Eigen::Vector2d middle(0.5 * (camera.width - 1), 0.5 * (camera.height - 1));
  *tags = {*std::min_element(tags->begin(), tags->end(),
                             [&](const TagDetection& a, const TagDetection& b) {
                               return (Centre(a) - middle).norm() < (Centre(b) - middle).norm();
                             })};
}

}  // namespace

std::vector<BenchFlight> BenchGrid(double corner_noise_px) {
  BenchFlight plain;
  plain.simulator.images = false;
  plain.simulator.corner_noise_px = corner_noise_px;
  std::vector<BenchFlight> grid(6, plain);
  grid[0].name = "gentle";
  grid[1].name = "agile";
  grid[1].trajectory = "agile";
  grid[2].name = "one tag";
  grid[2].one_tag = true;
  grid[3].name = "70 % hidden";
  grid[3].simulator.hidden_fraction = 0.7;
  grid[4].name = "jitter 8 ms";
  grid[4].jitter_s = 0.008;
  grid[5].name = "blur, images";
  grid[5].simulator.images = true;
  grid[5].simulator.exposure_s = 0.01;
  grid[5].simulator.renderer.blur_px = 0.8;
  grid[5].simulator.renderer.noise_grey = 3;
  return grid;
}

Result<BenchRun> MakeBenchRun(const BenchFlight& flight, const Config& config, double duration_s,
                              uint64_t seed) {
  FlightOptions shape;
  shape.duration_s = duration_s;
  shape.height_m = RandomStream(seed, kHeightPurpose).Uniform(1.0, 1.4);
  const auto path = FlightPath(flight.trajectory, config.set_up.map, shape);
  if (!path) return path.error();
  StampOptions stamp_options;
  stamp_options.jitter_s = flight.jitter_s;
  stamp_options.random_seed = seed;
  const auto stamps_ns = MakeStamps(path->first_ns(), path->last_ns(), stamp_options);
  if (!stamps_ns) return stamps_ns.error();
  SimulatorOptions options = flight.simulator;
  options.random_seed = seed;
  const auto simulator = Simulator::Make(config.set_up, *path, options);
  if (!simulator) return simulator.error();
  const auto image_tags = ImageTags::Create(config);
  if (!image_tags) return image_tags.error();

  BenchRun run;
  FrontEnd front_end(config.set_up, config.front_end);
  for (size_t i = 0; i < stamps_ns->size(); ++i) {
    const SimulatedFrame frame = simulator->MakeFrame(i, (*stamps_ns)[i]);
    const TagDetectorOptions& look = config.front_end.detector;
    std::vector<TagDetection> tags =
        options.images ? FindTags(frame.image, image_tags->detector, image_tags->refiner,
                                  config.set_up.map, config.set_up.rig.front().camera, look)
                       : FilterTags(frame.detections, config.set_up.map,
                                    config.set_up.rig.front().camera, look.border_px);
    if (flight.one_tag) KeepTheMiddleOne(config.set_up.rig.front().camera, &tags);
    run.measurements.push_back(front_end.Process(frame.t_ns, tags, frame.image));
    run.truth.push_back({frame.t_ns, frame.truth.world_from_body, frame.truth.twist});
  }
  return run;
}

}  // namespace tagtwist::internal

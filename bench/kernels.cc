#include <benchmark/benchmark.h>

#include <algorithm>
#include <cstdlib>
#include <iostream>
#include <opencv2/core/utility.hpp>
#include <optional>
#include <vector>

#include "bench/endless_flight.h"
#include "estimator/graph/linear_system.h"
#include "estimator/online/config.h"
#include "estimator/solve/banded_solver.h"
#include "estimator/solve/noise_learning.h"
#include "estimator/start/recording_start.h"
#include "estimator/window/sliding_window.h"
#include "frontend/closed_form.h"
#include "frontend/flow/klt_tracker.h"
#include "frontend/front_end.h"
#include "frontend/simulation/named_flights.h"
#include "frontend/tags/find_tags.h"
#include "frontend/tags/guided_detector.h"
#include "residuals/motion_residual.h"
#include "residuals/tag_reprojection_residual.h"

namespace tagtwist::internal {
namespace {

constexpr int kFrames = 400;  // of a flight's corners
constexpr double kRateHz = 49;

template <typename T>
T OrExit(Result<T> result) {
  if (result) return std::move(*result);
  std::cerr << "kernels: " << result.error().message << "\n";
  std::exit(1);
}

// Two neighbouring images of a flight, with their tags as the detector finds them.
struct Images {
  Config config = DefaultConfig();
  std::vector<SimulatedFrame> frames;
  std::vector<std::vector<TagDetection>> tags;
  CornerRefiner refiner =
      OrExit(CornerRefiner::Create(config.set_up.map, config.set_up.rig.front().camera));

  Images() {
    const auto path = OrExit(FlightPath("figure8", config.set_up.map, {}));
    const auto simulator = OrExit(Simulator::Make(config.set_up, path, {}));
    const auto detector =
        OrExit(TagDetector::Create(config.set_up.map.family(), config.front_end.detector));
    for (uint64_t i = 0; i < 2; ++i) {
      const auto t_ns =
          path.first_ns() + static_cast<int64_t>(1e9 * (8 + static_cast<double>(i) / kRateHz));
      frames.push_back(simulator.MakeFrame(i, t_ns));
      tags.push_back(FilterTags(detector.Detect(frames.back().image), config.set_up.map,
                                config.set_up.rig.front().camera,
                                config.front_end.detector.border_px));
    }
  }
};

// Corners of a flight.
struct Corners {
  Config config = DefaultConfig();
  EstimatorSetup setup = MakeEstimatorSetup(config.set_up, config.estimator);
  std::vector<FrameMeasurements> frames;

  Corners() {
    const auto flight = OrExit(EndlessFlight::Make(config, "figure8", kRateHz, 0.3, 1));
    for (int i = 0; i < kFrames; ++i) {
      const SimulatedFrame frame = flight.At(i);
      frames.push_back({});
      frames.back().t_ns = frame.t_ns;
      frames.back().tags =
          FilterTags(frame.detections, config.set_up.map, config.set_up.rig.front().camera,
                     config.front_end.detector.border_px);
    }
  }
  Graph MakeGraph() const {
    GraphInput input;
    input.frames = OrExit(StartFrames(setup, frames));
    return BuildGraph(setup, InitialNoise(setup.options), input);
  }
};

void FitOneTag(benchmark::State& state) {
  const Images images;
  const TagDetection& tag = images.tags[0].front();
  for (auto _ : state) benchmark::DoNotOptimize(images.refiner.Refine(images.frames[0].image, tag));
}
BENCHMARK(FitOneTag)->Unit(benchmark::kMicrosecond);

void FollowOneTag(benchmark::State& state) {
  const Images images;
  const auto fitted = images.refiner.Refine(images.frames[0].image, images.tags[0].front());
  if (!fitted) return state.SkipWithError("no fit");
  TagDetection tag = images.tags[0].front();
  tag.corners = fitted->corners;
  tag.corners[0].x() += 0.05;
  for (auto _ : state) {
    benchmark::DoNotOptimize(
        images.refiner.Follow(images.frames[0].image, tag, fitted->look, 0.05));
  }
}
BENCHMARK(FollowOneTag)->Unit(benchmark::kMicrosecond);

// From a prediction that is a millimetre and a milliradian off.
void GuidedDetectionOfAFrame(benchmark::State& state) {
  const Images images;
  const Config& config = images.config;
  GuidedDetector detector(config.set_up.rig.front().camera, config.set_up.rig.front().cam_from_body,
                          config.set_up.map, config.front_end.detector.border_px);
  PosePrediction prediction;
  const Pose& truth = images.frames[1].truth.world_from_body;
  prediction.world_from_body =
      MakePose(truth.rotation(), truth.translation() + Eigen::Vector3d(1e-3, 0, 0));
  prediction.covariance = 1e-6 * PoseCovariance::Identity();
  prediction.corner_sigma_px = 0.02;
  size_t found = 0;
  for (auto _ : state)
    found = detector.Find(images.frames[1].image, images.refiner, prediction).found.size();
  state.counters["tags"] = static_cast<double>(found);
}
BENCHMARK(GuidedDetectionOfAFrame)->Unit(benchmark::kMillisecond);

void KltOfAFrame(benchmark::State& state) {
  const Images images;
  KltOptions options;
  options.max_points = static_cast<int>(state.range(0));
  KltTracker tracker(options);
  tracker.Track(images.frames[0].image, images.tags[0]);
  size_t i = 0, tracks = 0;
  for (auto _ : state) {
    i = 1 - i;
    tracks = tracker.Track(images.frames[i].image, images.tags[i]).size();
  }
  state.counters["tracks"] = static_cast<double>(tracks);
}
BENCHMARK(KltOfAFrame)->Arg(80)->Arg(250)->Unit(benchmark::kMillisecond);

void ClosedFormOfAFrame(benchmark::State& state) {
  const Corners corners;
  const Config& config = corners.config;
  ClosedFormEstimator closed_form(config.set_up.rig.front().camera,
                                  config.set_up.rig.front().cam_from_body, config.set_up.map,
                                  config.front_end.closed_form);
  int64_t n = 0;
  for (auto _ : state) {
    const FrameMeasurements& frame = corners.frames[static_cast<size_t>(n % kFrames)];
    const auto t_ns = static_cast<int64_t>(1e9 * static_cast<double>(n++) / kRateHz);
    benchmark::DoNotOptimize(closed_form.Update(t_ns, frame.tags, {}));
  }
}
BENCHMARK(ClosedFormOfAFrame)->Unit(benchmark::kMicrosecond);

// Full, the noise learned.
void WindowTakesAFrame(benchmark::State& state) {
  const Corners corners;
  std::optional<SlidingWindow> window;
  size_t next = kFrames;
  for (auto _ : state) {
    if (next == kFrames) {
      state.PauseTiming();
      window.emplace(corners.config.set_up, corners.config.estimator);
      for (next = 0; next < 30; ++next) {
        if (!window->Add(corners.frames[next])) return state.SkipWithError("no solution");
      }
      state.ResumeTiming();
    }
    benchmark::DoNotOptimize(window->Add(corners.frames[next++]));
  }
}
BENCHMARK(WindowTakesAFrame)->Unit(benchmark::kMicrosecond);

void LinearizeOneFactor(benchmark::State& state, FactorKind kind) {
  const Graph graph = Corners().MakeGraph();
  const auto factor = std::find_if(graph.factors.begin(), graph.factors.end(),
                                   [&](const Factor& f) { return f.kind == kind; });
  LinearFactor linear;
  for (auto _ : state) {
    benchmark::DoNotOptimize(LinearizeFactor(graph, *factor, &linear));
  }
}
BENCHMARK_CAPTURE(LinearizeOneFactor, tag, FactorKind::kTag);
BENCHMARK_CAPTURE(LinearizeOneFactor, motion, FactorKind::kMotion);

void NormalEquations(benchmark::State& state) {
  const Graph graph = Corners().MakeGraph();
  for (auto _ : state) benchmark::DoNotOptimize(Linearize(graph));
  state.SetItemsProcessed(state.iterations() * kFrames);
}
BENCHMARK(NormalEquations)->Unit(benchmark::kMicrosecond);

void BandedCholesky(benchmark::State& state) {
  const LinearSystem system = Linearize(Corners().MakeGraph());
  for (auto _ : state) benchmark::DoNotOptimize(BlockBandedCholesky(system.hessian));
  state.SetItemsProcessed(state.iterations() * kFrames);
}
BENCHMARK(BandedCholesky)->Unit(benchmark::kMicrosecond);

void BandedInverse(benchmark::State& state) {
  const BlockBandedCholesky cholesky(Linearize(Corners().MakeGraph()).hessian);
  for (auto _ : state) benchmark::DoNotOptimize(cholesky.SelectedInverse());
  state.SetItemsProcessed(state.iterations() * kFrames);
}
BENCHMARK(BandedInverse)->Unit(benchmark::kMicrosecond);

void SolveFromStarts(benchmark::State& state) {
  const Graph start = Corners().MakeGraph();
  for (auto _ : state) {
    Graph graph = start;
    benchmark::DoNotOptimize(SolveBanded({}, &graph));
  }
  state.SetItemsProcessed(state.iterations() * kFrames);
}
BENCHMARK(SolveFromStarts)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace tagtwist::internal

int main(int argc, char** argv) {
  cv::setNumThreads(1);
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}

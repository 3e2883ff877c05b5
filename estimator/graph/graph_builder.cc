#include "estimator/graph/graph_builder.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "estimator/graph/noise_model.h"
#include "frontend/base/check.h"
#include "frontend/base/statistics/robust.h"
#include "residuals/motion_residual.h"
#include "residuals/prior_residual.h"
#include "residuals/tag_reprojection_residual.h"
#include "residuals/track_residual.h"

namespace tagtwist::internal {
namespace {

// What a body may be expected to do before anything is known of its motion.
constexpr double kFirstVelocitySigmaMps = 100.0;
constexpr double kFirstRateSigmaRadps = 200.0;
constexpr double kFirstAccelerationSigmaMps2 = 50.0;
constexpr double kFirstAngularAccelerationSigmaRadps2 = 500.0;

BlockRef PoseOf(int state) { return {BlockRef::Kind::kPose, state}; }
BlockRef RatesOf(int state) { return {BlockRef::Kind::kRates, state}; }

// Standard deviation of the first acceleration: under white noise on acceleration it is idle.
double FirstAccelerationSigma(const MotionPrior& prior, double under_jerk) {
  return prior.on == WhiteNoiseOn::kJerk ? under_jerk : 1.0;
}

Factor FirstRatesPrior(const NoiseModel& noise) {
  Eigen::VectorXd sigmas(12);
  sigmas << Eigen::Vector3d::Constant(kFirstVelocitySigmaMps),
      Eigen::Vector3d::Constant(kFirstRateSigmaRadps),
      Eigen::Vector3d::Constant(FirstAccelerationSigma(noise.linear, kFirstAccelerationSigmaMps2)),
      Eigen::Vector3d::Constant(
          FirstAccelerationSigma(noise.angular, kFirstAngularAccelerationSigmaRadps2));
  Factor factor;
  factor.kind = FactorKind::kPrior;
  factor.blocks = {RatesOf(0)};
  factor.cost = std::make_shared<PriorResidual>(
      std::vector<PriorBlock>{{false, Eigen::VectorXd::Zero(12)}},
      Eigen::MatrixXd(sigmas.cwiseInverse().asDiagonal()), Eigen::VectorXd::Zero(12));
  return factor;
}

bool HasOwnCovariance(const EstimatorSetup& setup, const TagDetection& tag) {
  return tag.covariance && !setup.options.corner_sigma_px;
}

void SetTagCost(const EstimatorSetup& setup, const TagDetection& tag, double sigma_px,
                std::shared_ptr<const FixedCamera> camera, Factor* factor) {
  const auto cost = std::make_shared<TagReprojectionResidual>(
      TagObservation{setup.map.CornersInWorld(tag.id), tag.corners,
                     CornerCovariance(setup, tag, sigma_px)},
      std::move(camera));
  factor->own_log_det = cost->LogDetInformation();
  factor->cost = cost;
}

// The corners' noise into a tag's factor, which has a cost: into that where its corners have a
// covariance of their own, else as the information of a cost in pixels.
void SetCornerNoise(const EstimatorSetup& setup, double sigma_px, const TagDetection& tag,
                    Factor* factor) {
  const bool own = HasOwnCovariance(setup, tag);
  factor->information = own ? 1 : 1 / (sigma_px * sigma_px);
  if (!own) return;
  const auto camera = static_cast<const TagReprojectionResidual&>(*factor->cost).camera();
  SetTagCost(setup, tag, sigma_px, camera, factor);
}

// One part's prior over an interval: with its scale, and never so stiff that its information would
// drown the measurements' in rounding.
MotionPrior PriorOver(const MotionPrior& prior, double scale, bool breaks, double dt_s) {
  if (breaks) return PriorOverBreak(prior, dt_s);
  constexpr double kMostInformation = 1e18;  // corners may tell 1e7 / m^2
  const double root = RootInformation(WithDensity(prior, 1.0), dt_s)(0, 0);
  return WithDensity(prior, std::max(scale * prior.psd, root * root / kMostInformation));
}

void SetMotionNoise(const Graph& graph, const NoiseModel& noise, Factor* factor) {
  const GraphState& end = graph.states[static_cast<size_t>(factor->blocks.back().index)];
  const int64_t from_ns = graph.states[static_cast<size_t>(factor->blocks.front().index)].t_ns,
                to_ns = end.t_ns;
  TAGTWIST_CHECK(to_ns > from_ns, "a graph's stamps grow, but " + std::to_string(to_ns) +
                                      " ns comes after " + std::to_string(from_ns) + " ns");
  const double dt_s = ToSeconds(to_ns - from_ns);
  const MotionScale& scale = end.motion;
  const auto cost = std::make_shared<MotionResidual>(
      dt_s, PriorOver(noise.linear, scale.linear, scale.breaks, dt_s),
      PriorOver(noise.angular, scale.angular, scale.breaks, dt_s));
  factor->own_log_det = cost->LogDetInformation();
  factor->cost = cost;
}

Factor TagFactor(const EstimatorSetup& setup, double sigma_px, const GraphFrame& frame, int state,
                 int tag, const FixedCameras& cameras) {
  Factor factor;
  factor.kind = FactorKind::kTag;
  factor.blocks = {PoseOf(state)};
  factor.huber_delta = HuberDelta(setup.options.robust_scale, 8);
  factor.source = tag;
  const TagDetection& seen = frame.tags[static_cast<size_t>(tag)];
  const bool own = HasOwnCovariance(setup, seen);
  factor.information = own ? 1 : 1 / (sigma_px * sigma_px);
  SetTagCost(setup, seen, own ? sigma_px : 1, cameras.Of(seen.camera), &factor);
  return factor;
}

Factor MotionFactor(const Graph& graph, int k, const NoiseModel& noise) {
  Factor factor;
  factor.kind = FactorKind::kMotion;
  factor.blocks = {PoseOf(k), RatesOf(k), PoseOf(k + 1), RatesOf(k + 1)};
  SetMotionNoise(graph, noise, &factor);
  return factor;
}

// The plane of the map that a camera's pixel shows; the only one is not asked.
const TrackPlane* PlaneSeenAt(const EstimatorSetup& setup, const Pose& world_from_body,
                              const Eigen::Vector2d& pixel, int camera) {
  if (setup.planes.size() == 1) return &setup.planes.front();
  const MountedCamera seen_by = setup.CameraOf(camera);
  const auto ray = seen_by.camera.Unproject(pixel);
  if (!ray) return nullptr;
  const Pose world_from_cam = world_from_body * Inverse(seen_by.cam_from_body);
  const auto plane = PlaneOfRay(
      setup.planes, {world_from_cam.translation(), world_from_cam.rotation() * ray->homogeneous()});
  return plane ? &setup.planes[*plane] : nullptr;
}

// A segment's point on the plane that its first view shows, as its views say it from the states'
// poses: the median of each coordinate. Beyond the plane's tags nothing is known of the surface.
std::optional<Eigen::Vector2d> PointOfSegment(const EstimatorSetup& setup, const Graph& graph,
                                              int first_state, const TrackSegment& segment,
                                              const TrackPlane& plane) {
  std::vector<double> x, y;
  for (size_t k = 0; k < segment.pixels.size(); ++k) {
    const Pose& pose = graph.states[static_cast<size_t>(first_state + segment.FramesAfter(k))].pose;
    const auto point =
        PointOnPlane(setup, pose, plane.world_from_plane, segment.pixels[k], segment.camera);
    if (!point) return std::nullopt;
    x.push_back(point->x());
    y.push_back(point->y());
  }
  const auto middle = static_cast<std::ptrdiff_t>(x.size() / 2);
  std::nth_element(x.begin(), x.begin() + middle, x.end());
  std::nth_element(y.begin(), y.begin() + middle, y.end());
  const Eigen::Vector2d point(x[x.size() / 2], y[y.size() / 2]);
  if (!plane.region.contains(point)) return std::nullopt;
  return point;
}

bool IsWithin(const GraphInput& input, const TrackSegment& segment) {
  const int end_frame = input.first_frame + static_cast<int>(input.frames.size());
  return segment.pixels.size() > 1 && segment.first_frame >= input.first_frame &&
         segment.last_frame() < end_frame;
}

void AddTracks(const EstimatorSetup& setup, double sigma_px, const GraphInput& input,
               Graph* graph) {
  if (!setup.options.use_tracks) return;
  for (size_t s = 0; s < input.segments.size(); ++s) {
    const TrackSegment& segment = input.segments[s];
    if (!IsWithin(input, segment)) continue;
    const int first = segment.first_frame - input.first_frame;
    const TrackPlane* plane = PlaneSeenAt(setup, graph->states[static_cast<size_t>(first)].pose,
                                          segment.pixels.front(), segment.camera);
    if (plane == nullptr) continue;
    const auto point = PointOfSegment(setup, *graph, first, segment, *plane);
    if (!point) continue;
    const BlockRef point_ref{BlockRef::Kind::kPoint, static_cast<int>(graph->points.size())};
    graph->points.push_back(*point);
    const MountedCamera seen_by = setup.CameraOf(segment.camera);
    for (size_t k = 0; k < segment.pixels.size(); ++k) {
      Factor factor;
      factor.kind = FactorKind::kTrack;
      factor.blocks = {PoseOf(first + segment.FramesAfter(k)), point_ref};
      factor.huber_delta = HuberDelta(setup.options.robust_scale, 2);
      factor.source = static_cast<int>(s);
      factor.cost =
          std::make_shared<TrackResidual>(segment.pixels[k], sigma_px, plane->world_from_plane,
                                          seen_by.camera, seen_by.cam_from_body);
      graph->factors.push_back(std::move(factor));
    }
  }
}

// Whether factors can be evaluated, one after the other in the same memory.
class Evaluation {
 public:
  bool Succeeds(const Graph& graph, const Factor& factor) {
    if (factor.kind == FactorKind::kMotion || factor.kind == FactorKind::kPrior) return true;
    parameters_.clear();
    for (const BlockRef& block : factor.blocks) parameters_.push_back(graph.Parameters(block));
    residual_.resize(static_cast<size_t>(factor.cost->num_residuals()));
    return factor.cost->Evaluate(parameters_.data(), residual_.data(), nullptr);
  }

 private:
  std::vector<const double*> parameters_;
  std::vector<double> residual_;
};

void AddFactorsOfFrame(const EstimatorSetup& setup, const NoiseModel& noise,
                       const GraphFrame& frame, const Graph& graph, int state,
                       const FixedCameras& cameras, std::vector<Factor>* out) {
  for (int tag = 0; tag < static_cast<int>(frame.tags.size()); ++tag) {
    out->push_back(TagFactor(setup, noise.corner_sigma_px, frame, state, tag, cameras));
  }
  if (state > 0) out->push_back(MotionFactor(graph, state - 1, noise));
  for (Factor other : frame.others) {
    int first = state;
    for (BlockRef& block : other.blocks) first = std::min(first, block.index += state);
    if (first >= 0) out->push_back(std::move(other));  // else the prior has it
  }
}

size_t MostOf(const GraphFrame& frame) { return frame.tags.size() + 1 + frame.others.size(); }

}  // namespace

std::vector<Factor> FactorsOfFrame(const EstimatorSetup& setup, const NoiseModel& noise,
                                   const GraphFrame& frame, const Graph& graph, int state) {
  std::vector<Factor> out;
  out.reserve(MostOf(frame));
  FixedCameras cameras(setup);
  AddFactorsOfFrame(setup, noise, frame, graph, state, cameras, &out);
  return out;
}

void SetNoise(const EstimatorSetup& setup, const NoiseModel& noise, const GraphInput& input,
              const Graph& graph, Factor* factor) {
  if (factor->kind == FactorKind::kMotion) SetMotionNoise(graph, noise, factor);
  if (factor->kind != FactorKind::kTag) return;
  const GraphFrame& frame = input.frames[static_cast<size_t>(factor->blocks.front().index)];
  SetCornerNoise(setup, noise.corner_sigma_px, frame.tags[static_cast<size_t>(factor->source)],
                 factor);
}

bool HasTracks(const EstimatorSetup& setup, const GraphInput& input) {
  return setup.options.use_tracks &&
         std::any_of(input.segments.begin(), input.segments.end(),
                     [&](const TrackSegment& segment) { return IsWithin(input, segment); });
}

Graph BuildWholeGraph(const EstimatorSetup& setup, const NoiseModel& noise,
                      const GraphInput& input) {
  Graph graph;
  graph.states.reserve(input.frames.size());
  size_t n_factors = 1;
  for (const GraphFrame& frame : input.frames) {
    n_factors += MostOf(frame);
    graph.states.push_back(ToGraphState(frame.t_ns, frame.state, frame.acceleration, frame.motion));
  }
  graph.factors.reserve(n_factors);
  graph.factors.push_back(input.prior ? *input.prior : FirstRatesPrior(noise));
  FixedCameras cameras(setup);
  for (size_t k = 0; k < input.frames.size(); ++k) {
    AddFactorsOfFrame(setup, noise, input.frames[k], graph, static_cast<int>(k), cameras,
                      &graph.factors);
  }
  AddTracks(setup, noise.track_sigma_px, input, &graph);
  return graph;
}

Graph BuildGraph(const EstimatorSetup& setup, const NoiseModel& noise, const GraphInput& input) {
  Graph graph = BuildWholeGraph(setup, noise, input);
  Evaluation evaluation;
  const auto useless = [&](const Factor& factor) { return !evaluation.Succeeds(graph, factor); };
  const auto kept = std::remove_if(graph.factors.begin(), graph.factors.end(), useless);
  graph.n_left_out = static_cast<int>(graph.factors.end() - kept);
  graph.factors.erase(kept, graph.factors.end());
  return graph;
}

Eigen::Matrix<double, 8, 8> CornerCovariance(const EstimatorSetup& setup, const TagDetection& tag,
                                             double sigma_px) {
  const Eigen::Matrix<double, 8, 8> other =
      sigma_px * sigma_px * Eigen::Matrix<double, 8, 8>::Identity();
  return HasOwnCovariance(setup, tag) ? *tag.covariance + other : other;
}

void TakeStates(const Graph& graph, std::vector<GraphFrame>* frames) {
  for (size_t i = 0; i < graph.states.size(); ++i) {
    (*frames)[i].state = ToBodyState(graph.states[i]);
    (*frames)[i].acceleration = ToAcceleration(graph.states[i]);
  }
}

}  // namespace tagtwist::internal

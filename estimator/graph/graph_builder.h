#pragma once
#include <Eigen/Core>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "estimator/graph/estimator_options.h"
#include "estimator/graph/graph.h"
#include "estimator/graph/noise_model.h"
#include "estimator/graph/track_planes.h"
#include "estimator/graph/track_segments.h"
#include "frontend/base/for_ranges.h"
#include "frontend/types/camera.h"
#include "frontend/types/measurements.h"
#include "frontend/types/rig.h"
#include "frontend/types/tag_map.h"

namespace tagtwist::internal {

struct FixedCamera;

/// How a camera sees.
struct MountedCamera {
  const Camera& camera;
  const Pose& cam_from_body;  // or cam_from_world (Rig)
  double line_time_s;
  MountedOn mounted_on;
  const Eigen::MatrixXd& covariance;  // RigCamera's

  /// From the frame in which the map has the tags, when the body is there.
  Pose CamFromMap(const Pose& world_from_body) const;
  /// The inverse: where the body is when the camera has the map there.
  Pose BodyOf(const Pose& cam_from_map) const;
};

/// What does not change during a run, as the solvers take it: BatchEstimator and SlidingWindow make
/// it of the set-up and the options that they are given.
struct EstimatorSetup {
  Camera camera;           // the first of the rig,
  double line_time_s = 0;  // of a rolling shutter (RigCamera)
  Pose cam_from_body;
  MountedOn mounted_on = MountedOn::kBody;  // all of them
  Eigen::MatrixXd camera_covariance;        // of the first (RigCamera);
  std::vector<RigCamera> others;            // and those after it;
  std::vector<std::string> camera_names;    // of all
  TagMap map;
  EstimatorOptions options;
  std::vector<TrackPlane> planes;     // of the map
  ForRanges for_ranges = InOneRange;  // how a batch does work that can be split

  int n_cameras() const { return 1 + static_cast<int>(others.size()); }
  /// Of the rig, by its index (TagDetection::camera); it must have it.
  MountedCamera CameraOf(int index) const;
  std::vector<Camera> Cameras() const;
  bool HasRollingShutter() const;
};

/// Finds the map's planes. Under a rolling shutter it is without tracks: nothing tells in which row
/// their points were; so it is with cameras that stand. Of several cameras the frames' stamps are
/// taken as they are.
EstimatorSetup MakeEstimatorSetup(const SetUp& set_up, const EstimatorOptions& options);

/// The cameras of a set-up as tags' costs share them.
class FixedCameras {
 public:
  explicit FixedCameras(const EstimatorSetup& setup);
  /// By its index in the rig (TagDetection::camera), which must have it.
  const std::shared_ptr<const FixedCamera>& Of(int index) const;

 private:
  std::vector<std::shared_ptr<const FixedCamera>> cameras_;
};

/// One frame as the graph takes it.
struct GraphFrame {
  int64_t t_ns = 0;
  BodyState state;                 // where the solve starts, and then its result
  Acceleration acceleration;       // at the start, and then its result
  MotionScale motion;              // from the frame before to this one
  std::vector<TagDetection> tags;  // accepted ones
  /// What else was measured: factors on this frame's state, index 0 in their blocks, and on those
  /// before it, -1, -2, ... Where one of these has left, the prior holds the factor.
  std::vector<Factor> others;
  bool leaves_open = false;  // its tags alone may have been seen from another pose, too
};

/// Consecutive frames, the pieces of tracks that lie wholly in them, and what is known from before.
struct GraphInput {
  std::vector<GraphFrame> frames;
  int first_frame = 0;  // of `frames`, in the count of the segments
  std::vector<TrackSegment>
      segments;                 // those with views outside the frames, or one view, are passed over
  std::optional<Factor> prior;  // of marginalised states; without one the first rates get a
                                // weak one, for a single frame says nothing about motion
};

/// The factor graph of these frames: tags, tracks, motion between neighbours, prior. Factors that
/// cannot be evaluated at the frames' states (a corner behind the camera) are left out.
Graph BuildGraph(const EstimatorSetup& setup, const NoiseModel& noise, const GraphInput& input);

/// The same with those, for whoever goes without them only for as long as that is so.
Graph BuildWholeGraph(const EstimatorSetup& setup, const NoiseModel& noise,
                      const GraphInput& input);

/// What a frame adds to a graph that has its state: its tags, the motion that leads to it, the rest
/// that was measured. Stamps must grow.
std::vector<Factor> FactorsOfFrame(const EstimatorSetup& setup, const NoiseModel& noise,
                                   const GraphFrame& frame, const Graph& graph, int state);

/// Another noise into a factor of a graph that BuildGraph made of this input without tracks; the
/// graph is left as it is but for what `factor` points to.
void SetNoise(const EstimatorSetup& setup, const NoiseModel& noise, const GraphInput& input,
              const Graph& graph, Factor* factor);

/// Whether any piece of a track would enter the graph, as far as can be told without its states.
bool HasTracks(const EstimatorSetup& setup, const GraphInput& input);

/// Covariance of a detection's corners, 8x8, u1 v1 .. u4 v4 [px^2]: the detection's own covariance
/// where it has one and the user gives no sigma, and what of the corners' errors it does not
/// explain: sigma_px.
Eigen::Matrix<double, 8, 8> CornerCovariance(const EstimatorSetup& setup, const TagDetection& tag,
                                             double sigma_px);

/// Where the ray through a pixel of a camera meets a plane z = 0 of its own frame, in that frame
/// [m]; nullopt where it does not, or more than 100 m away: a grazing view.
std::optional<Eigen::Vector2d> PointOnPlane(const EstimatorSetup& setup,
                                            const Pose& world_from_body,
                                            const Pose& world_from_plane,
                                            const Eigen::Vector2d& pixel, int camera = 0);

/// Writes the graph's states back into the frames.
void TakeStates(const Graph& graph, std::vector<GraphFrame>* frames);

}  // namespace tagtwist::internal

#pragma once
#include <Eigen/Core>
#include <map>
#include <optional>
#include <unordered_map>
#include <vector>

#include "estimator/graph/graph_builder.h"
#include "estimator/systematic/evidence.h"
#include "estimator/systematic/image_field.h"
#include "estimator/systematic/map_field.h"

namespace tagtwist::internal {

/// Ids of the tags of those frames that are seen most, at most 128, ascending: whose own errors are
/// worth parameters.
std::vector<int> TagsSeenMost(const std::vector<GraphFrame>& frames);

/// What errors of a set-up that last from frame to frame do to a tag's corners, to first order:
/// parameters side by side in groups.
///   - a smooth field over each camera's image [px], u and v: what the lens model leaves;
///   - five a tag: its position in W [m], and what its paper is turned by, slopes along its x and
///   y,
///     which count only where a field over the map (MapField) says them;
///   - three a camera after the first [rad], and three [m]: what its mount is off, in the body;
///   - one shift of all corners away from the centre of their tag, along the diagonals [px];
///   - what is given of each camera's lens and mount, by columns of a root of its covariance: of
///     unit variance. A field that is learned beside them is what they leave.
class SystematicBasis {
 public:
  /// Only those tags' own errors are parameters; tag ids. Mounts that are right: nothing of them is
  /// learned.
  SystematicBasis(const EstimatorSetup& setup, const std::vector<int>& tags,
                  bool mounts_are_right = false);

  /// Parameters as the data are summed up: the field by its knots.
  int size() const;
  /// The same by modes with one prior each, x = FromModes(z): the fields', the tags' places without
  /// their slopes, the rest, and last, where it is asked for, those of a field over the map.
  int modes() const;
  std::vector<ParameterGroup> Groups() const;  // without the map's field
  LinearEvidence ToModes(const LinearEvidence& of_knots, const MapField* map) const;
  Eigen::MatrixXd ToModes(const Eigen::MatrixXd& rows, const MapField* map) const;  // effects' rows
  Eigen::MatrixXd BothToModes(const Eigen::MatrixXd& of_knots, const MapField* map) const;  // F'F
  Eigen::MatrixXd FromModes(const Eigen::MatrixXd& of_modes, const MapField* map) const;  // columns
  /// Rows, effects of the parameters, times a square root of what is given of their covariance:
  /// what is not given is none.
  Eigen::MatrixXd TimesGivenSigmas(const Eigen::MatrixXd& effects) const;

  /// The six of the mount of a camera after the first: turns, then shifts.
  std::vector<int> OfMount(int camera) const;
  /// The first of the parameters of a tag; nullopt: it has none.
  std::optional<int> FirstOfTag(int id) const;
  static constexpr int kTagParameters = 5;
  std::vector<Eigen::Vector3d> TagPlaces() const;  // of the tags that have some [m]
  /// Rows of another basis of the same set-up, for whose tags this one has parameters, too, at this
  /// one's places. Those of other tags are what `map`, of whose modes `of_map` are the rows, says
  /// of them; the rest is zero.
  Eigen::MatrixXd RowsOf(const SystematicBasis& other, const Eigen::MatrixXd& rows,
                         const MapField* map, const Eigen::MatrixXd& of_map) const;

  /// A tag of one frame, whitened: the residual (predicted less seen), its derivatives by the pose
  /// (world_from_body's tangent), and what a unit of the parameters at `columns` adds to the seen
  /// corners. All times the square root of the tag's robust weight.
  struct TagTerms {
    Eigen::Matrix<double, 8, 1> residual;
    Eigen::Matrix<double, 8, 6> by_pose;
    std::vector<int> columns;  // ascending
    Eigen::Matrix<double, 8, Eigen::Dynamic> by_parameters;
  };
  /// False where a corner cannot be predicted.
  bool Linearize(const NoiseModel& noise, const Pose& world_from_body, const TagDetection& tag,
                 TagTerms* out) const;
  /// Whether anything of these errors is given.
  bool AnyIsGiven() const;

 private:
  using Columns = std::map<int, Eigen::Matrix<double, 8, 1>>;
  // One coordinate of one camera's field: where its knots and its modes begin.
  struct FieldBlock {
    Eigen::Index knot, mode;
    const ImageField* field;
  };
  std::vector<FieldBlock> FieldBlocks() const;
  const Tag& TagAt(int place) const;
  int field_size() const;      // columns of all fields' knots,
  int field_modes() const;     // of their modes,
  int tag_size() const;        // of all tags,
  int tag_modes() const;       // of their places alone,
  int mount_size() const;      // of the mounts' rotations, and of their places
  int given_size() const;      // of all cameras' lenses and mounts, the last ones,
  bool CameraIsGiven() const;  // of which anything is given
  // What a turn of a mount about its body's axes and a shift of it in the body (in W where the
  // camera stands) add to the seen corners.
  Eigen::Matrix<double, 8, 6> ByMount(const Pose& world_from_body,
                                      const Eigen::Matrix<double, 8, 6>& by_pose) const;
  void AddTag(int id, const Pose& world_from_body, const Eigen::Matrix<double, 8, 6>& by_pose,
              Columns* columns) const;
  void AddMount(int camera, const Eigen::Matrix<double, 8, 6>& by_mount, Columns* columns) const;
  void AddGiven(const Pose& world_from_body, const TagDetection& tag,
                const Eigen::Matrix<double, 8, 6>& by_mount, Columns* columns) const;

  EstimatorSetup setup_;
  FixedCameras cameras_;
  bool mounts_are_right_;
  std::vector<ImageField> fields_;      // of each camera
  std::vector<Eigen::MatrixXd> given_;  // of each camera: RootOfGiven
  std::unordered_map<int, int> tags_;   // id to its place
  std::vector<int> ids_;
};

}  // namespace tagtwist::internal

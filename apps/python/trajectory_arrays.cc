#include "apps/python/trajectory_arrays.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tagtwist::internal::python {
namespace {

using RowMajorCovariance = Eigen::Matrix<double, 12, 12, Eigen::RowMajor>;

Array NanArray(const std::vector<py::ssize_t>& shape) {
  Array out(shape);
  std::fill_n(out.mutable_data(), out.size(), std::numeric_limits<double>::quiet_NaN());
  return out;
}

// Row `i` of an array whose rows have the size of `Vector`.
template <typename Vector>
Eigen::Map<Vector> RowOf(Array* array, size_t i) {
  return Eigen::Map<Vector>(array->mutable_data() + i * Vector::SizeAtCompileTime);
}
template <typename Vector>
Eigen::Map<const Vector> RowOf(const Array& array, size_t i) {
  return Eigen::Map<const Vector>(array.data() + i * Vector::SizeAtCompileTime);
}

void AllocateAll(size_t n, TrajectoryArrays* out) {
  const auto rows = static_cast<py::ssize_t>(n);
  out->t_ns = IntArray(rows);
  out->position = NanArray({rows, 3});
  out->quaternion = NanArray({rows, 4});
  out->linear_velocity = NanArray({rows, 3});
  out->angular_velocity = NanArray({rows, 3});
  out->covariance = NanArray({rows, 12, 12});
}

Eigen::Vector4d PositiveQuaternion(const Pose& pose) {
  return (pose.params(3) < 0 ? -1 : 1) * pose.params.head<4>();
}

void SetPose(size_t i, const Pose& pose, TrajectoryArrays* out) {
  RowOf<Eigen::Vector3d>(&out->position, i) = pose.translation();
  RowOf<Eigen::Vector4d>(&out->quaternion, i) = PositiveQuaternion(pose);
}

void SetTwist(size_t i, const Twist& twist, TrajectoryArrays* out) {
  RowOf<Eigen::Vector3d>(&out->linear_velocity, i) = twist.v_world;
  RowOf<Eigen::Vector3d>(&out->angular_velocity, i) = twist.omega_body;
}

// The pose of a row, or none where it is NaN.
std::optional<Pose> PoseOf(const TrajectoryArrays& trajectory, size_t i) {
  const Eigen::Vector3d position = RowOf<Eigen::Vector3d>(trajectory.position, i);
  const Eigen::Vector4d xyzw = RowOf<Eigen::Vector4d>(trajectory.quaternion, i);
  if (!position.allFinite() || !xyzw.allFinite()) return std::nullopt;
  if (!(std::abs(xyzw.norm() - 1) < 1e-2)) {
    throw Refusal("quaternion: expected unit norm, got " + std::to_string(xyzw.norm()) +
                  " in row " + std::to_string(i));
  }
  return MakePose(Eigen::Quaterniond(xyzw).normalized(), position);
}

std::optional<Twist> TwistOf(const TrajectoryArrays& trajectory, size_t i) {
  const Twist twist{RowOf<Eigen::Vector3d>(trajectory.linear_velocity, i),
                    RowOf<Eigen::Vector3d>(trajectory.angular_velocity, i)};
  if (!twist.v_world.allFinite() || !twist.omega_body.allFinite()) return std::nullopt;
  return twist;
}

}  // namespace

py::array TrajectoryArrays::Seconds() const {
  Array out(t_ns.size());
  for (py::ssize_t i = 0; i < t_ns.size(); ++i) out.mutable_at(i) = ToSeconds(t_ns.at(i));
  return out;
}

StatesArrays ToStates(const std::vector<FrameEstimate>& frames) {
  StatesArrays out;
  const auto n = static_cast<py::ssize_t>(frames.size());
  AllocateAll(frames.size(), &out);
  AllocateAll(frames.size(), &out.closed_form);
  out.n_tags = IntArray(n);
  out.n_tracks = IntArray(n);
  py::list status;
  for (size_t i = 0; i < frames.size(); ++i) {
    const FrameEstimate& frame = frames[i];
    const auto row = static_cast<py::ssize_t>(i);
    out.t_ns.mutable_at(row) = out.closed_form.t_ns.mutable_at(row) = frame.t_ns;
    out.n_tags.mutable_at(row) = frame.n_tags;
    out.n_tracks.mutable_at(row) = frame.n_tracks;
    status.append(ToString(frame.status));
    const ClosedForm& closed_form = frame.closed_form;
    if (closed_form.world_from_body) SetPose(i, *closed_form.world_from_body, &out.closed_form);
    if (closed_form.twist_low_pass) SetTwist(i, *closed_form.twist_low_pass, &out.closed_form);
    if (frame.status == FrameStatus::kNoFix) continue;
    SetPose(i, frame.state.world_from_body, &out);
    SetTwist(i, frame.state.twist, &out);
    Eigen::Map<RowMajorCovariance>(out.covariance.mutable_data() + 144 * i) = frame.covariance;
  }
  out.status = py::module_::import("numpy").attr("array")(status, "U9");
  return out;
}

StateArrays ToState(const FrameEstimate& frame, const std::string& body) {
  const Pose& pose = frame.state.world_from_body;
  return {frame.t_ns,
          ToString(frame.status),
          FromMatrix(Eigen::Vector3d(pose.translation())),
          FromMatrix(PositiveQuaternion(pose)),
          FromMatrix(frame.state.twist.v_world),
          FromMatrix(frame.state.twist.omega_body),
          FromMatrix(frame.covariance),
          frame.n_tags,
          frame.n_tracks,
          body};
}

TrajectoryArrays ToTrajectory(const std::vector<TruthSample>& truth) {
  TrajectoryArrays out;
  AllocateAll(truth.size(), &out);
  for (size_t i = 0; i < truth.size(); ++i) {
    out.t_ns.mutable_at(static_cast<py::ssize_t>(i)) = truth[i].t_ns;
    SetPose(i, truth[i].world_from_body, &out);
    if (truth[i].twist) SetTwist(i, *truth[i].twist, &out);
  }
  return out;
}

PoseSeries ToSeries(const TrajectoryArrays& trajectory) {
  PoseSeries out;
  for (size_t i = 0; i < static_cast<size_t>(trajectory.t_ns.size()); ++i) {
    const auto pose = PoseOf(trajectory, i);
    if (!pose) continue;
    const Eigen::Map<const RowMajorCovariance> covariance(trajectory.covariance.data() + 144 * i);
    out.push_back({trajectory.t_ns.at(static_cast<py::ssize_t>(i)), *pose, TwistOf(trajectory, i),
                   std::nullopt});
    if (covariance.allFinite()) out.back().covariance = covariance;
  }
  return out;
}

std::vector<TruthSample> ToTruth(const TrajectoryArrays& trajectory) {
  std::vector<TruthSample> out;
  for (const PoseSample& sample : ToSeries(trajectory)) {
    out.push_back({sample.t_ns, sample.world_from_body, sample.twist});
  }
  return out;
}

}  // namespace tagtwist::internal::python

#include <cmath>

#include "apps/python/trajectory_arrays.h"

namespace tagtwist::internal::python {
namespace {

constexpr const char* kTrajectoryDoc = R"(Poses of the body, and where known its twists.

Trajectory(t_ns, position, quaternion, linear_velocity=None, angular_velocity=None,
           covariance=None)

All arrays have N rows; a row is NaN where something is not known. W is the map's
world, B the body.
  t_ns              (N,) int64, nanoseconds, growing
  position          (N, 3) of the body's origin in W [m]
  quaternion        (N, 4) x y z w, world from body, w >= 0
  linear_velocity   (N, 3) of the body's origin, in W [m/s]
  angular_velocity  (N, 3) of the body, in B [rad/s]
  covariance        (N, 12, 12) of the error state [theta in B (rad, right
                    perturbation), position in W, velocity in W, rate in B])";

constexpr const char* kStatesDoc = R"(What an estimate says of its frames: a Trajectory, and
  status       (N,) str: "ok"; "predicted": no tag in view; "hurried": a deadline came;
               "ambiguous": two poses or turns are open, the covariance has both;
               "no_fix": no state, its rows are NaN
  n_tags       (N,) tags used
  n_tracks     (N,) points followed
  closed_form  Trajectory of the same frames by the closed form (homography; flow with
               RANSAC and low-pass), NaN where it has no answer)";

constexpr const char* kStateDoc = R"(One frame of a SlidingWindow: the fields of States for it:
position (3,), quaternion (4,) x y z w, linear_velocity (3,) in W, angular_velocity (3,)
in B, covariance (12, 12), t_ns, status, n_tags, n_tracks.)";

// (N, ...) numbers, or NaN for None.
Array OptionalRows(const py::object& object, const char* name,
                   const std::vector<py::ssize_t>& shape) {
  if (!object.is_none()) return ToArray(object, name, shape);
  Array out(shape);
  std::fill_n(out.mutable_data(), out.size(), std::nan(""));
  return out;
}

TrajectoryArrays MakeTrajectory(const py::object& t_ns, const py::object& position,
                                const py::object& quaternion, const py::object& linear_velocity,
                                const py::object& angular_velocity, const py::object& covariance) {
  TrajectoryArrays out;
  out.t_ns = ToStamps(t_ns);
  const py::ssize_t n = out.t_ns.size();
  out.position = ToArray(position, "position", {n, 3});
  out.quaternion = ToArray(quaternion, "quaternion", {n, 4});
  out.linear_velocity = OptionalRows(linear_velocity, "linear_velocity", {n, 3});
  out.angular_velocity = OptionalRows(angular_velocity, "angular_velocity", {n, 3});
  out.covariance = OptionalRows(covariance, "covariance", {n, 12, 12});
  return out;
}

std::string Frames(const char* name, const TrajectoryArrays& trajectory) {
  return std::string("<tagtwist.") + name + ": " + std::to_string(trajectory.t_ns.size()) +
         " frames>";
}

void BindState(py::module_& module) {
  py::class_<StateArrays>(module, "State", kStateDoc)
      .def_readonly("t_ns", &StateArrays::t_ns, "stamp [ns]")
      .def_readonly("status", &StateArrays::status, "\"ok\", \"predicted\" or \"hurried\"")
      .def_readonly("position", &StateArrays::position, "(3,) in W [m]")
      .def_readonly("quaternion", &StateArrays::quaternion, "(4,) x y z w, world from body")
      .def_readonly("linear_velocity", &StateArrays::linear_velocity, "(3,) in W [m/s]")
      .def_readonly("angular_velocity", &StateArrays::angular_velocity, "(3,) in B [rad/s]")
      .def_readonly("covariance", &StateArrays::covariance, "(12, 12), see Trajectory")
      .def_readonly("n_tags", &StateArrays::n_tags, "tags used")
      .def_readonly("n_tracks", &StateArrays::n_tracks, "points followed")
      .def_readonly("body", &StateArrays::body, "its name: \"body\" where it has no other")
      .def("__repr__", [](const StateArrays& state) {
        return "<tagtwist.State: " + std::to_string(state.t_ns) + " ns, " + state.status + ">";
      });
}

}  // namespace

void BindTrajectories(py::module_& module) {
  using T = TrajectoryArrays;
  using S = StatesArrays;
  py::class_<T>(module, "Trajectory", kTrajectoryDoc)
      .def(py::init(&MakeTrajectory), py::arg("t_ns"), py::arg("position"), py::arg("quaternion"),
           py::arg("linear_velocity") = py::none(), py::arg("angular_velocity") = py::none(),
           py::arg("covariance") = py::none())
      .def_readonly("t_ns", &T::t_ns, "(N,) int64 stamps [ns]")
      .def_property_readonly("t", &T::Seconds, "(N,) stamps [s]")
      .def_readonly("position", &T::position, "(N, 3) in W [m]")
      .def_readonly("quaternion", &T::quaternion, "(N, 4) x y z w, world from body")
      .def_readonly("linear_velocity", &T::linear_velocity, "(N, 3) in W [m/s]")
      .def_readonly("angular_velocity", &T::angular_velocity, "(N, 3) in B [rad/s]")
      .def_readonly("covariance", &T::covariance, "(N, 12, 12) of the error state")
      .def("__len__", [](const T& trajectory) { return trajectory.t_ns.size(); })
      .def("__repr__", [](const T& trajectory) { return Frames("Trajectory", trajectory); });
  py::class_<S, T>(module, "States", kStatesDoc)
      .def_readonly("status", &S::status, "(N,) str")
      .def_readonly("n_tags", &S::n_tags, "(N,) tags used")
      .def_readonly("n_tracks", &S::n_tracks, "(N,) points followed")
      .def_readonly("closed_form", &S::closed_form, "Trajectory of the same frames")
      .def("__repr__", [](const S& states) { return Frames("States", states); });
  BindState(module);
}

}  // namespace tagtwist::internal::python

#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "frontend/base/result.h"
#include "frontend/types/body_state.h"

namespace tagtwist {

struct SplineOptions {
  double knot_spacing_s = 0.1;   // [s], > 0; widened where the poses are sparser than that
  double regularisation = 1e-7;  // weight of the squared 3rd differences of the control points, > 0
  std::optional<std::string> Problem() const;

  template <typename Self, typename Visitor>
  static void VisitFields(Self& self, Visitor&& visit) {
    visit("knot_spacing_s", self.knot_spacing_s);
    visit("regularisation", self.regularisation);
  }
};

/// A smooth path of the body: uniform quintic B-splines (four continuous derivatives) of the
/// position in W and of the four components of the quaternion, which is normalised afterwards.
/// Pose, velocity and rate are exact derivatives of one another:
///   q = p / |p|,  omega_body = 2 vec(conj(p) dp/dt) / |p|^2  (the radial part of dp/dt drops out).
class SplineTrajectory {
 public:
  /// Least squares over the poses, whose stamps must grow strictly; at least two.
  static Result<SplineTrajectory> Fit(const std::vector<TruthSample>& poses,
                                      const SplineOptions& options);

  /// The span of the poses. Queries outside it continue the end's polynomial, which is sound for a
  /// few milliseconds (an exposure), not for more.
  int64_t first_ns() const { return first_ns_; }
  int64_t last_ns() const { return last_ns_; }
  bool Covers(int64_t t_ns) const { return t_ns >= first_ns_ && t_ns <= last_ns_; }

  BodyState At(int64_t t_ns) const;
  /// Acceleration of the body's origin in W [m/s^2].
  Eigen::Vector3d AccelerationAt(int64_t t_ns) const;

 private:
  using Controls = Eigen::Matrix<double, Eigen::Dynamic, 7>;  // [x y z qx qy qz qw] a row

  // The spline (derivative = 0) or a time derivative of it at a stamp.
  Eigen::Matrix<double, 7, 1> Evaluate(int64_t t_ns, int derivative) const;

  int64_t first_ns_ = 0, last_ns_ = 0;
  double spacing_s_ = 0;
  Controls controls_;
};

}  // namespace tagtwist

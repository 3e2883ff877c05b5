#include "frontend/simulation/spline_trajectory.h"

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>

#include "frontend/base/option_check.h"

namespace tagtwist {

using namespace internal;
namespace {

constexpr int kOrder = 6;  // control points under one segment of a quintic spline
using BasisRow = Eigen::Matrix<double, 1, kOrder>;

// Uniform quintic B-spline on one segment: value = [1 u u^2 .. u^5] * basis / 120 * controls.
BasisRow Basis(double u, int derivative) {
  static const Eigen::Matrix<double, kOrder, kOrder> basis = [] {
    Eigen::Matrix<double, kOrder, kOrder> m;
    m << 1, 26, 66, 26, 1, 0,    //
        -5, -50, 0, 50, 5, 0,    //
        10, 20, -60, 20, 10, 0,  //
        -10, 20, 0, -20, 10, 0,  //
        5, -20, 30, -20, 5, 0,   //
        -1, 5, -10, 10, -5, 1;
    return Eigen::Matrix<double, kOrder, kOrder>(m / 120.0);
  }();
  BasisRow powers = BasisRow::Zero();
  double power = 1;
  for (int k = derivative; k < kOrder; ++k) {
    double factor = 1;  // d-th derivative of u^k
    for (int d = 0; d < derivative; ++d) factor *= k - d;
    powers[k] = factor * power;
    power *= u;
  }
  return powers * basis;
}

// Quaternion components with the signs that keep neighbours close.
Eigen::Matrix<double, Eigen::Dynamic, 7> StackPoses(const std::vector<TruthSample>& poses) {
  Eigen::Matrix<double, Eigen::Dynamic, 7> out(poses.size(), 7);
  for (size_t i = 0; i < poses.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    out.row(row) << poses[i].world_from_body.translation().transpose(),
        poses[i].world_from_body.rotation().coeffs().transpose();
    if (i > 0 && out.row(row).tail<4>().dot(out.row(row - 1).tail<4>()) < 0) {
      out.row(row).tail<4>() *= -1;
    }
  }
  return out;
}

std::optional<std::string> FindProblem(const std::vector<TruthSample>& poses) {
  if (poses.size() < 2) {
    return "expected at least 2 poses, got " + std::to_string(poses.size());
  }
  for (size_t i = 0; i < poses.size(); ++i) {
    const std::string name = "pose " + std::to_string(i + 1);
    if (!poses[i].world_from_body.params.allFinite()) return name + ": expected finite numbers";
    if (i > 0 && poses[i].t_ns <= poses[i - 1].t_ns) return name + ": expected growing stamps";
  }
  return std::nullopt;
}

// The asked spacing, or the median interval of the poses where that is longer.
double ChooseSpacing(const std::vector<TruthSample>& poses, double wanted_s) {
  std::vector<double> intervals;
  for (size_t i = 1; i < poses.size(); ++i) {
    intervals.push_back(ToSeconds(poses[i].t_ns - poses[i - 1].t_ns));
  }
  const auto middle = intervals.begin() + static_cast<std::ptrdiff_t>(intervals.size() / 2);
  std::nth_element(intervals.begin(), middle, intervals.end());
  return std::max(wanted_s, *middle);
}

// Segment that holds a time (the nearest one outside the span) and the place u in it.
struct Place {
  Eigen::Index segment = 0;
  double u = 0;
};
Place FindPlace(double t_s, double spacing_s, Eigen::Index segments) {
  const double knots = t_s / spacing_s;
  const double whole = std::clamp(std::floor(knots), 0.0, static_cast<double>(segments - 1));
  return {static_cast<Eigen::Index>(whole), knots - whole};
}

// Adds weight * row' * row of a row that starts at column `first`.
template <typename Row>
void AddOuterProduct(const Row& row, Eigen::Index first, double weight,
                     std::vector<Eigen::Triplet<double>>* entries) {
  for (Eigen::Index a = 0; a < row.size(); ++a) {
    for (Eigen::Index b = 0; b < row.size(); ++b) {
      entries->emplace_back(first + a, first + b, weight * row[a] * row[b]);
    }
  }
}

// Least squares for the control points: banded normal matrix, a right-hand side a component.
struct NormalEquations {
  Eigen::SparseMatrix<double> normal;
  Eigen::Matrix<double, Eigen::Dynamic, 7> rhs;
};

NormalEquations MakeNormalEquations(const std::vector<TruthSample>& poses, double spacing_s,
                                    Eigen::Index segments, double regularisation) {
  const Eigen::Index n = segments + kOrder - 1;
  const Eigen::Matrix<double, Eigen::Dynamic, 7> values = StackPoses(poses);
  NormalEquations out;
  out.rhs.setZero(n, 7);
  std::vector<Eigen::Triplet<double>> entries;
  for (size_t i = 0; i < poses.size(); ++i) {
    const double t_s = ToSeconds(poses[i].t_ns - poses.front().t_ns);
    const Place place = FindPlace(t_s, spacing_s, segments);
    const BasisRow row = Basis(place.u, 0);
    AddOuterProduct(row, place.segment, 1.0, &entries);
    out.rhs.middleRows<kOrder>(place.segment) +=
        row.transpose() * values.row(static_cast<Eigen::Index>(i));
  }
  const Eigen::RowVector4d third_difference(-1, 3, -3, 1);
  for (Eigen::Index i = 0; i + 3 < n; ++i) {
    AddOuterProduct(third_difference, i, regularisation, &entries);
  }
  out.normal.resize(n, n);
  out.normal.setFromTriplets(entries.begin(), entries.end());
  return out;
}

}  // namespace

std::optional<std::string> SplineOptions::Problem() const {
  if (auto problem = CheckPositive("knot_spacing_s", knot_spacing_s)) return problem;
  return CheckPositive("regularisation", regularisation);
}

Result<SplineTrajectory> SplineTrajectory::Fit(const std::vector<TruthSample>& poses,
                                               const SplineOptions& options) {
  if (const auto problem = options.Problem()) return Error{*problem};
  if (const auto problem = FindProblem(poses)) return Error{*problem};
  SplineTrajectory out;
  out.first_ns_ = poses.front().t_ns;
  out.last_ns_ = poses.back().t_ns;
  const double span_s = ToSeconds(out.last_ns_ - out.first_ns_);
  const auto segments = static_cast<Eigen::Index>(
      std::ceil(span_s / ChooseSpacing(poses, options.knot_spacing_s) - 1e-9));
  out.spacing_s_ = span_s / static_cast<double>(segments);

  const NormalEquations equations =
      MakeNormalEquations(poses, out.spacing_s_, segments, options.regularisation);
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver(equations.normal);
  if (solver.info() != Eigen::Success) return Error{"the poses do not determine a smooth path"};
  out.controls_ = solver.solve(equations.rhs);
  return out;
}

Eigen::Matrix<double, 7, 1> SplineTrajectory::Evaluate(int64_t t_ns, int derivative) const {
  const Place place =
      FindPlace(ToSeconds(t_ns - first_ns_), spacing_s_, controls_.rows() - (kOrder - 1));
  return (Basis(place.u, derivative) * controls_.middleRows<kOrder>(place.segment)).transpose() /
         std::pow(spacing_s_, derivative);
}

BodyState SplineTrajectory::At(int64_t t_ns) const {
  const Eigen::Matrix<double, 7, 1> value = Evaluate(t_ns, 0), rate = Evaluate(t_ns, 1);
  const Eigen::Quaterniond q(Eigen::Vector4d(value.tail<4>()));
  const Eigen::Quaterniond dq(Eigen::Vector4d(rate.tail<4>()));
  BodyState out;
  out.world_from_body = MakePose(q, value.head<3>());
  out.twist.v_world = rate.head<3>();
  out.twist.omega_body = 2.0 * (q.conjugate() * dq).vec() / q.squaredNorm();
  return out;
}

Eigen::Vector3d SplineTrajectory::AccelerationAt(int64_t t_ns) const {
  return Evaluate(t_ns, 2).head<3>();
}

}  // namespace tagtwist

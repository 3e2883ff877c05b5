#pragma once
#include <Eigen/Core>

namespace tagtwist::internal {

/// Half a sum of squares about a reference, in the tangent there: at x = reference [+] d it is
///   cost + d'(gradient + hessian d / 2).
/// N entries of d, Eigen::Dynamic where only the run knows. Reference: any type with a function
/// Difference(x, reference) that gives d; none where the reference is kept elsewhere.
struct NoReference {};
template <int N, typename Reference = NoReference>
struct QuadraticForm {
  using Matrix = Eigen::Matrix<double, N, N>;
  using Vector = Eigen::Matrix<double, N, 1>;

  Reference reference = {};
  Matrix hessian = Zero<Matrix>();
  Vector gradient = Zero<Vector>();
  double cost = 0;

  /// The gradient at reference [+] d; what the form is there is added to *cost_sum.
  Vector GradientAtMoved(const Vector& d, double* cost_sum) const {
    const Vector moved = hessian * d;
    *cost_sum += cost + d.dot(gradient + 0.5 * moved);
    return gradient + moved;
  }
  /// The same at x.
  Vector GradientAt(const Reference& x, double* cost_sum) const {
    return GradientAtMoved(Difference(x, reference), cost_sum);
  }
  /// Adds weighted residuals, half of whose sum of squares is `half_squares`, by their Jacobian.
  template <typename Jacobian, typename Residual>
  void Add(const Eigen::MatrixBase<Jacobian>& jacobian, const Eigen::MatrixBase<Residual>& residual,
           double half_squares, double weight = 1) {
    // Eigen's blocked products lose time on matrices this small.
    hessian += weight * jacobian.transpose().lazyProduct(jacobian);
    gradient += weight * jacobian.transpose().lazyProduct(residual);
    cost += half_squares;
  }

 private:
  template <typename Zeros>
  static Zeros Zero() {
    if constexpr (N == Eigen::Dynamic) {
      return {};
    } else {
      return Zeros::Zero();
    }
  }
};

}  // namespace tagtwist::internal

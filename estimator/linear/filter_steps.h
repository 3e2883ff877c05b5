#pragma once
#include <Eigen/Core>
#include <cstddef>

#include "estimator/linear/filter_layout.h"
#include "estimator/linear/lanes.h"

/// What is done to as many filters as there are lanes. `filters` is the first entry of the first of
/// them, `i` its index.
namespace tagtwist::internal::filter_steps {

/// First entries of the blocks of x.
inline constexpr int kOfX[3] = {FilterLayout::kXx, FilterLayout::kXv, FilterLayout::kXa};

template <int kLanes, int kCount>
TAGTWIST_INLINE void Load(const double* filters, int first,
                          typename Lanes<kLanes>::Vector (&out)[kCount]) {
  using Part = typename Lanes<kLanes>::InMemory;
  for (int i = 0; i < kCount; ++i) {
    out[i] =
        reinterpret_cast<const Part*>(filters + static_cast<int>(FilterLayout::kSide) * (first + i))
            ->lanes;
  }
}

template <int kLanes, int kCount>
TAGTWIST_INLINE void Store(const typename Lanes<kLanes>::Vector (&in)[kCount], int first,
                           double* filters) {
  using Part = typename Lanes<kLanes>::InMemory;
  for (int i = 0; i < kCount; ++i) {
    reinterpret_cast<Part*>(filters + static_cast<int>(FilterLayout::kSide) * (first + i))->lanes =
        in[i];
  }
}

// Entries of a block are by columns.
TAGTWIST_INLINE constexpr int Transposed(int entry) { return 3 * (entry % 3) + entry / 3; }

// F, upper triangular, and Q of an axis.
struct PredictStep {
  const Eigen::Matrix3d &f, &q;
  const double* densities;

  template <int kLanes>
  TAGTWIST_INLINE void Do(size_t i, double* filters) const {
    using V = typename Lanes<kLanes>::Vector;
    const double a = f.data()[3], b = f.data()[6], c = f.data()[7];
    const double d0 = f.data()[0], d1 = f.data()[4], d2 = f.data()[8];
    V mean[9], in[6][9], out[6][9];
    Load<kLanes>(filters, 0, mean);
    for (int j = 0; j < 6; ++j) Load<kLanes>(filters, FilterLayout::kXx + 9 * j, in[j]);
    for (int k = 0; k < 3; ++k) {
      mean[k] = d0 * mean[k] + a * mean[3 + k] + b * mean[6 + k];
      mean[3 + k] = d1 * mean[3 + k] + c * mean[6 + k];
      mean[6 + k] = d2 * mean[6 + k];
    }
    Store<kLanes>(mean, 0, filters);
    const auto &xx = in[0], &xv = in[1], &xa = in[2], &vv = in[3], &va = in[4], &aa = in[5];
    for (int k = 0; k < 9; ++k) {
      const int t = Transposed(k);
      const V two_va = va[k] + va[t];
      out[0][k] = d0 * d0 * xx[k] + d0 * a * (xv[k] + xv[t]) + d0 * b * (xa[k] + xa[t]) +
                  a * a * vv[k] + a * b * two_va + b * b * aa[k];
      out[1][k] = d0 * d1 * xv[k] + d0 * c * xa[k] + a * d1 * vv[k] + a * c * va[k] +
                  b * d1 * va[t] + b * c * aa[k];
      out[2][k] = d2 * (d0 * xa[k] + a * va[k] + b * aa[k]);
      out[3][k] = d1 * d1 * vv[k] + c * d1 * two_va + c * c * aa[k];
      out[4][k] = d2 * (d1 * va[k] + c * aa[k]);
      out[5][k] = d2 * d2 * aa[k];
    }
    const V density =
        reinterpret_cast<const typename Lanes<kLanes>::InMemory*>(densities + i)->lanes;
    constexpr int kOfBlock[6] = {0, 3, 6, 4, 7, 8};  // Q's entries
    for (int j = 0; j < 6; ++j) {
      for (int k = 0; k < 9; k += 4) out[j][k] += q.data()[kOfBlock[j]] * density;
      Store<kLanes>(out[j], FilterLayout::kXx + 9 * j, filters);
    }
  }
};

struct Measured {
  Eigen::Vector3d x;
  Eigen::Matrix3d covariance;
};

// L D L' of a symmetric matrix: L's entries below its diagonal of ones, by columns.
template <class V>
struct Factors {
  V l[3], over_d[3], determinant;

  TAGTWIST_INLINE void Factorise(const V (&m)[9]) {
    over_d[0] = 1 / m[0];
    l[0] = m[1] * over_d[0];
    l[1] = m[2] * over_d[0];
    const V d1 = m[4] - l[0] * m[1], rest = m[5] - l[1] * m[1];
    over_d[1] = 1 / d1;
    l[2] = rest * over_d[1];
    const V d2 = m[8] - l[1] * m[2] - l[2] * rest;
    over_d[2] = 1 / d2;
    determinant = m[0] * d1 * d2;
  }
  // L^-1 times a column.
  TAGTWIST_INLINE void Solve(V* column) const {
    column[1] -= l[0] * column[0];
    column[2] -= l[1] * column[0] + l[2] * column[1];
  }
  // L'^-1 times a column.
  TAGTWIST_INLINE void SolveTransposed(V* column) const {
    column[1] -= l[2] * column[2];
    column[0] -= l[0] * column[1] + l[1] * column[2];
  }
};

// Of a block's entry what is known of it from now on.
template <class V>
TAGTWIST_INLINE void Subtract(const V (&known)[9], const V (&scaled)[9], int k, V* entry) {
  const V *const a = known + 3 * (k % 3), *const b = scaled + 3 * (k / 3);
  *entry -= a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

template <int kLanes>
TAGTWIST_INLINE void LessenSquare(const typename Lanes<kLanes>::Vector (&known)[9],
                                  const typename Lanes<kLanes>::Vector (&scaled)[9], int block,
                                  double* filters) {
  typename Lanes<kLanes>::Vector own[9];
  Load<kLanes>(filters, block, own);
  for (const int k : {0, 1, 2, 4, 5, 8}) {
    const auto least = 1e-14 * own[k];  // where rounding leaves less than none
    Subtract(known, scaled, k, &own[k]);
    if (k % 4 == 0) own[k] = own[k] > least ? own[k] : least;
    own[Transposed(k)] = own[k];
  }
  Store<kLanes>(own, block, filters);
}

// The blocks of x are products, not differences: after a long gap the prediction is no help, and
// differences would be of equals.
template <int kLanes>
TAGTWIST_INLINE void StoreBlockOfX(const double* covariance,
                                   const typename Lanes<kLanes>::Vector (&gain)[9], int block,
                                   double* filters) {
  typename Lanes<kLanes>::Vector out[9];
  for (int k = 0; k < 9; ++k) {
    const double* const row = covariance + k % 3;
    const auto* const column = gain + 3 * (k / 3);
    out[k] = row[0] * column[0] + row[3] * column[1] + row[6] * column[2];
  }
  if (block == FilterLayout::kXx) {
    for (const int k : {1, 2, 5}) out[k] = out[Transposed(k)] = 0.5 * (out[k] + out[Transposed(k)]);
  }
  Store<kLanes>(out, block, filters);
}

struct UpdateStep {
  const Measured& measured;

  template <int kLanes>
  TAGTWIST_INLINE void Do(size_t /*i*/, double* filters) const {
    using V = typename Lanes<kLanes>::Vector;
    const double *const r = measured.covariance.data(), *const x = measured.x.data();
    V mean[9], known[3][9], scaled[3][9], s[9];  // L^-1 P_xi, and D^-1 times it
    Load<kLanes>(filters, 0, mean);
    for (int j = 0; j < 3; ++j) Load<kLanes>(filters, kOfX[j], known[j]);
    for (int k = 0; k < 9; ++k) s[k] = known[0][k] + r[k];
    Factors<V> factors;
    factors.Factorise(s);
    const V error[3] = {x[0] - mean[0], x[1] - mean[1], x[2] - mean[2]};
    V e[3] = {error[0], error[1], error[2]};
    factors.Solve(e);
    const V fit[2] = {e[0] * e[0] * factors.over_d[0] + e[1] * e[1] * factors.over_d[1] +
                          e[2] * e[2] * factors.over_d[2],
                      factors.determinant};
    Store<kLanes>(fit, FilterLayout::kSquare, filters);
    for (int j = 0; j < 3; ++j) {
      V gain[9];
      for (int c = 0; c < 9; c += 3) {
        factors.Solve(known[j] + c);
        for (int k = c; k < c + 3; ++k)
          gain[k] = scaled[j][k] = known[j][k] * factors.over_d[k % 3];
        factors.SolveTransposed(gain + c);
        for (int k = 0; k < 3; ++k) mean[3 * j + c / 3] += gain[c + k] * error[k];
      }
      StoreBlockOfX<kLanes>(r, gain, kOfX[j], filters);
    }
    Store<kLanes>(mean, 0, filters);
    LessenSquare<kLanes>(known[1], scaled[1], FilterLayout::kVv, filters);
    LessenSquare<kLanes>(known[2], scaled[2], FilterLayout::kAa, filters);
    V va[9];
    Load<kLanes>(filters, FilterLayout::kVa, va);
    for (int k = 0; k < 9; ++k) Subtract(known[1], scaled[2], k, &va[k]);
    Store<kLanes>(va, FilterLayout::kVa, filters);
  }
};

// Adds the products of the means, times `sign`: from covariance to second moment, and back.
struct AddSquaresOfMeansStep {
  double sign;

  template <int kLanes>
  TAGTWIST_INLINE void Do(size_t /*i*/, double* filters) const {
    using V = typename Lanes<kLanes>::Vector;
    V mean[9];
    Load<kLanes>(filters, 0, mean);
    for (int i = 0; i < 3; ++i) {
      for (int j = i; j < 3; ++j) {
        V block[9];
        Load<kLanes>(filters, FilterLayout::kBlocks[i][j], block);
        for (int k = 0; k < 9; ++k) block[k] += sign * (mean[3 * i + k % 3] * mean[3 * j + k / 3]);
        Store<kLanes>(block, FilterLayout::kBlocks[i][j], filters);
      }
    }
  }
};

struct TurnStep {
  const Eigen::Matrix3d& rotation;

  // Columns become R times them.
  template <class V>
  TAGTWIST_INLINE void TurnColumns(int n, V* columns) const {
    const double* const r = rotation.data();
    for (V* m = columns; m < columns + 3 * n; m += 3) {
      const V a = m[0], b = m[1], c = m[2];
      for (int i = 0; i < 3; ++i) m[i] = r[i] * a + r[3 + i] * b + r[6 + i] * c;
    }
  }

  template <int kLanes>
  TAGTWIST_INLINE void Do(size_t /*i*/, double* filters) const {
    using V = typename Lanes<kLanes>::Vector;
    V mean[3], block[9], turned[9];
    Load<kLanes>(filters, 0, mean);
    TurnColumns(1, mean);
    Store<kLanes>(mean, 0, filters);
    Load<kLanes>(filters, FilterLayout::kXx, block);
    TurnColumns(3, block);
    for (int k = 0; k < 9; ++k) turned[k] = block[Transposed(k)];
    TurnColumns(3, turned);
    for (const int k : {1, 2, 5}) turned[Transposed(k)] = turned[k];
    Store<kLanes>(turned, FilterLayout::kXx, filters);
    for (const int of : {FilterLayout::kXv, FilterLayout::kXa}) {
      Load<kLanes>(filters, of, block);
      TurnColumns(3, block);
      Store<kLanes>(block, of, filters);
    }
  }
};

}  // namespace tagtwist::internal::filter_steps

#pragma once

// For kernels that are written once and compiled twice: with vectors of two doubles for every
// machine, and with those of four and fused products for machines that have them.
#if defined(__x86_64__)
#define TAGTWIST_WIDE __attribute__((target("avx2,fma")))
#else
#define TAGTWIST_WIDE
#endif
#define TAGTWIST_INLINE inline __attribute__((always_inline))

namespace tagtwist::internal {

/// So many doubles; in memory they may lie anywhere.
template <int kLanes>
struct Lanes;
template <>
struct Lanes<4> {
  using Vector = double __attribute__((vector_size(32)));
  struct __attribute__((packed, may_alias)) InMemory {
    Vector lanes;
  };
};
template <>
struct Lanes<2> {
  using Vector = double __attribute__((vector_size(16)));
  struct __attribute__((packed, may_alias)) InMemory {
    Vector lanes;
  };
};
template <>
struct Lanes<1> {
  using Vector = double;
  struct __attribute__((packed, may_alias)) InMemory {
    Vector lanes;
  };
};

/// Whether this machine has what TAGTWIST_WIDE asks for.
inline const bool kIsWide = [] {
#if defined(__x86_64__)
  return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
#else
  return false;
#endif
}();

}  // namespace tagtwist::internal

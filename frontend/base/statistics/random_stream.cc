#include "frontend/base/statistics/random_stream.h"

#include <cmath>

namespace tagtwist::internal {
namespace {

// The mixing step of SplitMix64 (Steele, Lea, Flood 2014): neighbours in, strangers out.
uint64_t Mix(uint64_t x) {
  x += 0x9e3779b97f4a7c15ULL;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ULL;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebULL;
  return x ^ (x >> 31);
}

}  // namespace

RandomStream::RandomStream(uint64_t seed, uint64_t purpose, uint64_t index)
    : engine_(Mix(Mix(Mix(seed) ^ purpose) ^ index)) {}

double RandomStream::Uniform() { return 0x1p-53 * static_cast<double>(engine_() >> 11); }

// Marsaglia's polar method.
double RandomStream::Normal() {
  if (has_spare_) {
    has_spare_ = false;
    return spare_;
  }
  double x = 0, y = 0, r2 = 0;
  do {
    x = Uniform(-1, 1);
    y = Uniform(-1, 1);
    r2 = x * x + y * y;
  } while (!(r2 < 1) || r2 == 0);
  const double scale = std::sqrt(-2 * std::log(r2) / r2);
  spare_ = scale * y;
  has_spare_ = true;
  return scale * x;
}

uint64_t RandomStream::Below(uint64_t count) {
  return static_cast<uint64_t>(Uniform() * static_cast<double>(count));
}

}  // namespace tagtwist::internal

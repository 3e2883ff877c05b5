#pragma once
#include <cstdint>
#include <random>

namespace tagtwist::internal {

/// Random draws that depend on the given numbers alone, whatever the thread or the standard
/// library: streams of different numbers (seed, purpose, index) are independent.
class RandomStream {
 public:
  explicit RandomStream(uint64_t seed, uint64_t purpose = 0, uint64_t index = 0);

  double Uniform();  // in [0, 1)
  double Uniform(double low, double high) { return low + (high - low) * Uniform(); }
  double Normal();  // mean 0, standard deviation 1
  /// In [0, count); count > 0.
  uint64_t Below(uint64_t count);

 private:
  std::mt19937_64 engine_;
  double spare_ = 0;
  bool has_spare_ = false;
};

}  // namespace tagtwist::internal

#pragma once
#include <cstdint>
#include <optional>
#include <vector>

#include "frontend/types/body_state.h"

namespace tagtwist {

/// Truth at a time: a sample of exactly that stamp as it is; otherwise between its two neighbours,
/// linear in position and twist and slerp in rotation, when they are at most max_gap_s apart.
/// nullopt outside the truth's span (nothing is extrapolated) and in gaps. `truth` grows strictly
/// in time.
std::optional<TruthSample> InterpolateTruth(const std::vector<TruthSample>& truth, int64_t t_ns,
                                            double max_gap_s);

/// Whether there is truth at that time and as far from it as margin_s, before and after: while a
/// clock's offset is searched, it does not fall out of the truth.
bool HasTruthAround(const std::vector<TruthSample>& truth, int64_t t_ns, double margin_s,
                    double max_gap_s);

/// Velocity in the truth's world and body rate by central differences of its poses over +-10 ms:
/// they need no twist in the file, and agree with InterpolateTruth. nullopt near the ends and gaps.
std::optional<Twist> DifferentiateTruth(const std::vector<TruthSample>& truth, int64_t t_ns,
                                        double max_gap_s);

/// Body rates [rad/s, in B] by central differences of the attitudes (one-sided at the ends);
/// zero for a single sample.
std::vector<Eigen::Vector3d> DifferentiateAttitude(const std::vector<TruthSample>& truth);

}  // namespace tagtwist

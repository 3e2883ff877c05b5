#include "frontend/types/truth.h"

#include <algorithm>
#include <cmath>

namespace tagtwist {

std::optional<TruthSample> InterpolateTruth(const std::vector<TruthSample>& truth, int64_t t_ns,
                                            double max_gap_s) {
  const auto after =
      std::lower_bound(truth.begin(), truth.end(), t_ns,
                       [](const TruthSample& sample, int64_t t) { return sample.t_ns < t; });
  if (after == truth.end()) return std::nullopt;
  if (after->t_ns == t_ns) return *after;
  if (after == truth.begin()) return std::nullopt;
  const TruthSample &b = *after, &a = *(after - 1);
  if (!(ToSeconds(b.t_ns - a.t_ns) <= max_gap_s)) return std::nullopt;
  const double w = static_cast<double>(t_ns - a.t_ns) / static_cast<double>(b.t_ns - a.t_ns);
  const auto mix = [w](const Eigen::Vector3d& x, const Eigen::Vector3d& y) {
    return Eigen::Vector3d((1 - w) * x + w * y);
  };
  TruthSample out;
  out.t_ns = t_ns;
  out.world_from_body =
      MakePose(a.world_from_body.rotation().slerp(w, b.world_from_body.rotation()),
               mix(a.world_from_body.translation(), b.world_from_body.translation()));
  if (a.twist && b.twist) {
    out.twist = Twist{mix(a.twist->v_world, b.twist->v_world),
                      mix(a.twist->omega_body, b.twist->omega_body)};
  }
  return out;
}

bool HasTruthAround(const std::vector<TruthSample>& truth, int64_t t_ns, double margin_s,
                    double max_gap_s) {
  const int64_t margin_ns = std::llround(1e9 * margin_s);
  return InterpolateTruth(truth, t_ns, max_gap_s) &&
         InterpolateTruth(truth, t_ns - margin_ns, max_gap_s) &&
         InterpolateTruth(truth, t_ns + margin_ns, max_gap_s);
}

std::optional<Twist> DifferentiateTruth(const std::vector<TruthSample>& truth, int64_t t_ns,
                                        double max_gap_s) {
  constexpr int64_t kStepNs = 10'000'000;
  const auto before = InterpolateTruth(truth, t_ns - kStepNs, max_gap_s);
  const auto after = InterpolateTruth(truth, t_ns + kStepNs, max_gap_s);
  if (!before || !after) return std::nullopt;
  return TwistBetween(before->world_from_body, after->world_from_body, ToSeconds(2 * kStepNs));
}

std::vector<Eigen::Vector3d> DifferentiateAttitude(const std::vector<TruthSample>& truth) {
  std::vector<Eigen::Vector3d> out(truth.size(), Eigen::Vector3d::Zero());
  for (size_t i = 0; truth.size() >= 2 && i < truth.size(); ++i) {
    const TruthSample& before = truth[i == 0 ? 0 : i - 1];
    const TruthSample& after = truth[std::min(i + 1, truth.size() - 1)];
    out[i] = TwistBetween(before.world_from_body, after.world_from_body,
                          ToSeconds(after.t_ns - before.t_ns))
                 .omega_body;
  }
  return out;
}

}  // namespace tagtwist

#include "frontend/pattern/pattern_fit.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace tagtwist::internal {
namespace {

constexpr size_t kLeastPixels = 60;
constexpr int kMostIterations = 12;
constexpr size_t kCoarsePixels = 500;  // are enough until steps are small
constexpr double kNearPx = 0.1;        // a step below this: from here on with all pixels
constexpr double kConvergedPx = 0.03;  // a step below this is the last, its own error far smaller
constexpr double kFollowedPx = 0.05;   // a step below this is the last where the look is known
// Share of the squared residuals that the last step may take away then. More, and residuals
// before it would tell of the start rather than of noise.
constexpr double kMostMisfit = 0.05;
constexpr double kAnotherTag = 0.2;         // contradicted at the start: not that tag, or not there
constexpr double kMostStepPx = 1.0;         // of a corner
constexpr double kMostStretch = 1.25;       // of a step
constexpr double kTukey = 6;                // residuals beyond that many deviations do not count
constexpr double kLeastFitNoiseGrey = 0.5;  // 8-bit steps and what the model leaves out
constexpr double kLeastContrastGrey = 8;
constexpr double kBlurPriorPx2 = 1.0;  // standard deviation: holds it where few pixels show it

using Normal = Eigen::Matrix<double, kPatternUnknowns, kPatternUnknowns>;
using Matrix8d = Eigen::Matrix<double, 8, 8>;

// Black and white from the darkest and the brightest pixels; both make up a third of any tag.
void StartGreys(const PatternPixels& pixels, PatternState* state) {
  std::array<size_t, 256> counts{};
  for (const float grey : pixels.grey) ++counts[static_cast<size_t>(grey)];
  const size_t eighth = pixels.size() / 8;
  size_t dark = 0, bright = 255;
  for (size_t n = counts[dark]; n <= eighth; n += counts[dark]) ++dark;
  for (size_t n = counts[bright]; n <= eighth; n += counts[bright]) --bright;
  state->black = static_cast<double>(dark);
  state->gain = static_cast<double>(bright) - state->black;
}

std::optional<PatternState> StartState(const PatternPixels& pixels, const PatternStart& start) {
  PatternState state;
  const auto& corners = start.corners;
  const auto tag_from_pixel = TagFromPixel(corners);
  if (!tag_from_pixel || pixels.size() < kLeastPixels) return std::nullopt;
  state.tag_from_pixel = *tag_from_pixel;
  state.origin = 0.25 * (corners[0] + corners[1] + corners[2] + corners[3]);
  for (const auto& corner : corners) {
    state.radius_px = std::max(state.radius_px, (corner - state.origin).norm());
  }
  if (start.look) {
    state.blur_px2 = start.look->blur_px2;
    state.light = start.look->light;
    state.black = start.look->black;
    state.gain = start.look->gain;
  } else {
    StartGreys(pixels, &state);
  }
  if (!(state.gain >= kLeastContrastGrey)) return std::nullopt;
  return state;
}

double ContradictedShare(const PatternSums& sums) {
  return static_cast<double>(sums.contradicted) / static_cast<double>(sums.used);
}

double LargestShift(const Eigen::Matrix<double, 8, 1>& shift) {
  double out = 0;
  for (int i = 0; i < 4; ++i) out = std::max(out, shift.segment<2>(2 * i).norm());
  return out;
}

// What residuals that go together with their neighbours' (compression, resampling, a blur or paper
// unlike the model's) do to the variance: 1 + 2 (rho_1 + rho_2) along each axis of the image, the
// columns taken to be like the rows. White noise gives 1.
double CorrelationFactor(const PatternSums& sums) {
  double factor = 1;
  for (size_t lag = 0; lag < sums.lagged.size(); ++lag) {
    if (!(sums.paired[lag] > 0)) continue;
    const double pairs = static_cast<double>(sums.used) * sums.paired[lag] / sums.psi2;
    factor += 2 * std::max(sums.lagged[lag] / sums.paired[lag] - 2 / std::sqrt(pairs), 0.0);
  }
  return factor * factor;
}

PatternFit Finish(const PatternState& state, const PatternSums& sums,
                  const Eigen::LDLT<Normal>& solver) {
  PatternFit fit;
  fit.state = state;
  fit.noise_grey = sums.noise_grey;
  fit.inlier_share = sums.weight / static_cast<double>(sums.used);
  fit.contradicted_share = ContradictedShare(sums);
  Matrix8d d_corners;
  fit.corners = PatternCorners(state, &d_corners);
  const double freedom = sums.weight / std::max(sums.weight - kPatternUnknowns, 1.0);
  const double variance = sums.psi2 * sums.weight / (sums.d_psi * sums.d_psi) * freedom;
  const Normal inverse = solver.solve(Normal::Identity());
  fit.covariance = std::max(variance, kLeastFitNoiseGrey * kLeastFitNoiseGrey) *
                   CorrelationFactor(sums) * d_corners * inverse.topLeftCorner<8, 8>() *
                   d_corners.transpose();
  return fit;
}

}  // namespace

std::optional<PatternFit> FitPattern(const PatternModel& model, const NormalTable& normal,
                                     const PatternPixels& pixels, const PatternStart& start) {
  auto state = StartState(pixels, start);
  if (!state) return std::nullopt;
  double noise_grey = start.look ? start.look->noise_grey : 0.12 * state->gain;
  const bool coarse = !start.look || start.rough;
  size_t stride = coarse ? std::max<size_t>(pixels.size() / kCoarsePixels, 1) : 1;
  for (int iteration = 1; iteration <= kMostIterations; ++iteration) {
    const PatternSums sums = SumPattern(model, normal, pixels, *state, kTukey * noise_grey, stride);
    if (!(sums.weight > kLeastPixels / 2) || !(sums.d_psi > 0)) return std::nullopt;
    Normal matrix = sums.normal;
    const double prior = noise_grey * noise_grey / (kBlurPriorPx2 * kBlurPriorPx2);
    for (int i = 8; i < 11; ++i) matrix(i, i) += prior;
    if (start.look && ContradictedShare(sums) > kAnotherTag) return std::nullopt;
    const Eigen::LDLT<Normal> solver(matrix);
    PatternVector step = solver.solve(sums.gradient);
    if (solver.info() != Eigen::Success || !step.allFinite()) return std::nullopt;
    const double gain_of_step = step.dot(sums.gradient);
    // Weighted least squares alone leaves a tenth of the way: the sums' curvature is that of psi'.
    step *= std::clamp(sums.weight / sums.d_psi, 1.0, kMostStretch);
    Matrix8d d_corners;
    PatternCorners(*state, &d_corners);
    const double shift = LargestShift(d_corners * step.head<8>());
    if (shift > kMostStepPx) step.head<8>() *= kMostStepPx / shift;
    *state = Move(*state, step);
    if (!(state->gain >= kLeastContrastGrey)) return std::nullopt;
    const bool settled = start.look ? shift < kFollowedPx && gain_of_step < kMostMisfit * sums.psi2
                                    : shift < kConvergedPx && iteration > 2;
    if (settled && stride == 1) {
      PatternFit fit = Finish(*state, sums, solver);
      fit.iterations = iteration;
      return fit;
    }
    if (start.look || (shift < kNearPx && iteration > 1)) stride = 1;
    noise_grey = sums.noise_grey;
    if (iteration == 1 && !start.look) noise_grey = std::max(noise_grey, 0.05 * state->gain);
  }
  return std::nullopt;
}

}  // namespace tagtwist::internal

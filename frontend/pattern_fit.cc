#include "frontend/pattern_fit.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace tagtwist {
namespace {

constexpr size_t kLeastPixels = 60;
constexpr int kMostIterations = 12;
constexpr size_t kCoarsePixels = 500;    // are enough until steps are small
constexpr double kNearPx = 0.1;          // a step below this: from here on with all pixels
constexpr double kConvergedPx = 0.03;    // a step below this is the last, its own error far smaller
constexpr double kMostStepPx = 1.0;      // of a corner
constexpr double kTukey = 6;             // residuals beyond that many deviations do not count
constexpr double kLeastNoiseGrey = 0.5;  // 8-bit steps and what the model leaves out
constexpr double kLeastContrastGrey = 8;
constexpr double kBlurPriorPx2 = 1.0;  // standard deviation: holds it where few pixels show it

using Normal = Eigen::Matrix<double, kPatternUnknowns, kPatternUnknowns>;
using Matrix8d = Eigen::Matrix<double, 8, 8>;

// Weighted sums over the pixels at one state.
struct Sums {
  std::array<PatternRow, kPatternUnknowns> products{};  // lower triangle of sum w row row'
  PatternRow gradient{};                                // sum w row residual
  double weight = 0, psi2 = 0, d_psi = 0;
  std::array<double, 2> lagged{};  // sum psi psi' over pixels one and two apart in a row
  size_t used = 0, contradicted = 0;
};

// A pixel amid a cell (no derivative by place or blur) tells of greys alone.
void Add(const PatternRow& row, float weight, float residual, Sums* sums) {
  const bool flat = row[2] == 0 && row[5] == 0 && row[8] == 0 && row[10] == 0;
  const size_t first = flat ? 8 : 0;
  const float pull = weight * residual;
  for (size_t k = first; k < row.size(); ++k) sums->gradient[k] += pull * row[k];
  for (size_t block = first; block < row.size(); block += 4) {
    for (size_t i = block; i < block + 4; ++i) {
      const float scaled = weight * row[i];
      float* const out = sums->products[i].data();
      for (size_t k = first; k < block + 4; ++k) out[k] += scaled * row[k];
    }
  }
}

// A pixel at the sensor's end tells a bound only.
double Residual(double grey, double predicted) {
  if (grey >= 255 && predicted > 255) return 0;
  if (grey <= 0 && predicted < 0) return 0;
  return grey - predicted;
}

Sums Accumulate(const PatternModel& model, const NormalTable& normal,
                const std::vector<PatternPixel>& pixels, const PatternState& state,
                double noise_grey, size_t stride, std::vector<float>* magnitudes) {
  Sums sums;
  magnitudes->clear();
  const double reach = kTukey * noise_grey;
  PatternRow row;
  std::array<double, 2> last_psi{};  // of the pixel before and the one before that
  for (size_t i = 0; i < pixels.size(); i += stride) {
    if (i > 0 && !(std::abs(pixels[i].at.x() - pixels[i - 1].at.x() - 1) < 0.5)) last_psi = {};
    const double predicted = PredictGrey(model, state, normal, pixels[i].at, &row);
    const double residual = Residual(pixels[i].grey, predicted);
    const double magnitude = std::abs(residual);
    magnitudes->push_back(static_cast<float>(magnitude));
    sums.contradicted += magnitude > 0.5 * state.gain ? 1 : 0;
    ++sums.used;
    if (!(magnitude < reach)) {
      last_psi = {0, last_psi[0]};
      continue;
    }
    const double x2 = (residual / reach) * (residual / reach);
    const double weight = (1 - x2) * (1 - x2);
    sums.weight += weight;
    const double psi = weight * residual;
    for (size_t lag = 0; lag < 2; ++lag) sums.lagged[lag] += psi * last_psi[lag];
    last_psi = {psi, last_psi[0]};
    sums.psi2 += psi * psi;
    sums.d_psi += (1 - x2) * (1 - 5 * x2);
    Add(row, static_cast<float>(weight), static_cast<float>(residual), &sums);
  }
  return sums;
}

double NoiseFromMagnitudes(std::vector<float>* magnitudes) {
  const auto middle = magnitudes->begin() + static_cast<std::ptrdiff_t>(magnitudes->size() / 2);
  std::nth_element(magnitudes->begin(), middle, magnitudes->end());
  return std::max(1.4826 * static_cast<double>(*middle), kLeastNoiseGrey);
}

// Black and white from the darkest and the brightest pixels; both make up a third of any tag.
bool StartGreys(const std::vector<PatternPixel>& pixels, std::vector<float>* greys,
                PatternState* state) {
  greys->clear();
  for (const PatternPixel& pixel : pixels) greys->push_back(static_cast<float>(pixel.grey));
  const auto eighth = static_cast<std::ptrdiff_t>(greys->size() / 8);
  std::nth_element(greys->begin(), greys->begin() + eighth, greys->end());
  state->black = static_cast<double>((*greys)[static_cast<size_t>(eighth)]);
  std::nth_element(greys->begin(), greys->end() - eighth, greys->end());
  state->gain = static_cast<double>(*(greys->end() - eighth)) - state->black;
  return state->gain >= kLeastContrastGrey;
}

std::optional<PatternState> StartState(const std::vector<PatternPixel>& pixels,
                                       const std::array<Eigen::Vector2d, 4>& corners,
                                       std::vector<float>* scratch) {
  PatternState state;
  const auto tag_from_pixel = TagFromPixel(corners);
  if (!tag_from_pixel || pixels.size() < kLeastPixels) return std::nullopt;
  state.tag_from_pixel = *tag_from_pixel;
  state.origin = 0.25 * (corners[0] + corners[1] + corners[2] + corners[3]);
  for (const auto& corner : corners) {
    state.radius_px = std::max(state.radius_px, (corner - state.origin).norm());
  }
  if (!StartGreys(pixels, scratch, &state)) return std::nullopt;
  return state;
}

Normal NormalMatrix(const Sums& sums) {
  Normal out;
  for (int i = 0; i < kPatternUnknowns; ++i) {
    for (int k = 0; k <= i; ++k) {
      out(i, k) = out(k, i) =
          static_cast<double>(sums.products[static_cast<size_t>(i)][static_cast<size_t>(k)]);
    }
  }
  return out;
}

PatternVector Gradient(const Sums& sums) {
  PatternVector out;
  for (int k = 0; k < kPatternUnknowns; ++k) {
    out[k] = static_cast<double>(sums.gradient[static_cast<size_t>(k)]);
  }
  return out;
}

double LargestShift(const Eigen::Matrix<double, 8, 1>& shift) {
  double out = 0;
  for (int i = 0; i < 4; ++i) out = std::max(out, shift.segment<2>(2 * i).norm());
  return out;
}

// What residuals that go together with their neighbours' (compression, resampling, a blur or paper
// unlike the model's) do to the variance: 1 + 2 (rho_1 + rho_2) along each axis of the image, the
// columns taken to be like the rows. White noise gives 1.
double CorrelationFactor(const Sums& sums) {
  double factor = 1;
  for (const double lagged : sums.lagged) {
    const double chance = 2 / std::sqrt(static_cast<double>(sums.used));
    factor += 2 * std::max(lagged / sums.psi2 - chance, 0.0);
  }
  return factor * factor;
}

PatternFit Finish(const PatternState& state, const Sums& sums, const Eigen::LDLT<Normal>& solver,
                  double noise_grey) {
  PatternFit fit;
  fit.state = state;
  fit.noise_grey = noise_grey;
  const auto used = static_cast<double>(sums.used);
  fit.inlier_share = sums.weight / used;
  fit.contradicted_share = static_cast<double>(sums.contradicted) / used;
  Matrix8d d_corners;
  fit.corners = PatternCorners(state, &d_corners);
  const double freedom = sums.weight / std::max(sums.weight - kPatternUnknowns, 1.0);
  const double variance = sums.psi2 * sums.weight / (sums.d_psi * sums.d_psi) * freedom;
  const Normal inverse = solver.solve(Normal::Identity());
  fit.covariance = std::max(variance, kLeastNoiseGrey * kLeastNoiseGrey) * CorrelationFactor(sums) *
                   d_corners * inverse.topLeftCorner<8, 8>() * d_corners.transpose();
  return fit;
}

}  // namespace

std::optional<PatternFit> FitPattern(const PatternModel& model, const NormalTable& normal,
                                     const std::vector<PatternPixel>& pixels,
                                     const std::array<Eigen::Vector2d, 4>& start) {
  std::vector<float> magnitudes;
  magnitudes.reserve(pixels.size());
  auto state = StartState(pixels, start, &magnitudes);
  if (!state) return std::nullopt;
  double noise_grey = 0.12 * state->gain;
  const size_t coarse = std::max<size_t>(pixels.size() / kCoarsePixels, 1);
  size_t stride = coarse;
  for (int iteration = 1; iteration <= kMostIterations; ++iteration) {
    const Sums sums = Accumulate(model, normal, pixels, *state, noise_grey, stride, &magnitudes);
    if (!(sums.weight > kLeastPixels / 2) || !(sums.d_psi > 0)) return std::nullopt;
    Normal matrix = NormalMatrix(sums);
    const double prior = noise_grey * noise_grey / (kBlurPriorPx2 * kBlurPriorPx2);
    for (int i = 8; i < 11; ++i) matrix(i, i) += prior;
    const Eigen::LDLT<Normal> solver(matrix);
    PatternVector step = solver.solve(Gradient(sums));
    if (solver.info() != Eigen::Success || !step.allFinite()) return std::nullopt;
    Matrix8d d_corners;
    PatternCorners(*state, &d_corners);
    const double shift = LargestShift(d_corners * step.head<8>());
    if (shift > kMostStepPx) step.head<8>() *= kMostStepPx / shift;
    *state = Move(*state, step);
    if (!(state->gain >= kLeastContrastGrey)) return std::nullopt;
    if (shift < kConvergedPx && iteration > 2 && stride == 1) {
      PatternFit fit = Finish(*state, sums, solver, noise_grey);
      fit.iterations = iteration;
      return fit;
    }
    if (shift < kNearPx && iteration > 1) stride = 1;
    noise_grey = NoiseFromMagnitudes(&magnitudes);
    if (iteration == 1) noise_grey = std::max(noise_grey, 0.05 * state->gain);
  }
  return std::nullopt;
}

}  // namespace tagtwist

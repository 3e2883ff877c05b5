#include "frontend/pattern/pattern_fit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "frontend/base/statistics/random_stream.h"
#include "frontend/types/tag_family.h"

namespace tagtwist::internal::pattern_fit_test {
namespace {

using Corners = std::array<Eigen::Vector2d, 4>;

// A tag of a known state, and what a camera sees of it with Gaussian noise.
struct Scene {
  PatternModel model = PatternModel(MakeTagPatterns("tag36h11", {5})->front());
  NormalTable normal;
  Corners corners = {{{11, 42}, {37, 45}, {41, 14}, {13, 12}}};
  PatternState state;

  Scene() {
    state.tag_from_pixel = *TagFromPixel(corners);
    state.origin = {25, 27};
    state.radius_px = 20;
    state.blur_px2 = {0.6, 0.05, 0.5};
    state.black = 40;
    state.gain = 150;
  }
  PatternPixels Pixels(double noise_grey, unsigned seed) const {
    RandomStream random(seed);
    PatternPixels out;
    out.origin = state.origin;
    for (int y = 8; y < 50; ++y) {
      for (int x = 6; x < 46; ++x) {
        const double grey = PredictGrey(model, state, normal, Eigen::Vector2d(x, y), nullptr);
        out.Add(x, y,
                static_cast<uint8_t>(
                    std::clamp(std::round(grey + noise_grey * random.Normal()), 0.0, 255.0)));
      }
    }
    return out;
  }
  PatternStart OffBy(double px) const {
    PatternStart out;
    out.corners = corners;
    out.corners[0] += Eigen::Vector2d(px, -px);
    out.corners[2] += Eigen::Vector2d(-px, -0.5 * px);
    return out;
  }
};

TEST(PatternFit, FindsTheCornersFromHalfACellAway) {
  const Scene scene;
  const auto fit = FitPattern(scene.model, scene.normal, scene.Pixels(1, 3), scene.OffBy(1));
  ASSERT_TRUE(fit);
  for (size_t c = 0; c < 4; ++c) EXPECT_LT((fit->corners[c] - scene.corners[c]).norm(), 0.08) << c;
  EXPECT_NEAR(fit->state.black, scene.state.black, 2);
  EXPECT_NEAR(fit->state.gain, scene.state.gain, 3);
  EXPECT_NEAR(fit->noise_grey, std::sqrt(1 + 1.0 / 12), 0.2);
  EXPECT_GT(fit->inlier_share, 0.8);
  EXPECT_LT(fit->contradicted_share, 0.01);
}

// Mean of the squared errors in standard deviations, over all coordinates of 40 fits.
TEST(PatternFit, ItsCovarianceIsThatOfItsErrors) {
  const Scene scene;
  constexpr int kFits = 40;
  double nees = 0;
  for (unsigned seed = 1; seed <= kFits; ++seed) {
    const auto fit = FitPattern(scene.model, scene.normal, scene.Pixels(3, seed), scene.OffBy(0.5));
    ASSERT_TRUE(fit) << seed;
    Eigen::Matrix<double, 8, 1> error;
    for (int c = 0; c < 4; ++c) {
      const auto i = static_cast<size_t>(c);
      error.segment<2>(2 * c) = fit->corners[i] - scene.corners[i];
    }
    nees += error.cwiseAbs2().cwiseQuotient(fit->covariance.diagonal()).sum() / (8 * kFits);
  }
  EXPECT_GT(nees, 0.6);
  EXPECT_LT(nees, 1.5);
}

TEST(PatternFit, WithoutContrastThereIsNone) {
  Scene scene;
  const PatternStart start = scene.OffBy(0.3);
  scene.state.gain = 0;
  EXPECT_FALSE(FitPattern(scene.model, scene.normal, scene.Pixels(1, 3), start));
}

}  // namespace
}  // namespace tagtwist::internal::pattern_fit_test

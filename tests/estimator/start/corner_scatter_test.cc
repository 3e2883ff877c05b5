#include "estimator/start/corner_scatter.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace tagtwist::internal::corner_scatter_test {
namespace {

std::vector<FrameMeasurements> FramesOf(size_t n_frames, size_t n_tags) {
  std::vector<FrameMeasurements> out(n_frames);
  for (FrameMeasurements& frame : out) frame.tags.resize(n_tags);
  return out;
}

// Misfits of tags whose corners have the deviation sigma_px(frame).
template <typename SigmaPx>
std::vector<std::vector<double>> DrawMisfits(size_t n_frames, size_t n_tags, unsigned seed,
                                             const SigmaPx& sigma_px) {
  std::mt19937_64 rng(seed);
  std::normal_distribution<double> normal;
  std::vector<std::vector<double>> out(n_frames, std::vector<double>(n_tags));
  for (size_t k = 0; k < n_frames; ++k) {
    for (double& misfit : out[k]) misfit = sigma_px(k) * std::hypot(normal(rng), normal(rng));
  }
  return out;
}

double OwnPx2(const FrameMeasurements& frame) {
  const auto& own = frame.tags[0].covariance;
  return own ? (*own)(0, 0) : 0;
}

TEST(CornerScatter, LeavesWhatScattersEvenlyAsItIs) {
  for (const size_t n_tags : {1U, 4U, 16U}) {
    size_t widened = 0;
    for (unsigned seed = 1; seed <= 5; ++seed) {
      auto frames = FramesOf(600, n_tags);
      const double sigma_px = 0.1 + 0.05 * seed;
      WidenScattered(DrawMisfits(600, n_tags, seed, [&](size_t) { return sigma_px; }), &frames);
      for (const FrameMeasurements& frame : frames) widened += OwnPx2(frame) > 0 ? 1 : 0;
    }
    EXPECT_LT(widened, 30U) << n_tags;  // of 3000
  }
}

TEST(CornerScatter, FindsFramesThatScatterFourTimesAsFar) {
  for (const size_t n_tags : {1U, 4U}) {
    for (const bool at_first : {true, false}) {
      const auto is_noisy = [&](size_t k) { return at_first ? k < 200 : k >= 250 && k < 450; };
      auto frames = FramesOf(600, n_tags);
      WidenScattered(DrawMisfits(600, n_tags, 7, [&](size_t k) { return is_noisy(k) ? 0.8 : 0.2; }),
                     &frames);
      double noisy = 0;
      size_t quiet = 0;
      for (size_t k = 0; k < frames.size(); ++k) {
        if (is_noisy(k)) noisy += OwnPx2(frames[k]) / 200;
        if (!is_noisy(k)) quiet += OwnPx2(frames[k]) > 0.2 * 0.2 ? 1 : 0;
      }
      EXPECT_GT(noisy, 0.6 * 0.6) << n_tags << " tags, at first " << at_first;
      EXPECT_LT(noisy, 1.1 * 1.1) << n_tags << " tags, at first " << at_first;
      EXPECT_LT(quiet, 30U) << n_tags << " tags, at first " << at_first;
    }
  }
}

TEST(CornerScatter, OneTagThatLiesFarOffIsWideAlone) {
  auto misfits = DrawMisfits(300, 6, 3, [](size_t) { return 0.2; });
  misfits[200][2] = 3;
  auto frames = FramesOf(300, 6);
  WidenScattered(misfits, &frames);
  ASSERT_TRUE(frames[200].tags[2].covariance);
  EXPECT_NEAR((*frames[200].tags[2].covariance)(5, 5), 4.5, 0.2);
  EXPECT_FALSE(frames[200].tags[1].covariance);
}

TEST(CornerScatter, CornersThatAreKnownAreNotJudged) {
  EstimatorSetup setup;
  std::vector<TagDetection> tags(2);
  EXPECT_TRUE(IsJudgedByShape(setup, tags));
  tags[1].covariance = Eigen::Matrix<double, 8, 8>(Eigen::Matrix<double, 8, 8>::Identity());
  EXPECT_FALSE(IsJudgedByShape(setup, tags));
  tags[1].covariance.reset();
  setup.options.corner_sigma_px = 0.3;
  EXPECT_FALSE(IsJudgedByShape(setup, tags));
}

}  // namespace
}  // namespace tagtwist::internal::corner_scatter_test

#include "tests/support/situations/phantoms.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "estimator/batch/batch.h"
#include "tests/support/flights/exact_model.h"
#include "tests/support/situations/situations.h"

namespace tagtwist::internal::phantoms_test {
namespace {

// Two tags in view, none for up to 1.5 s again and again, and a phantom in one frame of seven.
SituationDraw PhantomsInGaps(unsigned seed) {
  constexpr double kRateHz = 10;
  SituationDraw out = DrawSituation(Situation::kSmooth, seed, kRateHz);
  Rng rng(77 * seed + 1);
  double from_s = 3, length_s = Draw(&rng, 0.4, 1.5);
  const double between_s = Draw(&rng, 0.5, 2);
  for (size_t k = 0; k < out.measurements.size(); ++k) {
    const double t_s = static_cast<double>(k) / kRateHz;
    std::vector<TagDetection>& tags = out.measurements[k].tags;
    tags.resize(std::min<size_t>(tags.size(), 2));
    if (t_s > from_s && t_s < from_s + length_s) tags.clear();
    if (t_s >= from_s + length_s) {
      from_s += length_s + between_s;
      length_s = Draw(&rng, 0.4, 1.5);
    }
    if (Draw(&rng, 0, 1) < 0.15) AddPhantom(out.setup.map, &rng, &tags);
  }
  return out;
}

// Nothing beside a phantom contradicts it there, and the densities learned with it allow the way.
TEST(Phantoms, SlowInGapsAreNotBelieved) {
  for (const unsigned seed : {33U, 35U}) {
    const SituationDraw draw = PhantomsInGaps(seed);
    const auto out = RunBatch(SetUpOf(draw.setup), {}, draw.measurements);
    ASSERT_TRUE(out) << out.error().message;
    const SituationScore score = Judge(draw, out->frames);
    EXPECT_LT(score.nees, 2) << seed;
    EXPECT_EQ(score.beyond, 0) << seed;
  }
}

}  // namespace
}  // namespace tagtwist::internal::phantoms_test

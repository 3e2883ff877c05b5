#include "estimator/start/doubled_tags.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "estimator/batch/batch.h"
#include "frontend/tags/filter_tags.h"
#include "tests/support/flights/exact_model.h"
#include "tests/support/situations/situations.h"

namespace tagtwist::internal::doubled_tags_test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

TagDetection TagAt(int id, double x, double y, double side = 20) {
  TagDetection tag;
  tag.id = id;
  tag.corners = {Eigen::Vector2d(x, y + side), {x + side, y + side}, {x + side, y}, {x, y}};
  return tag;
}

TEST(DoubledIds, AreOfTheMapAndApart) {
  const TagMap map = MakeTagMap(TagGrid());
  EXPECT_THAT(DoubledIds({TagAt(7, 10, 10), TagAt(5, 50, 50), TagAt(7, 90, 10), TagAt(5, 90, 90),
                          TagAt(5, 130, 90), TagAt(500, 10, 90), TagAt(500, 90, 130)},
                         map),
              ElementsAre(5, 7));
  // One tag, told twice.
  EXPECT_THAT(DoubledIds({TagAt(7, 10, 10), TagAt(7, 12, 12, 16)}, map), ElementsAre());
}

FrameMeasurements Frame(const std::vector<int>& ids, const std::vector<int>& doubled = {}) {
  FrameMeasurements out;
  for (const int id : ids) out.tags.push_back(TagAt(id, 10, 10));
  out.doubled_ids = doubled;
  return out;
}

// By those beside it; not by one alone, of which nobody knows whether it is right.
TEST(DoubledTags, ATagThatIsAlwaysContradictedIsSetAsideUntilTheSolutionBeginsAnew) {
  DoubledTags always, now_and_then, by_one;
  for (int i = 0; i < 60; ++i) {
    EXPECT_FALSE(always.IsLeftOut(1));
    always.AddSolved({2, 3}, {}, {1});
    now_and_then.AddSolved(i % 5 == 0 ? std::vector<int>{1, 2, 3} : std::vector<int>{2, 3}, {},
                           i % 5 == 0 ? std::vector<int>{} : std::vector<int>{1});
    by_one.AddSolved({2}, {}, {1});
  }
  EXPECT_FALSE(now_and_then.IsLeftOut(1));
  EXPECT_FALSE(by_one.IsLeftOut(1));
  EXPECT_TRUE(always.IsLeftOut(1));
  std::vector<TagDetection> tags = Frame({1, 2}).tags;
  always.TakeOutAside(&tags);
  ASSERT_EQ(tags.size(), 1U);
  EXPECT_EQ(tags[0].id, 2);
  ASSERT_EQ(always.AsideWarnings().size(), 1U);
  EXPECT_THAT(always.AsideWarnings()[0],
              HasSubstr("tag 1 was contradicted by those beside it in 60 frames of 60"));
  always.StartAnew();
  EXPECT_FALSE(always.IsLeftOut(1));
}

TEST(DoubledTags, ARuleIsLeftOutAndToldAnAccidentIsNot) {
  DoubledTags accidents, rule;
  for (int i = 0; i < 300; ++i) {
    EXPECT_FALSE(accidents.Add(i % 10 == 0 ? Frame({2}, {1}) : Frame({1, 2})));
  }
  EXPECT_FALSE(accidents.IsLeftOut(1));
  EXPECT_TRUE(accidents.Warnings().empty());
  int told = 0;
  for (int i = 0; i < 6; ++i) told += rule.Add(Frame({2}, {1})) ? 1 : 0;
  EXPECT_EQ(told, 1);
  std::vector<TagDetection> tags = Frame({1, 2}).tags;
  rule.TakeOut(&tags);
  ASSERT_EQ(tags.size(), 1U);
  EXPECT_EQ(tags[0].id, 2);
  ASSERT_EQ(rule.Warnings().size(), 1U);
  EXPECT_THAT(rule.Warnings()[0], HasSubstr("tag 1 is seen at two places at once in 6 frames"));
}

TEST(DoubledTags, WhatLiesElsewhereThanTagsThatAgreedIsLeftOut) {
  DoubledTags tags, unknown;
  for (int i = 0; i < 10; ++i) tags.AddSolved({1, 2}, {});
  const TagElsewhere there{1, {0.5, 0.3}, 0.15};
  for (int i = 0; i < 6; ++i) tags.AddSolved({2}, {there});
  EXPECT_TRUE(tags.IsLeftOut(1));
  EXPECT_FALSE(tags.IsLeftOut(2));
  EXPECT_THAT(tags.Warnings()[0], HasSubstr("tag 1 is seen elsewhere"));
  // Phantoms under the id of a tag that is out of view.
  DoubledTags phantoms;
  for (int i = 0; i < 1000; ++i) {
    const TagElsewhere phantom{3, {std::sin(i), std::cos(i)}, 0.15};
    phantoms.AddSolved({1, 2}, std::vector<TagElsewhere>(i % 10 == 0, phantom));
  }
  EXPECT_FALSE(phantoms.any());
  // Two that never agreed: nobody knows which is right.
  for (int i = 0; i < 50; ++i) unknown.AddSolved({2}, {there});
  EXPECT_FALSE(unknown.any());
}

TEST(DoubledTags, SlowBatchIsNotMisled) {
  for (const unsigned seed : {1U, 2U, 3U}) {
    const SituationDraw draw = DrawSituation(Situation::kTwin, seed);
    const auto out = RunBatch(SetUpOf(draw.setup), draw.setup.options, draw.measurements);
    ASSERT_TRUE(out) << out.error().message;
    const SituationScore score = Judge(draw, out->frames);
    EXPECT_LT(score.nees, 2) << seed;
    EXPECT_LT(score.beyond, 0.01) << seed;
    ASSERT_FALSE(out->warnings.empty());
    EXPECT_THAT(out->warnings[0], HasSubstr("two tags have that id"));
  }
}

}  // namespace
}  // namespace tagtwist::internal::doubled_tags_test

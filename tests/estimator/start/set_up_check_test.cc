#include "estimator/start/set_up_check.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "estimator/start/corner_order.h"
#include "tests/support/flights/tag_views.h"

namespace tagtwist::internal::set_up_check_test {
namespace {

using testing::HasSubstr;

constexpr TagPlaces kAllPlaces[] = {TagPlaces::kOne,  TagPlaces::kRow,     TagPlaces::kFloor,
                                    TagPlaces::kWall, TagPlaces::kCeiling, TagPlaces::kRoom};

struct Verdict {
  std::string text;  // none: all is well
  int frames = 0;    // until then
};

Verdict Judge(const TagMap& map, const TagViews& views) {
  SetUpCheck check(map, views.camera);
  Verdict out;
  for (const auto& tags : views.frames) {
    ++out.frames;
    if (const auto fine = check.Add(tags); !fine) return {fine.error().message, out.frames};
  }
  if (const auto fine = check.Finish(); !fine) out.text = fine.error().message;
  return out;
}
Verdict Judge(const TagViews& views) { return Judge(views.map, views); }

// The corners as someone gives them whose order, or whose picture, is another.
TagViews Given(TagViews views, const CornerOrder& order) {
  for (auto& tags : views.frames) {
    for (TagDetection& tag : tags) {
      const auto right = tag.corners;
      for (int c = 0; c < 4; ++c) {
        const int at = ((order.reversed ? order.first - c : order.first + c) + 4) % 4;
        Eigen::Vector2d corner = right[static_cast<size_t>(c)];
        if (order.mirrored) corner.x() = views.camera.width - 1 - corner.x();
        tag.corners[static_cast<size_t>(at)] = corner;
      }
    }
  }
  return views;
}

TagMap WithSizes(const TagMap& map, double factor) {
  std::vector<Tag> tags = map.tags();
  for (Tag& tag : tags) tag.size_m *= factor;
  return TagMap(map.family(), tags);
}

TEST(SetUpCheck, SlowRightRecordingsPass) {
  for (const TagPlaces places : kAllPlaces) {
    for (unsigned seed = 1; seed <= 25; ++seed) {
      TagViews views = DrawViews(places, seed, seed % 3 == 0 ? 0.8 : 0.2);
      EXPECT_EQ(Judge(views).text, "") << seed;
      // Phantoms in one frame of ten.
      std::mt19937_64 engine(seed);
      for (size_t k = 3; k < views.frames.size(); k += 10) {
        views.frames[k].push_back(DrawPhantom(views, &engine));
      }
      EXPECT_EQ(Judge(views).text, "") << seed;
    }
  }
}

TEST(SetUpCheck, AFewFramesOfRightRecordingsPass) {
  for (const TagPlaces places : kAllPlaces) {
    for (unsigned seed = 1; seed <= 25; ++seed) {
      TagViews views = DrawViews(places, seed);
      views.frames.resize(1 + seed % 3);
      EXPECT_EQ(Judge(views).text, "") << seed;
    }
  }
}

TEST(SetUpCheck, SlowTellsEveryOrderOfTagsInSeveralRows) {
  for (const TagPlaces places : {TagPlaces::kFloor, TagPlaces::kWall, TagPlaces::kCeiling}) {
    for (int i = 1; i < 16; ++i) {
      const CornerOrder order{i % 4, (i & 4) != 0, (i & 8) != 0};
      for (unsigned seed = 1; seed <= 3; ++seed) {
        const Verdict verdict = Judge(Given(DrawViews(places, seed), order));
        EXPECT_EQ(verdict.text, CornerOrderText(order)) << i << " " << seed;
        EXPECT_LE(verdict.frames, 10);
      }
    }
  }
}

TEST(SetUpCheck, TellsOfOneTagAndOfARowThatTheyRunClockwise) {
  for (const TagPlaces places : {TagPlaces::kOne, TagPlaces::kRow}) {
    for (unsigned seed = 1; seed <= 10; ++seed) {
      for (int first = 0; first < 4; ++first) {
        const Verdict verdict = Judge(Given(DrawViews(places, seed), {first, true, false}));
        EXPECT_EQ(verdict.text, ClockwiseText()) << seed << " " << first;
        EXPECT_THAT(verdict.text, HasSubstr("ArUco"));
        EXPECT_LE(verdict.frames, 5);
      }
      EXPECT_THAT(Judge(Given(DrawViews(places, seed), {0, false, true})).text,
                  HasSubstr("mirror"));
    }
  }
}

TEST(SetUpCheck, TellsOfASinglePictureThatItRunsClockwise) {
  TagViews views = Given(DrawViews(TagPlaces::kOne, 1), {3, true, false});
  views.frames.resize(1);
  EXPECT_EQ(Judge(views).text, ClockwiseText());
}

TEST(SetUpCheck, NamesArucosOrder) {
  EXPECT_THAT(Judge(Given(DrawViews(TagPlaces::kRoom, 2), {3, true, false})).text,
              HasSubstr("ArUco's order (top-left, top-right, bottom-right, bottom-left)"));
}

TEST(SetUpCheck, SlowTellsTheFactorOfAllSizes) {
  for (const TagPlaces places : {TagPlaces::kRow, TagPlaces::kFloor, TagPlaces::kRoom}) {
    for (unsigned seed = 1; seed <= 5; ++seed) {
      const TagViews views = DrawViews(places, seed);
      for (const double told : {0.5, 0.8, 0.9, 1.1, 1.25, 2.0, 1000.0}) {
        const Verdict verdict = Judge(WithSizes(views.map, told), views);
        ASSERT_THAT(verdict.text, HasSubstr("wrong by one factor")) << told << " " << seed;
        EXPECT_LE(verdict.frames, 10);
        const size_t at = verdict.text.find("they are ") + 9;
        EXPECT_NEAR(std::stod(verdict.text.substr(at)) * told, 1, told < 100 ? 0.02 : 0.6);
        EXPECT_EQ(verdict.text.find("white border") != std::string::npos, told == 1.25);
      }
      EXPECT_EQ(Judge(WithSizes(views.map, 1.03), views).text, "");
    }
  }
}

}  // namespace
}  // namespace tagtwist::internal::set_up_check_test

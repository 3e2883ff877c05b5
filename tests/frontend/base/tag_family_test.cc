#include "frontend/types/tag_family.h"

#include <gtest/gtest.h>

namespace tagtwist::internal::tag_family_test {
namespace {

// Official prints of circle tags are paper outside the circle; the family has no bits there.
TEST(TagFamily, CellsThatAFamilyLeavesOpenArePaper) {
  const auto patterns = MakeTagPatterns("tagCircle21h7", {0, 1, 2});
  ASSERT_TRUE(patterns);
  for (const TagPattern& pattern : *patterns) {
    const int last = pattern.cells - 1;
    for (const int near : {1, last - 1}) {
      for (const int end : {1, last - 1}) {
        EXPECT_TRUE(pattern.IsWhite(near, end));  // the corners of the outermost ring of bits
      }
    }
    for (int i = 2; i <= last - 2; ++i) {  // the black ring stays whole
      EXPECT_FALSE(pattern.IsWhite(i, 2));
      EXPECT_FALSE(pattern.IsWhite(2, i));
    }
  }
}

// Families without such cells are drawn as before: all of a border but its white ring is black.
TEST(TagFamily, BordersOfOthersAreBlack) {
  for (const char* name : {"tag36h11", "tag16h5", kKalibrFamily}) {
    const auto patterns = MakeTagPatterns(name, {0});
    ASSERT_TRUE(patterns);
    const TagPattern& pattern = patterns->front();
    for (int i = 1; i < pattern.cells - 1; ++i) EXPECT_FALSE(pattern.IsWhite(i, 1)) << name;
  }
}

}  // namespace
}  // namespace tagtwist::internal::tag_family_test

#include "frontend/simulation/board_squares.h"

#include <gtest/gtest.h>

#include "frontend/types/tag_family.h"

namespace tagtwist::internal::board_squares_test {
namespace {

// Two rows of three tags, turned and moved in space.
TagMap Board(const std::string& family) {
  const Pose world_from_board =
      MakePose(Eigen::Quaterniond(Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized())),
               {0.3, -0.2, 1});
  std::vector<Tag> tags;
  for (int i = 0; i < 6; ++i) {
    const Eigen::Vector3d centre(0.13 * (i % 3), 0.13 * (i / 3), 0);
    tags.push_back({i, world_from_board * MakePose(Eigen::Quaterniond::Identity(), centre), 0.1});
  }
  return TagMap(family, tags);
}

TEST(BoardSquares, FillTheGapsAtAllCornersOnce) {
  const TagMap map = Board(kKalibrFamily);
  const std::vector<Patch> squares = MakeBoardSquares(map, 20);
  EXPECT_EQ(squares.size(), 12u);
  for (const Patch& square : squares) {
    EXPECT_NEAR(square.half_u.norm(), 0.015, 1e-12);
    EXPECT_NEAR(square.half_v.norm(), 0.015, 1e-12);
    EXPECT_EQ(square.grey, 20);
  }
  // The first one ends at the first tag's bottom-left corner.
  const Eigen::Vector3d touching = squares[0].centre + squares[0].half_u + squares[0].half_v;
  EXPECT_LT((touching - map.CornersInWorld(0)[0]).norm(), 1e-12);
}

TEST(BoardSquares, OthersHaveNone) {
  EXPECT_TRUE(MakeBoardSquares(Board("tag36h11"), 20).empty());
  const TagMap alone(kKalibrFamily, {{0, Pose(), 0.1}});
  EXPECT_TRUE(MakeBoardSquares(alone, 20).empty());
}

}  // namespace
}  // namespace tagtwist::internal::board_squares_test

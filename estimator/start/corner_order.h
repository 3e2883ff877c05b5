#pragma once
#include <string>
#include <vector>

#include "frontend/types/camera.h"
#include "frontend/types/measurements.h"
#include "frontend/types/tag_map.h"

namespace tagtwist::internal {

/// How corners as they are given stand to p1..p4 of tags seen from their front.
struct CornerOrder {
  int first = 0;          // p1 is given as corner number `first`, counted from 0,
  bool reversed = false;  // p2.. follow it, or, reversed, go before it
  bool mirrored = false;  // and all places are those of a mirrored picture

  bool IsRight() const { return first == 0 && !reversed && !mirrored; }
};

/// The tag with its corners in the order p1..p4, in the picture that is not mirrored. A picture is
/// mirrored about the camera's principal point, u -> 2 cx - u.
TagDetection InOrder(const CornerOrder& order, const Camera& camera, TagDetection tag);

/// The orders, of all 16, under which the tags of single frames agree on the frames' poses: two
/// tags a frame at least, 80 % of all tags. Those without a mirror come first. Tags in one row,
/// upright along it, look the same in a mirror but for the order of their corners: there two orders
/// fit.
std::vector<CornerOrder> FittingOrders(const std::vector<std::vector<TagDetection>>& frames,
                                       const TagMap& map, const Camera& camera);

/// What is wrong, and what to do about it, in one line: "the corners run in ArUco's order ...".
std::string CornerOrderText(const CornerOrder& order);
/// The same where the corners are known to run clockwise and the tags do not tell in which order.
std::string ClockwiseText();

}  // namespace tagtwist::internal

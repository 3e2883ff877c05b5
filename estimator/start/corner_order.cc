#include "estimator/start/corner_order.h"

#include <algorithm>
#include <array>

#include "frontend/geometry/frame_pose.h"
#include "frontend/geometry/quad_shape.h"

namespace tagtwist::internal {
namespace {

constexpr const char* kRightOrder = "p1..p4 (bottom-left, bottom-right, top-right, top-left)";
constexpr const char* kArucoOrder =
    "ArUco's order (top-left, top-right, bottom-right, bottom-left)";

size_t GivenIndex(const CornerOrder& order, int corner) {
  return static_cast<size_t>((order.first + (order.reversed ? 4 - corner : corner)) % 4);
}

// Of tags seen from their front: a reversal and a mirror each turn the corners' sense.
std::vector<CornerOrder> AllOrders() {
  std::vector<CornerOrder> out;
  for (const bool mirrored : {false, true}) {
    for (const bool reversed : {false, true}) {
      for (int first = 0; first < 4; ++first) out.push_back({first, reversed, mirrored});
    }
  }
  return out;
}

// How many of a frame's tags agree on its pose; 0 where they are not two.
int AgreeingTags(const std::vector<TagDetection>& tags, const TagMap& map, const Camera& camera) {
  const FramePose found = FindFramePose(tags, map, camera, Pose());
  if (found.status != FramePoseStatus::kOk) return 0;
  const auto n = std::count(found.tag_inlier.begin(), found.tag_inlier.end(), true);
  return n < 2 ? 0 : static_cast<int>(n);
}

bool RunAnticlockwise(const std::vector<TagDetection>& tags) {
  const auto n = std::count_if(tags.begin(), tags.end(), [](const TagDetection& tag) {
    return TurnOf(tag.corners) == QuadTurn::kAnticlockwise;
  });
  return 2 * static_cast<size_t>(n) > tags.size();
}

int Explained(const std::vector<std::vector<TagDetection>>& frames, const CornerOrder& order,
              const TagMap& map, const Camera& camera) {
  int out = 0;
  for (const std::vector<TagDetection>& tags : frames) {
    std::vector<TagDetection> in_order;
    for (const TagDetection& tag : tags) in_order.push_back(InOrder(order, camera, tag));
    if (RunAnticlockwise(in_order)) out += AgreeingTags(in_order, map, camera);
  }
  return out;
}

// The corners' names in the order that they are given in.
std::string GivenNames(const CornerOrder& order) {
  constexpr std::array<const char*, 4> kNames = {"bottom-left", "bottom-right", "top-right",
                                                 "top-left"};
  std::array<const char*, 4> given{};
  for (int c = 0; c < 4; ++c) given[GivenIndex(order, c)] = kNames[static_cast<size_t>(c)];
  std::string out;
  for (const char* name : given) out += (out.empty() ? "" : ", ") + std::string(name);
  return out;
}

}  // namespace

TagDetection InOrder(const CornerOrder& order, const Camera& camera, TagDetection tag) {
  const auto given = tag.corners;
  for (int c = 0; c < 4; ++c) {
    Eigen::Vector2d& corner = tag.corners[static_cast<size_t>(c)];
    corner = given[GivenIndex(order, c)];
    if (order.mirrored) corner.x() = 2 * camera.cx - corner.x();
  }
  tag.covariance.reset();
  return tag;
}

std::vector<CornerOrder> FittingOrders(const std::vector<std::vector<TagDetection>>& frames,
                                       const TagMap& map, const Camera& camera) {
  int n_tags = 0;
  for (const std::vector<TagDetection>& tags : frames) n_tags += static_cast<int>(tags.size());
  std::vector<CornerOrder> out;
  for (const CornerOrder& order : AllOrders()) {
    if (n_tags > 0 && 10 * Explained(frames, order, map, camera) >= 8 * n_tags) {
      out.push_back(order);
    }
  }
  return out;
}

std::string CornerOrderText(const CornerOrder& order) {
  if (order.mirrored && !order.reversed) {
    const std::string corners =
        order.first == 0 ? "" : ", and the corners run in the order (" + GivenNames(order) + ")";
    return "the picture is mirrored: the tags' corners run clockwise, and their places agree with "
           "the map's only in a mirror" +
           corners +
           "; mirror it back (u becomes width - 1 - u), or detect in the picture as taken";
  }
  if (order.mirrored) {
    return "the map is mirrored: each tag is seen from its front, but the tags' places agree with "
           "the map's only in a mirror; turn round one axis of the map's positions";
  }
  const bool is_aruco = order.reversed && order.first == 3;
  const std::string name = is_aruco ? kArucoOrder : "the order (" + GivenNames(order) + ")";
  const std::string or_map = order.reversed ? "" : ", or turn the map's tags accordingly";
  return "the corners run in " + name + ", not as " + kRightOrder + ": put them into that order" +
         or_map;
}

std::string ClockwiseText() {
  return std::string("the corners run clockwise, as in ") + kArucoOrder +
         " or in a mirrored picture; tags seen from their front have " + kRightOrder +
         ", anticlockwise: put them into that order, or mirror the picture back";
}

}  // namespace tagtwist::internal

#include "estimator/result/tag_audit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "frontend/base/statistics/quantile.h"

namespace tagtwist::internal {
namespace {

using Quad = std::array<Eigen::Vector2d, 4>;

// Corners as the map's tag frame has them [m].
Quad MapQuad(const Tag& tag) {
  const double h = 0.5 * tag.size_m;
  return {Eigen::Vector2d(-h, -h), {h, -h}, {h, h}, {-h, h}};
}

// Where the rays through the corners meet the tag's plane, in its frame [m].
std::optional<Quad> SeenQuad(const EstimatorSetup& setup, const Pose& world_from_body,
                             const Tag& tag, const TagDetection& detection) {
  Quad quad;
  for (size_t c = 0; c < 4; ++c) {
    const auto point = PointOnPlane(setup, world_from_body, tag.world_from_tag,
                                    detection.corners[c], detection.camera);
    if (!point) return std::nullopt;
    quad[c] = *point;
  }
  return quad;
}

// Twice the area, positive when p1..p4 run anticlockwise, as printed.
double SignedArea(const Quad& quad) {
  const Eigen::Vector2d a = quad[2] - quad[0], b = quad[3] - quad[1];
  return a.x() * b.y() - a.y() * b.x();
}

// True when the quad, on the plane of `tag`, lies on another tag of the map.
bool LiesOnAnotherTag(const TagMap& map, const Tag& tag, const Quad& quad) {
  constexpr double kNear = 0.3;  // of the side
  return std::any_of(map.tags().begin(), map.tags().end(), [&](const Tag& other) {
    if (other.id == tag.id) return false;
    const auto& corners = map.CornersInWorld(other.id);
    for (size_t c = 0; c < 4; ++c) {
      const Eigen::Vector3d seen =
          tag.world_from_tag * Eigen::Vector3d(quad[c].x(), quad[c].y(), 0);
      if (!((seen - corners[c]).norm() < kNear * other.size_m)) return false;
    }
    return true;
  });
}

// True when a fault is a rule of a tag that was seen in so many frames, and no accident. Tags that
// are rarely in view come up as the wrong ids of others: those take more to be named.
bool IsRule(TagFault fault, size_t faults, int seen) {
  const bool wrong_id = fault == TagFault::kWrongId;
  const size_t least = wrong_id ? 20 : 3;
  const double share = wrong_id ? 0.5 : 0.2;
  return faults >= least && static_cast<double>(faults) >= share * seen;
}

std::string Times(size_t n, const std::string& noun) {
  return std::to_string(n) + " " + noun + (n == 1 ? "" : "s");
}

// What a displaced tag's sightings say together.
std::string DisplacedText(const std::string& tag, const ThinnedSample<TagDisagreement>& sightings) {
  std::vector<double> x, y, distance;
  for (const TagDisagreement& d : sightings.values()) {
    x.push_back(d.shift_m.x());
    y.push_back(d.shift_m.y());
    distance.push_back(d.distance_m);
  }
  const Eigen::Vector2d shift(Quantile(x, 0.5), Quantile(y, 0.5));
  std::vector<double> scatter;
  scatter.reserve(sightings.values().size());
  for (const TagDisagreement& d : sightings.values()) scatter.push_back((d.shift_m - shift).norm());
  const double median_m = Quantile(distance, 0.5);
  const std::string frames = Times(sightings.count(), "frame");
  constexpr double kSteady = 0.5;  // of the distance: how far the places of a still tag scatter
  if (!(Quantile(scatter, 0.5) <= kSteady * median_m)) {
    return tag + " is seen off the map, at changing places, in " + frames;
  }
  return tag + " disagrees with the map by " + std::to_string(std::lround(1e3 * median_m)) +
         " mm in " + frames;
}

}  // namespace

std::optional<TagDisagreement> JudgeTag(const EstimatorSetup& setup, const Pose& world_from_body,
                                        const TagDetection& detection) {
  const Tag& tag = *setup.map.Find(detection.id);
  const auto quad = SeenQuad(setup, world_from_body, tag, detection);
  if (!quad) return std::nullopt;
  TagDisagreement out;
  const Quad expected = MapQuad(tag);
  double squares = 0;
  for (size_t c = 0; c < 4; ++c) {
    out.shift_m += 0.25 * (*quad)[c];
    squares += 0.25 * ((*quad)[c] - expected[c]).squaredNorm();
  }
  out.distance_m = std::sqrt(squares);
  if (SignedArea(*quad) < 0) {
    out.fault = TagFault::kMirrored;
  } else if (LiesOnAnotherTag(setup.map, tag, *quad)) {
    out.fault = TagFault::kWrongId;
  }
  return out;
}

std::vector<TagElsewhere> TagsElsewhere(const EstimatorSetup& setup, const GraphFrame& frame,
                                        const std::vector<TagDetection>& seen) {
  std::vector<TagElsewhere> out;
  if (frame.tags.size() >= seen.size()) return out;
  for (const TagDetection& tag : seen) {
    const bool is_used = std::any_of(frame.tags.begin(), frame.tags.end(),
                                     [&](const TagDetection& used) { return used.id == tag.id; });
    if (is_used) continue;
    const auto judged = JudgeTag(setup, frame.state.world_from_body, tag);
    const double size_m = setup.map.Find(tag.id)->size_m;
    if (judged && judged->shift_m.norm() > size_m) {
      out.push_back({tag.id, judged->shift_m, size_m});
    }
  }
  return out;
}

void TagAudit::Add(const EstimatorSetup& setup, const GraphFrame& frame,
                   const std::vector<TagDetection>& seen) {
  std::vector<int> left_out;
  for (const TagDetection& tag : seen) {
    if (setup.map.Find(tag.id) == nullptr) continue;
    History& history = tags_[tag.id];
    ++history.seen;
    const bool used =
        std::any_of(frame.tags.begin(), frame.tags.end(), [&](const TagDetection& other) {
          return other.id == tag.id && other.camera == tag.camera;
        });
    if (used) continue;
    left_out.push_back(tag.id);
    if (const auto judged = JudgeTag(setup, frame.state.world_from_body, tag)) {
      history.left_out[static_cast<size_t>(judged->fault)].Add(*judged);
    } else {
      ++history.off_plane;
    }
  }
  if (frame.tags.empty() && !left_out.empty()) useless_frames_.Add(left_out);
}

std::vector<std::string> TagAudit::Warnings() const {
  std::vector<std::string> out;
  std::set<int> named;
  size_t others = 0;
  for (const auto& [id, history] : tags_) {
    others += static_cast<size_t>(history.off_plane);
    const std::string tag = "tag " + std::to_string(id);
    const std::string of_seen = " in " + Times(history.seen, "frame") + " that show it";
    for (const TagFault fault : {TagFault::kDisplaced, TagFault::kWrongId, TagFault::kMirrored}) {
      const auto& sightings = history.left_out[static_cast<size_t>(fault)];
      if (!IsRule(fault, sightings.count(), history.seen)) {
        others += sightings.count();
        continue;
      }
      named.insert(id);
      if (fault == TagFault::kDisplaced) {
        out.push_back(DisplacedText(tag, sightings));
      } else {
        const std::string what = fault == TagFault::kWrongId
                                     ? " is seen where the map has another tag, "
                                     : " is seen mirrored, ";
        out.push_back(tag + what + Times(sightings.count(), "time") + of_seen);
      }
    }
  }
  if (others > 0) {
    out.push_back(Times(others, "single tag observation") + " contradict" +
                  (others == 1 ? "s" : "") + " the others and " + (others == 1 ? "is" : "are") +
                  " left out");
  }
  const std::vector<std::vector<int>>& frames = useless_frames_.values();
  const auto useless =
      std::count_if(frames.begin(), frames.end(), [&](const std::vector<int>& ids) {
        return std::any_of(ids.begin(), ids.end(), [&](int id) { return named.count(id) == 0; });
      });
  if (useless > 0) {
    const auto n = static_cast<size_t>(useless) * useless_frames_.stride();
    out.push_back("no tag of " + Times(n, "frame") + " agrees with the neighbouring frames; " +
                  (n == 1 ? "its state is" : "their states are") + " predicted");
  }
  return out;
}

}  // namespace tagtwist::internal

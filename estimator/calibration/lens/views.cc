#include "estimator/calibration/lens/views.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "frontend/base/format_text.h"
#include "frontend/base/units.h"
#include "frontend/geometry/frame_pose.h"
#include "frontend/types/body_state.h"
#include "frontend/types/pose.h"

namespace tagtwist::internal {
namespace {

struct View {
  Pose cam_from_world;
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();  // of what it shows, in the camera
};

View ViewOf(const FramePose& pose, const std::vector<TagDetection>& tags, const TagMap& map) {
  View out;
  out.cam_from_world = Inverse(pose.world_from_body);
  for (const TagDetection& tag : tags) {
    out.middle += out.cam_from_world * map.Find(tag.id)->world_from_tag.translation() /
                  static_cast<double>(tags.size());
  }
  return out;
}

bool AreAlike(const View& a, const View& b) {
  constexpr double kAngleRad = 0.0873, kShare = 1.0 / 7;
  const double distance_m = std::min(a.middle.norm(), b.middle.norm());
  return AngleBetween(a.cam_from_world, b.cam_from_world) < kAngleRad &&
         (a.middle - b.middle).norm() < kShare * distance_m;
}

// The largest angle between two views' optical axes, in the world: turning the camera about its own
// axis is none.
double LargestTilt(const std::vector<View>& views) {
  double least = 1;
  std::vector<Eigen::Vector3d> axes;
  for (const View& view : views) {
    axes.push_back(view.cam_from_world.rotation().conjugate() * Eigen::Vector3d::UnitZ());
  }
  for (const Eigen::Vector3d& a : axes) {
    for (const Eigen::Vector3d& b : axes) least = std::min(least, a.dot(b));
  }
  return std::acos(std::clamp(least, -1.0, 1.0));
}

std::string WhereUnseen(const ViewsJudged& views) {
  std::array<int, 9> cells{}, unseen{};  // thirds of the image
  for (int row = 0; row < ViewsJudged::kRows; ++row) {
    for (int column = 0; column < ViewsJudged::kColumns; ++column) {
      const auto third = static_cast<size_t>(3 * (3 * row / ViewsJudged::kRows) +
                                             3 * column / ViewsJudged::kColumns);
      ++cells[third];
      const int seen = views.corners[static_cast<size_t>(ViewsJudged::kColumns * row + column)];
      unseen[third] += seen == 0 ? 1 : 0;
    }
  }
  static constexpr std::array kNames = {"upper left", "top",    "upper right",
                                        "left",       "middle", "right",
                                        "lower left", "bottom", "lower right"};
  std::string out;
  for (size_t i = 0; i < 9; ++i) {
    if (2 * unseen[i] <= cells[i]) continue;
    out += (out.empty() ? "" : ", ") + std::string(kNames[i]);
  }
  return out;
}

// By frame: its predecessor came within 0.1 s, and is not itself counted to another.
std::vector<bool> Successors(const std::vector<FrameMeasurements>& frames) {
  constexpr double kNearS = 0.1;
  std::vector<bool> out(frames.size());
  for (size_t i = 1; i < frames.size(); ++i) {
    out[i] = !out[i - 1] && ToSeconds(frames[i].t_ns - frames[i - 1].t_ns) <= kNearS;
  }
  return out;
}

// Frames in the order in which they are wanted: of every view one, then of every view a second.
// Where the last round does not fit whole, its frames are spread over the recording.
std::vector<size_t> ByRounds(const ViewsJudged& views, const std::vector<bool>& left_out,
                             size_t most) {
  std::vector<std::pair<int, size_t>> order;  // how many of its view came before; the frame
  std::map<int, int> count;
  for (size_t i = 0; i < left_out.size(); ++i) {
    if (views.view[i] >= 0 && !left_out[i]) order.emplace_back(count[views.view[i]]++, i);
  }
  std::sort(order.begin(), order.end());
  std::vector<size_t> out;
  for (size_t first = 0; first < order.size() && out.size() < most;) {
    size_t end = first;
    while (end < order.size() && order[end].first == order[first].first) ++end;
    const size_t n = std::min(end - first, most - out.size());
    for (size_t k = 0; k < n; ++k) out.push_back(order[first + k * (end - first) / n].second);
    first = end;
  }
  return out;
}

}  // namespace

void CountCorners(const TagDetection& tag, int width, int height, ViewsJudged* to) {
  for (const Eigen::Vector2d& pixel : tag.corners) {
    const double column = std::floor(ViewsJudged::kColumns * (pixel.x() + 0.5) / width);
    const double row = std::floor(ViewsJudged::kRows * (pixel.y() + 0.5) / height);
    if (!(column >= 0 && row >= 0 && column < ViewsJudged::kColumns && row < ViewsJudged::kRows)) {
      continue;
    }
    ++to->corners[static_cast<size_t>(ViewsJudged::kColumns * row + column)];
    to->pixels.push_back(pixel);
  }
}

double ViewsJudged::covered() const {
  const auto n = std::count_if(corners.begin(), corners.end(), [](int count) { return count > 0; });
  return static_cast<double>(n) / static_cast<double>(corners.size());
}

ViewsJudged JudgeViews(const std::vector<FrameMeasurements>& frames, const TagMap& map,
                       const Camera& camera) {
  ViewsJudged out;
  std::vector<View> distinct;
  for (const FrameMeasurements& frame : frames) {
    out.view.push_back(-1);
    const FramePose pose = FindFramePose(frame.tags, map, camera, Pose());
    if (pose.status != FramePoseStatus::kOk) continue;
    for (const TagDetection& tag : frame.tags) CountCorners(tag, camera.width, camera.height, &out);
    const View view = ViewOf(pose, frame.tags, map);
    const auto known = std::find_if(distinct.begin(), distinct.end(),
                                    [&](const View& other) { return AreAlike(view, other); });
    out.view.back() = static_cast<int>(known - distinct.begin());
    if (known == distinct.end()) distinct.push_back(view);
  }
  out.distinct = static_cast<int>(distinct.size());
  out.tilt_rad = LargestTilt(distinct);
  return out;
}

std::vector<std::string> MissingOf(const ViewsJudged& views) {
  constexpr int kLeastDistinct = 10;
  constexpr double kLeastTiltRad = 0.35, kLeastCovered = 0.6;
  std::vector<std::string> out;
  if (views.distinct < kLeastDistinct) {
    out.push_back(Format(
        "only %d views differ, expected %d: show the tags from more places, near and far, and "
        "turned",
        views.distinct, kLeastDistinct));
  }
  if (views.tilt_rad < kLeastTiltRad) {
    out.push_back(Format(
        "the tags were tilted by %.0f degrees between views, expected %.0f: tilt them more, about "
        "both axes",
        kDegreesPerRadian * views.tilt_rad, kDegreesPerRadian * kLeastTiltRad));
  }
  if (views.covered() < kLeastCovered) {
    const std::string where = WhereUnseen(views);
    out.push_back(Format("%.0f %% of the image saw tags, expected %.0f %%: show them %s",
                         100 * views.covered(), 100 * kLeastCovered,
                         where.empty() ? "nearer to its border" : ("at its " + where).c_str()));
  }
  return out;
}

std::vector<int64_t> SpreadOver(const ViewsJudged& views,
                                const std::vector<FrameMeasurements>& frames) {
  constexpr size_t kMost = 60;
  const std::vector<bool> successor = Successors(frames);
  std::vector<int64_t> out;
  for (const size_t i : ByRounds(views, successor, kMost)) {
    out.push_back(frames[i].t_ns);
    if (i + 1 < frames.size() && successor[i + 1]) out.push_back(frames[i + 1].t_ns);
  }
  std::sort(out.begin(), out.end());
  return out;
}

}  // namespace tagtwist::internal

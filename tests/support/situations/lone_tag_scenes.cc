#include "tests/support/situations/lone_tag_scenes.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "tests/support/flights/tag_scene.h"

namespace tagtwist::internal {
namespace {

constexpr double kTwoPi = 6.283185307179586;

// The tag that most frames show.
int MostShown(const std::vector<FrameMeasurements>& frames) {
  std::map<int, size_t> shown;
  for (const FrameMeasurements& frame : frames) {
    for (const TagDetection& tag : frame.tags) ++shown[tag.id];
  }
  return std::max_element(shown.begin(), shown.end(),
                          [](const auto& a, const auto& b) { return a.second < b.second; })
      ->first;
}

}  // namespace

std::function<Pose(double t)> OrbitAbout(const Eigen::Vector3d& centre, Rng* rng) {
  const double radius_m = Draw(rng, 1.2, 1.8), swing_rad = Draw(rng, 0.2, 0.4);
  const double hz = Draw(rng, 0.05, 0.2), angle = Draw(rng, 0, kTwoPi),
               phase = Draw(rng, 0, kTwoPi);
  const Eigen::Vector3d axis(-std::sin(angle), std::cos(angle), 0);
  return [=](double t) {
    const Eigen::Matrix3d turn =
        Eigen::AngleAxisd(swing_rad * std::sin(kTwoPi * hz * t + phase), axis).toRotationMatrix();
    const Pose above = Hover({0, 0, radius_m}, 0.3, {0.1, 0, 0});
    return MakePose(Eigen::Quaterniond(turn * above.rotation()),
                    centre + turn * above.translation());
  };
}

SituationDraw WithLoneTag(SituationDraw draw, bool another) {
  const int id = MostShown(draw.measurements);
  for (size_t k = 0; k < draw.measurements.size(); ++k) {
    bool takes_another = another && k / 7 % 3 == 1;
    const auto is_hidden = [&](const TagDetection& tag) {
      return tag.id != id && !std::exchange(takes_another, false);
    };
    std::vector<TagDetection>& tags = draw.measurements[k].tags;
    tags.erase(std::remove_if(tags.begin(), tags.end(), is_hidden), tags.end());
  }
  return draw;
}

SituationDraw BeforeOneTag(SituationDraw draw) {
  draw = WithLoneTag(std::move(draw), false);
  const int id = MostShown(draw.measurements);
  draw.setup.map = TagMap(draw.setup.map.family(), {*draw.setup.map.Find(id)});
  return draw;
}

}  // namespace tagtwist::internal

#include "estimator/result/rig_tally.h"

#include <algorithm>
#include <cmath>

#include "estimator/graph/reprojection.h"
#include "estimator/rig/rig_tags.h"

namespace tagtwist::internal {

RigTally::RigTally(const EstimatorSetup& setup) {
  if (setup.n_cameras() == 1) return;
  for (const std::string& name : setup.camera_names) shares_.push_back({name, 0, 0, 0, 0});
  squares_.resize(shares_.size());
}

void RigTally::AddSolved(const EstimatorSetup& setup, const GraphFrame& frame) {
  const Pose& body = frame.state.world_from_body;
  if (shares_.empty()) {
    tally_.Add(setup.camera, setup.map, frame.t_ns, setup.CameraOf(0).CamFromMap(body), frame.tags);
    return;
  }
  for (size_t i = 0; i < shares_.size(); ++i) {
    const MountedCamera camera = setup.CameraOf(static_cast<int>(i));
    GraphFrame own;
    own.state = frame.state;
    own.tags = TagsOfCamera(frame.tags, static_cast<int>(i));
    if (own.tags.empty()) continue;
    tally_.Add(camera.camera, setup.map, frame.t_ns, camera.CamFromMap(body), own.tags);
    shares_[i].used += own.tags.size();
    for (const double error_px : ReprojectionErrors(setup, own)) {
      squares_[i] += error_px * error_px;
    }
  }
}

void RigTally::AddSeen(const std::vector<TagDetection>& tags) {
  for (size_t i = 0; i < shares_.size(); ++i) {
    const auto n =
        static_cast<size_t>(std::count_if(tags.begin(), tags.end(), [i](const TagDetection& tag) {
          return tag.camera == static_cast<int>(i);
        }));
    shares_[i].tags += n;
    shares_[i].frames += n > 0 ? 1 : 0;
  }
}

std::vector<CameraShare> RigTally::Shares() const {
  constexpr double kCoordinates = 8;  // of a tag's corners
  std::vector<CameraShare> out = shares_;
  for (size_t i = 0; i < out.size(); ++i) {
    const auto n = static_cast<double>(out[i].used);
    if (n > 0) out[i].rms_px = std::sqrt(squares_[i] / (kCoordinates * n));
  }
  return out;
}

}  // namespace tagtwist::internal

#pragma once
#include <memory>
#include <string>
#include <vector>

#include "estimator/jobs/measurement_stream.h"
#include "estimator/result/seen_body.h"
#include "frontend/base/result.h"
#include "frontend/types/rig.h"

namespace tagtwist::internal {

/// What is the same in all frames of a run that is published, and how its parts are called: the
/// cameras by their names in the rig, of which one at least is there.
struct PublishedRun {
  SetUp set_up;         // of the first body
  std::string dataset;  // as the user named it
  std::string body = "body", world = "world";
  std::vector<TaggedBody> others = {};  // Config::bodies

  size_t n_bodies() const { return 1 + others.size(); }
  const std::string& BodyName(size_t index) const {
    return index == 0 ? body : others[index - 1].name;
  }
  /// What a body is estimated with, as Config::SetUps.
  SetUp SetUpOf(size_t index) const;
  /// Whether its tags move with it; those of the first body before a camera on it stand in W.
  bool TagsMove(size_t index) const;
  /// An error where bodies, cameras and the world do not have names of their own, as frames of
  /// reference and topics must: "bodies: cam0 is a camera's name, too: streams need ...".
  Status CheckNames() const;
};

/// A frame as it is published, once its states are known.
struct PublishedFrame {
  std::vector<SeenBody> bodies = std::vector<SeenBody>(1);  // as the run's
  std::vector<CameraImage> images = {};  // of the cameras whose frame it is, ascending
  double latency_ms = 0;                 // from its stamp to its state; 0 where the run is not live
  size_t frames_dropped = 0;             // that came while others waited, so far

  int64_t t_ns() const { return bodies.front().state.t_ns; }
};

/// Several threads read it; none changes it.
using FramePtr = std::shared_ptr<const PublishedFrame>;

}  // namespace tagtwist::internal

#include "estimator/jobs/kept/told_bodies.h"

#include "estimator/result/body_in_world.h"
#include "frontend/base/check.h"

namespace tagtwist::internal {

ToldBodies::ToldBodies(size_t bodies, bool are_carried, const RunOptions& options)
    : are_carried_(are_carried),
      options_(options),
      pairs_(bodies),
      kept_(bodies, KeptFrames(options.most_kept)) {}

Status ToldBodies::Tell(std::vector<SeenBody>* bodies) {
  for (size_t i = 0; i < bodies->size(); ++i) {
    SeenBody& body = (*bodies)[i];
    if (IsCarried(i)) body.state = BodyInWorld(bodies->front().state, body.state);
    kept_[i].Add(body.state, body.reprojection_px);
    if (!options_.on_state) continue;
    if (const Status told = options_.on_state(i, body.state); !told) return told;
  }
  return Ok();
}

Status ToldBodies::TellLagged(size_t body, const std::vector<FrameEstimate>& lagged) {
  for (size_t i = 1; i < pairs_.size() && body == 0 && are_carried_; ++i) {
    auto& carriers = pairs_[i].carriers;
    carriers.insert(carriers.end(), lagged.begin(), lagged.end());
  }
  if (IsCarried(body)) {
    auto& about_body = pairs_[body].about_body;
    about_body.insert(about_body.end(), lagged.begin(), lagged.end());
    return TellPairs(body);
  }
  for (const FrameEstimate& frame : lagged) {
    if (const Status told = TellOneLagged(body, frame); !told) return told;
  }
  return Ok();
}

Status ToldBodies::TellPairs(size_t body) {
  auto& [carriers, about_body] = pairs_[body];
  while (!carriers.empty() && !about_body.empty()) {
    TAGTWIST_CHECK(carriers.front().t_ns == about_body.front().t_ns,
                   "a body's frames are its carrier's, one by one");
    const FrameEstimate in_world = BodyInWorld(carriers.front(), about_body.front());
    carriers.pop_front();
    about_body.pop_front();
    if (const Status told = TellOneLagged(body, in_world); !told) return told;
  }
  return Ok();
}

Status ToldBodies::TellOneLagged(size_t body, const FrameEstimate& frame) {
  kept_[body].AddLagged(frame);
  return options_.on_lagged ? options_.on_lagged(body, frame) : Ok();
}

}  // namespace tagtwist::internal

#include "estimator/publish/published_frame.h"

#include <set>

namespace tagtwist::internal {

SetUp PublishedRun::SetUpOf(size_t index) const {
  return index == 0 ? set_up : SetUp{set_up.rig, others[index - 1].map};
}

bool PublishedRun::TagsMove(size_t index) const {
  return index > 0 || set_up.rig.mounted_on == MountedOn::kWorld;
}

Status PublishedRun::CheckNames() const {
  std::set<std::string> names = {world};
  for (const RigCamera& camera : set_up.rig.cameras) {
    if (names.insert(camera.name).second) continue;
    return Error{"cameras: " + camera.name + " is the world's name in streams, too: name it else"};
  }
  for (size_t i = 0; i < n_bodies(); ++i) {
    if (names.insert(BodyName(i)).second) continue;
    return Error{"bodies: " + BodyName(i) +
                 " is what another body, a camera or the world is called in streams, too: name one "
                 "of them else"};
  }
  return Ok();
}

}  // namespace tagtwist::internal

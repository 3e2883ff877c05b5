// A body that stands still over four tags, seen exactly: the window says where it is.
#include <tagtwist/estimator/batch/batch.h>
#include <tagtwist/estimator/window/sliding_window.h>

#include <cstdio>

namespace {

tagtwist::TagDetection See(const tagtwist::SetUp& set_up, const tagtwist::Pose& world_from_body,
                           int id) {
  tagtwist::TagDetection out;
  out.id = id;
  for (size_t c = 0; c < 4; ++c) {
    const auto in_cam = tagtwist::Inverse(world_from_body) * set_up.map.CornersInWorld(id)[c];
    set_up.rig.front().camera.Project(in_cam, &out.corners[c]);
  }
  return out;
}

}  // namespace

int main() {
  const Eigen::Quaterniond downwards(0, 1, 0, 0);
  const auto pose = tagtwist::MakePose(downwards, {0.3, 0.3, 1.0});
  const auto set_up = tagtwist::MakeSetUp({}, tagtwist::Pose(), tagtwist::MakeTagMap({}));
  tagtwist::BatchEstimator batch(set_up, {});
  tagtwist::SlidingWindow window(set_up, {});
  double off_m = 0;
  for (int i = 0; i < 30; ++i) {
    tagtwist::FrameMeasurements frame;
    frame.t_ns = 20'000'000LL * i;
    for (const int id : {0, 1, 12, 13}) frame.tags.push_back(See(set_up, pose, id));
    const auto output = window.Add(frame);
    if (!output) return std::fprintf(stderr, "%s\n", output.error().message.c_str()), 1;
    off_m = (output->current.state.world_from_body.translation() - pose.translation()).norm();
    batch.Add(frame);
  }
  const auto estimate = batch.Solve();
  if (!estimate) return std::fprintf(stderr, "%s\n", estimate.error().message.c_str()), 1;
  std::printf("window: %.4f mm off; batch: %zu frames\n", 1e3 * off_m, estimate->frames.size());
  return off_m < 1e-4 && estimate->frames.size() == 30 ? 0 : 1;
}

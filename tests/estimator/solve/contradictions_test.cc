#include "estimator/solve/contradictions.h"

#include <gtest/gtest.h>

#include "tests/support/flights/exact_model.h"

namespace tagtwist::internal::contradictions_test {
namespace {

constexpr double kSigmaPx = 0.2;

struct Scene {
  EstimatorSetup setup = CourseSetup();
  NoiseModel noise;
  std::vector<GraphFrame> frames;

  // Three frames at their true states, all tags where they are seen without noise.
  Scene() {
    noise.corner_sigma_px = kSigmaPx;
    ExactModelOptions model;
    model.frames = 3;
    model.corner_sigma_px = 1e-9;
    const ExactModelFlight flight = DrawFlight(model);
    for (size_t k = 0; k < flight.truth.size(); ++k) {
      GraphFrame frame;
      frame.t_ns = flight.measurements[k].t_ns;
      frame.state = flight.truth[k];
      frame.tags = flight.measurements[k].tags;
      for (TagDetection& tag : frame.tags) tag.covariance.reset();
      frames.push_back(frame);
    }
  }
  Graph MakeGraph() const {
    GraphInput input;
    input.frames = frames;
    return BuildGraph(setup, noise, input);
  }
  void Shift(size_t frame, size_t tag, double px) {
    for (Eigen::Vector2d& corner : frames[frame].tags[tag].corners) corner.x() += px;
  }
};

TEST(Contradictions, ATagFarFromItsPredictionIsNamed) {
  Scene scene;
  ASSERT_GE(scene.frames[1].tags.size(), 3U);
  EXPECT_TRUE(ContradictedTags(scene.MakeGraph()).empty());
  scene.Shift(1, 2, 40 * kSigmaPx);
  const std::vector<TagRef> found = ContradictedTags(scene.MakeGraph());
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].state, 1);
  EXPECT_EQ(found[0].tag, 2);
}

TEST(Contradictions, DroppedTagsAreThoseNamedInAnyOrder) {
  Scene scene;
  const std::vector<TagDetection> before = scene.frames[0].tags;
  ASSERT_GE(before.size(), 4U);
  DropTags({{0, 2}, {0, 0}}, &scene.frames);
  ASSERT_EQ(scene.frames[0].tags.size(), before.size() - 2);
  EXPECT_EQ(scene.frames[0].tags[0].id, before[1].id);
  EXPECT_EQ(scene.frames[0].tags[1].id, before[3].id);
  EXPECT_EQ(scene.frames[1].tags.size(), Scene().frames[1].tags.size());
}

TEST(Contradictions, ACornerAgreesWithinFiveDeviations) {
  const Scene scene;
  for (const double deviations : {4.5, 5.5}) {
    TagDetection tag = scene.frames[0].tags[0];
    tag.corners[3].y() += deviations * kSigmaPx;
    EXPECT_EQ(AgreesWith(scene.setup, scene.noise, scene.frames[0].state, tag), deviations < 5);
  }
}

TEST(Contradictions, RevisionLeavesOutAndTakesInAgain) {
  Scene scene;
  const std::vector<TagDetection> good = scene.frames[0].tags;
  scene.Shift(1, 0, 40 * kSigmaPx);
  const std::vector<TagDetection> bad = scene.frames[1].tags;
  const std::vector<TagDetection> third = scene.frames[2].tags;
  const std::vector<const std::vector<TagDetection>*> seen = {&good, &bad, &third};
  scene.frames[0].tags.pop_back();  // as a start may have left it out
  ASSERT_TRUE(ReviseTags(scene.setup, scene.noise, scene.MakeGraph(), seen, true, &scene.frames));
  EXPECT_EQ(scene.frames[0].tags.size(), good.size());
  ASSERT_EQ(scene.frames[1].tags.size(), bad.size() - 1);
  EXPECT_NE(scene.frames[1].tags[0].id, bad[0].id);
  EXPECT_FALSE(ReviseTags(scene.setup, scene.noise, scene.MakeGraph(), seen, true, &scene.frames));
}

}  // namespace
}  // namespace tagtwist::internal::contradictions_test

#include "estimator/solve/contradictions.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/support/flights/exact_model.h"

namespace tagtwist::internal::contradictions_test {
namespace {

constexpr double kSigmaPx = 0.2;

struct Scene {
  EstimatorSetup setup = CourseSetup();
  NoiseModel noise;
  std::vector<GraphFrame> frames;

  // Frames at their true states, all tags where they are seen without noise.
  explicit Scene(int n_frames = 3) {
    noise.corner_sigma_px = kSigmaPx;
    ExactModelOptions model;
    model.frames = n_frames;
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

// Shifts a tag, or all, in five of eight frames; how many the other three then do without.
size_t MissingInTheOthers(bool all_tags) {
  Scene scene(8);
  const auto all_show = [&](const TagDetection& tag) {
    return std::all_of(scene.frames.begin(), scene.frames.end(), [&](const GraphFrame& frame) {
      return std::any_of(frame.tags.begin(), frame.tags.end(),
                         [&](const TagDetection& other) { return other.id == tag.id; });
    });
  };
  const auto& first = scene.frames[0].tags;
  const auto shown = std::find_if(first.begin(), first.end(), all_show);
  if (shown == first.end()) return 0;
  const int id = shown->id;
  for (size_t k = 0; k < 5; ++k) {
    for (size_t i = 0; i < scene.frames[k].tags.size(); ++i) {
      if (all_tags || scene.frames[k].tags[i].id == id) scene.Shift(k, i, 40 * kSigmaPx);
    }
  }
  std::vector<std::vector<TagDetection>> tags;
  for (const GraphFrame& frame : scene.frames) tags.push_back(frame.tags);
  std::vector<const std::vector<TagDetection>*> seen;
  for (const auto& of_frame : tags) seen.push_back(&of_frame);
  EXPECT_TRUE(ReviseTags(scene.setup, scene.noise, scene.MakeGraph(), seen, false, &scene.frames));
  size_t missing = 0;
  for (size_t k = 5; k < 8; ++k) missing += tags[k].size() - scene.frames[k].tags.size();
  return missing;
}

TEST(Contradictions, AnIdThatMostFramesContradictIsLeftOutButNotAllIds) {
  EXPECT_EQ(MissingInTheOthers(/*all_tags=*/false), 3U);
  EXPECT_EQ(MissingInTheOthers(/*all_tags=*/true), 0U);
}

}  // namespace
}  // namespace tagtwist::internal::contradictions_test

#include "frontend/closed_form.h"

#include <gtest/gtest.h>

#include <functional>

#include "tests/support/draws.h"
#include "tests/support/flights/tag_scene.h"

namespace tagtwist::internal::closed_form_test {
namespace {

constexpr double kDtS = 0.02;

// A body that moves at constant velocity and turns at a constant rate.
struct Motion {
  Pose start = Hover({1.5, 1.2, 1.3}, 0.3, {0.1, -0.05, 0});
  Twist twist{{0.4, -0.3, 0.1}, {0.2, -0.3, 0.4}};

  Pose At(double t_s) const {
    return MakePose(start.rotation() * ExpSo3(t_s * twist.omega_body),
                    start.translation() + t_s * twist.v_world);
  }
};

struct View {
  int64_t t_ns = 0;
  std::vector<TagDetection> tags;
  std::vector<TrackObservation> tracks;
};

// What the camera sees of the mat and of points on the world's plane z = 0.
View See(const TagMap& map, const Camera& camera, const Pose& world_from_body, double t_s) {
  const Pose cam_from_world = CourseCamFromBody() * Inverse(world_from_body);
  View view;
  view.t_ns = static_cast<int64_t>(std::llround(1e9 * t_s));
  view.tags = SeeTags(map, camera, cam_from_world);
  std::mt19937_64 engine(23);
  std::uniform_real_distribution<double> place(0, 3);
  for (int id = 0; id < 600; ++id) {
    TrackObservation track;
    track.track_id = id;
    Eigen::Vector3d point_in_world;
    point_in_world << DrawVector<2>(place, engine), 0;
    if (camera.Project(cam_from_world * point_in_world, &track.pixel) &&
        camera.Contains(track.pixel)) {
      view.tracks.push_back(track);
    }
  }
  return view;
}

class ClosedFormTest : public testing::Test {
 protected:
  ClosedForm Step(ClosedFormEstimator* estimator, double t_s,
                  const std::function<void(View*)>& change = nullptr) const {
    View view = See(map_, camera_, motion_.At(t_s), t_s);
    if (change) change(&view);
    return estimator->Update(view.t_ns, view.tags, view.tracks);
  }
  ClosedFormEstimator Make(const ClosedFormOptions& options = {}) const {
    return {camera_, CourseCamFromBody(), map_, options};
  }
  double VelocityError(const std::optional<Twist>& twist) const {
    return twist ? (twist->v_world - motion_.twist.v_world).norm() : 1e9;
  }
  double RateError(const std::optional<Twist>& twist) const {
    return twist ? (twist->omega_body - motion_.twist.omega_body).norm() : 1e9;
  }

  TagMap map_ = MakeTagMap(TagGrid());
  Camera camera_;
  Motion motion_;
};

TEST_F(ClosedFormTest, RecoversPoseAndTwist) {
  auto estimator = Make();
  const ClosedForm first = Step(&estimator, 0);
  ASSERT_TRUE(first.world_from_body);
  EXPECT_FALSE(first.twist_plain || first.twist_ransac || first.twist_low_pass);
  for (int i = 1; i < 5; ++i) {
    const ClosedForm closed_form = Step(&estimator, i * kDtS);
    ASSERT_TRUE(closed_form.world_from_body);
    EXPECT_LT(PositionErrorM(*closed_form.world_from_body, motion_.At(i * kDtS)), 1e-9);
    EXPECT_LT(RotationErrorRad(*closed_form.world_from_body, motion_.At(i * kDtS)), 1e-7);
    // A backward difference: the error is that of a first-order step.
    EXPECT_LT(VelocityError(closed_form.twist_plain), 0.02);
    EXPECT_LT(RateError(closed_form.twist_plain), 0.02);
    EXPECT_LT(VelocityError(closed_form.twist_ransac), 0.02);
    EXPECT_LT(RateError(closed_form.twist_ransac), 0.02);
    EXPECT_LT(VelocityError(closed_form.twist_low_pass), 0.02);
  }
}

TEST_F(ClosedFormTest, SeesThroughADistortingLens) {
  camera_.k1 = -0.2;
  camera_.k2 = 0.04;
  auto estimator = Make();
  Step(&estimator, 0);
  const ClosedForm closed_form = Step(&estimator, kDtS);
  EXPECT_LT(PositionErrorM(*closed_form.world_from_body, motion_.At(kDtS)), 1e-6);
  EXPECT_LT(VelocityError(closed_form.twist_ransac), 0.02);
}

TEST_F(ClosedFormTest, RansacWithstandsTracksThatSlip) {
  auto estimator = Make();
  Step(&estimator, 0);
  const ClosedForm closed_form = Step(&estimator, kDtS, [](View* view) {
    for (size_t i = 0; i < view->tracks.size(); i += 4) {
      view->tracks[i].pixel += Eigen::Vector2d(8, -5);
    }
  });
  EXPECT_LT(VelocityError(closed_form.twist_ransac), 0.02);
  EXPECT_GT(VelocityError(closed_form.twist_plain), 0.1);
}

TEST_F(ClosedFormTest, TagCornersStandInForTracks) {
  auto estimator = Make();
  const auto drop_tracks = [](View* view) { view->tracks.clear(); };
  Step(&estimator, 0, drop_tracks);
  const ClosedForm closed_form = Step(&estimator, kDtS, drop_tracks);
  EXPECT_LT(VelocityError(closed_form.twist_ransac), 0.02);
  EXPECT_LT(RateError(closed_form.twist_ransac), 0.02);
}

TEST_F(ClosedFormTest, AFrameWithoutTagsHasNoAnswerButItsTracksServeTheNext) {
  auto estimator = Make();
  Step(&estimator, 0);
  const ClosedForm blind = Step(&estimator, kDtS, [](View* view) { view->tags.clear(); });
  EXPECT_FALSE(blind.world_from_body || blind.twist_plain || blind.twist_ransac ||
               blind.twist_low_pass);
  EXPECT_LT(VelocityError(Step(&estimator, 2 * kDtS).twist_ransac), 0.02);
}

TEST_F(ClosedFormTest, AGapGivesNoTwistAndRestartsTheLowPass) {
  auto estimator = Make();
  Step(&estimator, 0);
  Step(&estimator, kDtS);
  motion_.twist.v_world *= -1;
  const ClosedForm after = Step(&estimator, kDtS + 0.7);
  EXPECT_TRUE(after.world_from_body);
  EXPECT_FALSE(after.twist_plain || after.twist_low_pass);
  const ClosedForm next = Step(&estimator, 2 * kDtS + 0.7);
  ASSERT_TRUE(next.twist_low_pass);
  EXPECT_EQ(next.twist_low_pass->v_world, next.twist_ransac->v_world);
}

TEST_F(ClosedFormTest, LowPassWeighsThePast) {
  auto estimator = Make();
  Step(&estimator, 0);
  const ClosedForm first = Step(&estimator, kDtS);
  const ClosedForm second = Step(&estimator, 2 * kDtS);
  const Eigen::Vector3d expected =
      0.8 * first.twist_low_pass->v_world + 0.2 * second.twist_ransac->v_world;
  EXPECT_LT((second.twist_low_pass->v_world - expected).norm(), 1e-12);
}

TEST_F(ClosedFormTest, MeanIntervalIsAnOption) {
  ClosedFormOptions options;
  options.mean_dt = true;
  auto mean = Make(options), measured = Make();
  for (auto* estimator : {&mean, &measured}) {
    Step(estimator, 0);
    Step(estimator, 0.02);
  }
  const Twist with_mean = *Step(&mean, 0.06).twist_plain;  // mean interval 0.03 s
  const Twist with_measured = *Step(&measured, 0.06).twist_plain;
  EXPECT_LT((with_mean.v_world - with_measured.v_world * 0.04 / 0.03).norm(), 1e-9);
}

// Tags of two planes, tracks on those tags: each track's depth is that of the tag under it.
TEST_F(ClosedFormTest, TakesDepthFromTheTagUnderATrack) {
  std::vector<Tag> tags = map_.tags();
  for (Tag& tag : tags) {
    const bool raised = tag.id % 3 == 0;
    if (raised) tag.world_from_tag.params[6] = 0.25;  // z
  }
  map_ = TagMap("tag36h11", tags);
  auto estimator = Make();
  const auto tracks_on_tags = [](View* view) {
    view->tracks.clear();
    for (const TagDetection& tag : view->tags) {
      for (int64_t c = 0; c < 4; ++c) {
        view->tracks.push_back({4 * tag.id + c, tag.corners[static_cast<size_t>(c)], true});
      }
    }
  };
  Step(&estimator, 0, tracks_on_tags);
  const ClosedForm closed_form = Step(&estimator, kDtS, tracks_on_tags);
  ASSERT_TRUE(closed_form.world_from_body);
  EXPECT_LT(PositionErrorM(*closed_form.world_from_body, motion_.At(kDtS)), 1e-8);
  EXPECT_LT(VelocityError(closed_form.twist_plain), 0.02);
}

TEST(ClosedFormOptions, NamesTheBrokenRule) {
  EXPECT_FALSE(ClosedFormOptions().Problem());
  ClosedFormOptions options;
  options.low_pass_alpha = 1;
  EXPECT_NE(options.Problem().value_or("").find("low_pass_alpha"), std::string::npos);
  options = {};
  options.ransac_threshold_px = -1;
  EXPECT_EQ(options.Problem().value_or(""), "ransac_threshold_px: expected > 0, got -1");
}

}  // namespace
}  // namespace tagtwist::internal::closed_form_test

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "estimator/rig/rig_pose.h"
#include "estimator/systematic/systematic_basis.h"
#include "tests/support/flights/exact_model.h"
#include "tests/support/flights/rig_flights.h"
#include "tests/support/flights/tag_scene.h"

namespace tagtwist::internal::standing_test {
namespace {

// From that place it looks at the origin, the image's top towards -y of W.
Pose LooksFrom(const Eigen::Vector3d& place) {
  Eigen::Matrix3d world_from_cam;
  world_from_cam.col(2) = -place.normalized();
  world_from_cam.col(0) = Eigen::Vector3d::UnitY().cross(world_from_cam.col(2)).normalized();
  world_from_cam.col(1) = world_from_cam.col(2).cross(world_from_cam.col(0));
  return Inverse(MakePose(Eigen::Quaterniond(world_from_cam), place));
}

// Three cameras over a board of four tags.
SetUp Watched() {
  SetUp out;
  std::vector<Tag> tags;
  for (int i = 0; i < 4; ++i) {
    tags.push_back(
        {i, MakePose(ExpSo3({0, 0, 0.1 * i}), {i % 2 ? 0.08 : -0.08, i < 2 ? 0.09 : -0.07, 0}),
         0.12, 0});
  }
  out.map = TagMap("tag36h11", tags);
  Camera camera;
  camera.width = 640, camera.height = 480;
  camera.fx = camera.fy = 400, camera.cx = 320, camera.cy = 240;
  out.rig.cameras.clear();
  out.rig.mounted_on = MountedOn::kWorld;
  for (const Eigen::Vector3d& place : {Eigen::Vector3d(0.1, 0.2, 2), Eigen::Vector3d(1.2, 0, 1.7),
                                       Eigen::Vector3d(-1.1, 0.3, 1.8)}) {
    out.rig.cameras.push_back({"cam", camera, 0, LooksFrom(place), 0});
  }
  return out;
}

Pose CamFromMap(const SetUp& set_up, size_t camera, const Pose& world_from_body) {
  return set_up.rig.cameras[camera].cam_from_body * world_from_body;
}

// A board that moves about the origin; frame i is of camera i % 3, or of all.
ExactModelFlight Move(const ExactModelOptions& model, bool in_turn) {
  const SetUp set_up = Watched();
  ExactModelFlight out = DrawFlight(model, CourseSetup(), Pose());
  for (size_t i = 0; i < out.truth.size(); ++i) {
    out.measurements[i].tags.clear();
    for (size_t camera = 0; camera < 3; ++camera) {
      if (in_turn && i % 3 != camera) continue;
      const auto seed = static_cast<unsigned>(1000 * model.random_seed + 3 * i + camera);
      for (TagDetection tag : SeeTags(set_up.map, set_up.rig.cameras[camera].camera,
                                      CamFromMap(set_up, camera, out.truth[i].world_from_body),
                                      model.corner_sigma_px, seed)) {
        tag.camera = static_cast<int>(camera);
        out.measurements[i].tags.push_back(tag);
      }
    }
  }
  return out;
}

void ExpectHonest(bool in_turn) {
  ExpectHonestEstimates(Watched(),
                        [&](const ExactModelOptions& model) { return Move(model, in_turn); });
}

TEST(Standing, SlowCovariancesHoldOfABoardThatAllSee) { ExpectHonest(false); }

TEST(Standing, SlowCovariancesHoldOfABoardThatIsSeenInTurn) { ExpectHonest(true); }

TEST(Standing, TheTagsOfOneFrameSayWhereTheBodyIs) {
  const tagtwist::SetUp set_up = Watched();
  const EstimatorSetup setup = MakeEstimatorSetup(set_up, {});
  const Pose truth = MakePose(ExpSo3({0.2, -0.1, 2}), {0.1, -0.05, 0.2});
  std::vector<TagDetection> tags;
  for (size_t camera = 0; camera < 3; ++camera) {
    for (TagDetection tag : SeeTags(set_up.map, set_up.rig.cameras[camera].camera,
                                    CamFromMap(set_up, camera, truth))) {
      tag.camera = static_cast<int>(camera);
      tags.push_back(tag);
    }
    std::vector<TagDetection> own;
    std::copy_if(tags.begin(), tags.end(), std::back_inserter(own),
                 [&](const TagDetection& tag) { return tag.camera == static_cast<int>(camera); });
    EXPECT_LT(Difference(FindPoseOfTags(setup, own).world_from_body, truth).norm(), 1e-6);
  }
  EXPECT_LT(Difference(FindPoseOfTags(setup, tags).world_from_body, truth).norm(), 1e-6);
  const auto mirrored = MirroredPoseOf(setup, tags, truth);
  ASSERT_TRUE(mirrored);
  const auto again = MirroredPoseOf(setup, tags, *mirrored);
  ASSERT_TRUE(again);
  EXPECT_LT(Difference(*again, truth).norm(), 1e-9);
}

// What a column of the basis says that corners do, against where they are seen when the set-up has
// changed by that much.
struct Change {
  int column;
  SetUp set_up;
};

TEST(Standing, ErrorsOfTagsAndMountsDoWhatTheBasisSays) {
  constexpr double kStep = 1e-6;
  const tagtwist::SetUp set_up = Watched();
  const EstimatorSetup setup = MakeEstimatorSetup(set_up, {});
  const std::vector<int> ids = {0, 1, 2, 3};
  const SystematicBasis basis(setup, ids);
  const Pose truth = MakePose(ExpSo3({0.2, -0.1, 2}), {0.1, -0.05, 0.2});
  TagDetection tag =
      SeeTags(set_up.map, set_up.rig.cameras[1].camera, CamFromMap(set_up, 1, truth)).front();
  tag.camera = 1;
  NoiseModel noise;
  noise.corner_sigma_px = 1;
  SystematicBasis::TagTerms terms;
  ASSERT_TRUE(basis.Linearize(noise, truth, tag, &terms));
  const auto effect_of = [&](int column) -> Eigen::Matrix<double, 8, 1> {
    for (size_t i = 0; i < terms.columns.size(); ++i) {
      if (terms.columns[i] == column) return terms.by_parameters.col(static_cast<Eigen::Index>(i));
    }
    ADD_FAILURE() << "no column " << column;
    return Eigen::Matrix<double, 8, 1>::Zero();
  };
  // After the tags come the turns and the places of two mounts.
  const int mounts = *basis.FirstOfTag(ids.back()) + SystematicBasis::kTagParameters;
  std::vector<Change> changes;
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3d step = kStep * Eigen::Vector3d::Unit(axis);
    tagtwist::SetUp moved = set_up;
    std::vector<Tag> all = moved.map.tags();
    Tag& one = all[static_cast<size_t>(tag.id)];
    one.world_from_tag =
        MakePose(one.world_from_tag.rotation(), one.world_from_tag.translation() + step);
    moved.map = TagMap("tag36h11", all);
    changes.push_back({*basis.FirstOfTag(tag.id) + axis, moved});
    for (const bool turn : {true, false}) {
      tagtwist::SetUp other = set_up;
      Pose& mount = other.rig.cameras[1].cam_from_body;
      const Pose error =
          turn ? MakePose(ExpSo3(step), {0, 0, 0}) : MakePose(Eigen::Quaterniond::Identity(), step);
      mount = mount * error;  // as a mount on the body errs: cam_from_body Exp(error)
      changes.push_back({mounts + (turn ? 0 : 6) + axis, other});
    }
  }
  for (const Change& change : changes) {
    const auto seen = SeeTags(change.set_up.map, change.set_up.rig.cameras[1].camera,
                              CamFromMap(change.set_up, 1, truth));
    Eigen::Matrix<double, 8, 1> moved;
    for (int c = 0; c < 4; ++c) {
      moved.segment<2>(2 * c) =
          (seen.front().corners[static_cast<size_t>(c)] - tag.corners[static_cast<size_t>(c)]) /
          kStep;
    }
    EXPECT_LT((moved - effect_of(change.column)).norm(), 1e-3 * moved.norm()) << change.column;
  }
}

}  // namespace
}  // namespace tagtwist::internal::standing_test

#include "estimator/calibration/mapping.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <random>

#include "frontend/base/statistics/chi_square.h"
#include "frontend/types/so3.h"
#include "tests/support/draws.h"

namespace tagtwist::internal::mapping_test {
namespace {

constexpr double kSizeM = 0.12, kCornerPx = 0.5;

Camera RoomCamera() {
  Camera camera;
  camera.width = 640, camera.height = 480;
  camera.fx = camera.fy = 420, camera.cx = 320, camera.cy = 240;
  return camera;
}

Eigen::Quaterniond FromColumns(const Eigen::Vector3d& x, const Eigen::Vector3d& z) {
  Eigen::Matrix3d rotation;
  rotation << x, z.cross(x), z;
  return Eigen::Quaterniond(rotation);
}

// Forty tags on three walls of a room of 4 x 4 m: x = 2, y = 2, y = -2; z is up.
std::vector<Tag> Room(std::mt19937* rng) {
  std::uniform_real_distribution<double> off(-0.15, 0.15);
  std::vector<Tag> out;
  for (int i = 0; i < 40; ++i) {
    const double along = -1.6 + 0.5 * (i % 7) + off(*rng);
    const double up = 0.5 + 0.9 * ((i / 7) % 2) + off(*rng);
    const Eigen::Vector3d vertical(0, 0, 1);
    Pose pose;
    if (i < 14) {
      pose = MakePose(FromColumns({0, -1, 0}, {-1, 0, 0}), {2, along, up});
    } else if (i < 28) {
      pose = MakePose(FromColumns({1, 0, 0}, {0, -1, 0}), {along, 2, up});
    } else {
      pose = MakePose(FromColumns({-1, 0, 0}, {0, 1, 0}), {along, -2, up});
    }
    out.push_back({i + 3, pose, kSizeM});
  }
  return out;
}

// Turning from wall to wall, up and down.
Pose WorldFromCamAt(double t) {
  const double yaw = 1.7 * std::sin(0.25 * t), pitch = 0.15 * std::sin(1.1 * t);
  const Eigen::Vector3d ahead(std::cos(yaw) * std::cos(pitch), std::sin(yaw) * std::cos(pitch),
                              std::sin(pitch));
  const Eigen::Vector3d right = ahead.cross(Eigen::Vector3d::UnitZ()).normalized();
  return MakePose(
      FromColumns(right, ahead),
      {-0.5 + 0.6 * std::sin(0.7 * t), 0.7 * std::sin(0.9 * t), 0.9 + 0.4 * std::sin(0.5 * t)});
}

std::vector<FrameMeasurements> Look(const std::vector<Tag>& room, int frames, std::mt19937* rng) {
  std::normal_distribution<double> noise(0, kCornerPx);
  const Camera camera = RoomCamera();
  std::vector<FrameMeasurements> out;
  for (int i = 0; i < frames; ++i) {
    const double t = 0.15 * i;
    const Pose cam_from_world = Inverse(WorldFromCamAt(t));
    FrameMeasurements frame;
    frame.t_ns = 150'000'000LL * i;
    for (const Tag& tag : room) {
      TagDetection seen;
      seen.id = tag.id;
      bool visible = true;
      const auto corners = TagCornersInWorld(tag);
      for (size_t c = 0; c < 4; ++c) {
        visible = visible && camera.Project(cam_from_world * corners[c], &seen.corners[c]) &&
                  camera.Contains(seen.corners[c], 2);
        seen.corners[c] += DrawVector<2>(noise, *rng);
      }
      if (visible) frame.tags.push_back(seen);
    }
    out.push_back(frame);
  }
  return out;
}

TEST(Mapping, SlowRoomOfFortyTagsFromNothingButTheirSize) {
  std::mt19937 rng(5);
  const std::vector<Tag> room = Room(&rng);
  MappingOptions options;
  options.tag_size_m = kSizeM;
  options.root = 8;
  const auto mapping = MapTags(RoomCamera(), Look(room, 200, &rng), options);
  ASSERT_TRUE(mapping) << mapping.error().message;
  EXPECT_TRUE(mapping->left_out.empty());
  ASSERT_EQ(mapping->map.tags().size(), 40u);
  EXPECT_NEAR(mapping->corner_sigma_px, kCornerPx, 0.05);
  const TagMap truth("tag36h11", room);
  const Pose root_from_world = Inverse(truth.Find(8)->world_from_tag);
  double squares = 0, bound = 0;
  for (size_t i = 0; i < mapping->map.tags().size(); ++i) {
    const Tag& tag = mapping->map.tags()[i];
    const Pose expected = root_from_world * truth.Find(tag.id)->world_from_tag;
    squares += (tag.world_from_tag.translation() - expected.translation()).squaredNorm();
    bound += mapping->covariances[i].bottomRightCorner<3, 3>().trace();
    EXPECT_LT(LogSo3(expected.rotation().conjugate() * tag.world_from_tag.rotation()).norm(), 0.1)
        << "tag " << tag.id << ": flipped or turned";
  }
  RecordProperty("position_rmse_mm", std::to_string(1e3 * std::sqrt(squares / 40)));
  RecordProperty("bound_mm", std::to_string(1e3 * std::sqrt(bound / 40)));
  EXPECT_LT(std::sqrt(squares), 1.2 * std::sqrt(bound));
  EXPECT_LT(std::sqrt(bound / 40), 0.1);
}

TEST(Mapping, TagsThatTheMapLacksAreAddedToIt) {
  std::mt19937 rng(6);
  const std::vector<Tag> room = Room(&rng);
  MappingOptions options;
  options.tag_size_m = kSizeM;
  for (const Tag& tag : room) {
    if (tag.id % 5 != 0) options.known.push_back(tag);
  }
  const auto mapping = MapTags(RoomCamera(), Look(room, 200, &rng), options);
  ASSERT_TRUE(mapping) << mapping.error().message;
  EXPECT_TRUE(mapping->left_out.empty());
  ASSERT_EQ(mapping->map.tags().size(), 40u);
  const TagMap truth("tag36h11", room);
  double nees = 0;
  for (size_t i = 0; i < 40; ++i) {
    const Tag& tag = mapping->map.tags()[i];
    const Pose& expected = truth.Find(tag.id)->world_from_tag;
    Eigen::Matrix<double, 6, 1> error;
    error << LogSo3(expected.rotation().conjugate() * tag.world_from_tag.rotation()),
        tag.world_from_tag.translation() - expected.translation();
    if (i < options.known.size()) {
      EXPECT_EQ(tag.id, options.known[i].id);
      EXPECT_EQ(error.norm(), 0);
      EXPECT_EQ(mapping->covariances[i].norm(), 0);
    } else {
      nees += error.dot(mapping->covariances[i].ldlt().solve(error));
    }
  }
  const auto [low, high] = MeanChiSquareBand(6.0 * 8, 1);
  EXPECT_GT(nees, low);
  EXPECT_LT(nees, high);
}

TEST(Mapping, WhatCannotBePlacedIsSaid) {
  std::mt19937 rng(5);
  std::vector<Tag> room = Room(&rng);
  room.resize(4);
  std::vector<FrameMeasurements> frames = Look(room, 200, &rng);
  TagDetection stray;  // seen twice, alone
  stray.id = 77;
  stray.corners = {Eigen::Vector2d(100, 140), Eigen::Vector2d(140, 140), Eigen::Vector2d(140, 100),
                   Eigen::Vector2d(100, 100)};
  frames[3].tags.push_back(stray);
  frames[9].tags.push_back(stray);
  MappingOptions options;
  options.tag_size_m = kSizeM;
  const auto mapping = MapTags(RoomCamera(), frames, options);
  ASSERT_TRUE(mapping) << mapping.error().message;
  EXPECT_EQ(mapping->map.tags().size(), 4u);
  EXPECT_EQ(mapping->left_out, std::vector<int>{77});

  options.root = 500;
  const auto rootless = MapTags(RoomCamera(), frames, options);
  ASSERT_FALSE(rootless);
  EXPECT_EQ(rootless.error().message, "tag 500, which is to fix the world, is never seen");
  const auto nothing = MapTags(RoomCamera(), {}, options);
  ASSERT_FALSE(nothing);
  EXPECT_EQ(nothing.error().message, "no frame shows a tag");
}

}  // namespace
}  // namespace tagtwist::internal::mapping_test

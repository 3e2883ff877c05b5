// What files say of the errors of a camera and a map: it is in the estimate's options, unless the
// section `estimator` says another.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "estimator/online/config.h"
#include "tests/support/temp_folder.h"
#include "tests/support/test_files.h"

namespace tagtwist::internal::set_up_sigmas_test {
namespace {

using testing::HasSubstr;

constexpr const char* kLens = "width: 752, height: 480, fx: 458, fy: 457, cx: 367, cy: 248";
constexpr const char* kTags = "tags: [{id: 1, size_m: 0.1, position_m: [0, 0, 0]}]";

class SetUpSigmas : public testing::Test {
 protected:
  std::string Write(const std::string& name, const std::string& text) const {
    WriteText(folder_ / name, text);
    return folder_ / name;
  }
  Result<Config> Load(const std::string& text) const { return LoadConfig(Write("c.yaml", text)); }
  std::string Refusal(const std::string& text) const {
    const auto config = Load(text);
    return config ? "" : config.error().message;
  }
  std::string Camera(const std::string& more) const {
    return "camera: {" + std::string(kLens) + more + "}\n";
  }
  const TempFolder folder_;
};

TEST_F(SetUpSigmas, NothingIsKnownWhereNothingIsSaid) {
  const auto config = Load(Camera("") + "tag_map: {" + kTags + "}\n");
  ASSERT_TRUE(config) << config.error().message;
  EXPECT_FALSE(config->estimator.focal_sigma);
  EXPECT_FALSE(config->estimator.tag_sigma_m);
}

TEST_F(SetUpSigmas, OfCameraAndMapAreTheEstimates) {
  const auto config =
      Load(Camera(", focal_sigma: 0.01") + "tag_map: {sigma_m: 0.002, " + kTags + "}\n");
  ASSERT_TRUE(config) << config.error().message;
  EXPECT_EQ(config->estimator.focal_sigma, 0.01);
  EXPECT_EQ(config->estimator.tag_sigma_m, 0.002);
  EXPECT_THAT(config->origins.camera, HasSubstr("c.yaml (focal length +- 1 %)"));
  EXPECT_THAT(config->origins.map, HasSubstr("c.yaml (tags +- 2 mm)"));
}

TEST_F(SetUpSigmas, WhatTheEstimatorsSectionSaysGoesFirst) {
  const auto config = Load(Camera(", focal_sigma: 0.01") + "tag_map: {sigma_m: 0.002, " + kTags +
                           "}\nestimator: {focal_sigma: 0.03, tag_sigma_m: 0}\n");
  ASSERT_TRUE(config) << config.error().message;
  EXPECT_EQ(config->estimator.focal_sigma, 0.03);
  EXPECT_EQ(config->estimator.tag_sigma_m, 0);
}

TEST_F(SetUpSigmas, OfFilesBesideTheConfigurationCount) {
  Write("camera.yaml", Camera(", focal_sigma: 0.01"));
  Write("map.yaml", "tag_map: {sigma_m: 0.002, " + std::string(kTags) + "}\n");
  const auto named = Load(
      "camera: {file: camera.yaml}\n"
      "tag_map: {file: map.yaml, sigma_m: 0.003}\n");
  ASSERT_TRUE(named) << named.error().message;
  EXPECT_EQ(named->estimator.focal_sigma, 0.01);
  EXPECT_EQ(named->estimator.tag_sigma_m, 0.003);
  ConfigFiles files;
  files.camera_file = folder_ / "camera.yaml";
  files.map.path = folder_ / "map.yaml";
  const auto given = LoadConfig(files);
  ASSERT_TRUE(given) << given.error().message;
  EXPECT_EQ(given->estimator.focal_sigma, 0.01);
  EXPECT_EQ(given->estimator.tag_sigma_m, 0.002);
  EXPECT_THAT(given->origins.map, HasSubstr("map.yaml (tags +- 2 mm)"));
}

// Where the configuration's own camera is not the one that is used, nor is its sigma.
TEST_F(SetUpSigmas, OfACameraThatIsNotUsedDoNotCount) {
  ConfigFiles files;
  files.config = Write("c.yaml", Camera(", focal_sigma: 0.01"));
  files.camera_file = Write("other.yaml", Camera(""));
  const auto config = LoadConfig(files);
  ASSERT_TRUE(config) << config.error().message;
  EXPECT_FALSE(config->estimator.focal_sigma);
}

TEST_F(SetUpSigmas, OfSeveralCamerasTheLargestCounts) {
  const std::string mount =
      "cam_from_body: {quaternion_xyzw: [0, 0, 0, 1], translation_m: [0, 0, 0]}";
  const auto config = Load("cameras:\n  - {name: a, camera: {" + std::string(kLens) +
                           ", focal_sigma: 0.001}, " + mount + "}\n  - {name: b, camera: {" +
                           kLens + ", focal_sigma: 0.004}, " + mount + "}\n");
  ASSERT_TRUE(config) << config.error().message;
  EXPECT_EQ(config->estimator.focal_sigma, 0.004);
}

TEST_F(SetUpSigmas, ImpossibleOnesAreRefused) {
  EXPECT_THAT(Refusal(Camera(", focal_sigma: -0.01")),
              HasSubstr("c.yaml:1: camera.focal_sigma: expected in [0, 1]"));
  EXPECT_THAT(Refusal(Camera(", focal_sigma: .nan")), HasSubstr("camera.focal_sigma: expected"));
  EXPECT_THAT(Refusal("tag_map: {sigma_m: -1, " + std::string(kTags) + "}\n"),
              HasSubstr("tag_map.sigma_m: expected in"));
  EXPECT_THAT(Refusal("tag_map: {sigma_m: [1], " + std::string(kTags) + "}\n"),
              HasSubstr("tag_map.sigma_m: expected"));
}

}  // namespace
}  // namespace tagtwist::internal::set_up_sigmas_test

// What files say of the errors of a camera, its mount and a map: of a camera it goes with it, of a
// map into the estimate's options, unless the section `estimator` says another.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "estimator/online/config.h"
#include "estimator/online/config_text.h"
#include "frontend/io/setup/camera_file.h"
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

// Of the first camera, relative; 0 where nothing is said.
double FocalSigma(const Config& config, size_t camera = 0) {
  const Eigen::MatrixXd& covariance = config.set_up.rig.cameras.at(camera).covariance;
  return covariance.size() == 0 ? 0 : std::sqrt(covariance(0, 0));
}

TEST_F(SetUpSigmas, NothingIsKnownWhereNothingIsSaid) {
  const auto config = Load(Camera("") + "tag_map: {" + kTags + "}\n");
  ASSERT_TRUE(config) << config.error().message;
  EXPECT_EQ(config->set_up.rig.front().covariance.size(), 0);
  EXPECT_FALSE(config->estimator.tag_sigma_m);
}

TEST_F(SetUpSigmas, OfCameraAndMapAreTheEstimates) {
  const auto config =
      Load(Camera(", focal_sigma: 0.01") + "tag_map: {sigma_m: 0.002, " + kTags + "}\n");
  ASSERT_TRUE(config) << config.error().message;
  EXPECT_DOUBLE_EQ(FocalSigma(*config), 0.01);
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
  EXPECT_DOUBLE_EQ(FocalSigma(*named), 0.01);
  EXPECT_EQ(named->estimator.tag_sigma_m, 0.003);
  ConfigFiles files;
  files.camera_file = folder_ / "camera.yaml";
  files.map.path = folder_ / "map.yaml";
  const auto given = LoadConfig(files);
  ASSERT_TRUE(given) << given.error().message;
  EXPECT_DOUBLE_EQ(FocalSigma(*given), 0.01);
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
  EXPECT_EQ(FocalSigma(*config), 0);
}

TEST_F(SetUpSigmas, OfSeveralCamerasEachHasItsOwn) {
  const std::string mount =
      "cam_from_body: {quaternion_xyzw: [0, 0, 0, 1], translation_m: [0, 0, 0]}";
  const auto config = Load("cameras:\n  - {name: a, camera: {" + std::string(kLens) +
                           ", focal_sigma: 0.001}, " + mount + "}\n  - {name: b, camera: {" +
                           kLens + ", focal_sigma: 0.004}, " + mount + "}\n");
  ASSERT_TRUE(config) << config.error().message;
  EXPECT_DOUBLE_EQ(FocalSigma(*config, 0), 0.001);
  EXPECT_DOUBLE_EQ(FocalSigma(*config, 1), 0.004);
}

// A drawn covariance of all entries of a lens and its mount, with their correlations.
Eigen::MatrixXd DrawnCovariance(Eigen::Index n) {
  Eigen::MatrixXd root(n, n);
  for (Eigen::Index i = 0; i < n * n; ++i) {
    root(i / n, i % n) = std::sin(1.7 * static_cast<double>(i * i));
  }
  const Eigen::VectorXd scale = Eigen::VectorXd::LinSpaced(n, -4, -1).array().exp();
  return scale.asDiagonal() * root * root.transpose() * scale.asDiagonal();
}

double OffInSigmas(const Eigen::MatrixXd& one, const Eigen::MatrixXd& other) {
  const Eigen::VectorXd inverse = other.diagonal().cwiseSqrt().cwiseInverse();
  return (inverse.asDiagonal() * (one - other) * inverse.asDiagonal()).cwiseAbs().maxCoeff();
}

TEST_F(SetUpSigmas, AreReadAsTheyAreWritten) {
  for (const char* model : {"radtan, distortion: [0.1, 0, 0, 0]",
                            "equidistant, distortion: [0, 0, "
                            "0, 0]",
                            "fov, distortion: [0.9]"}) {
    auto config = Load(Camera(std::string(", distortion_model: ") + model));
    ASSERT_TRUE(config) << config.error().message;
    RigCamera& camera = config->set_up.rig.front();
    ASSERT_EQ(camera.covariance.size(), 0);
    const Eigen::Index n = 8 + 2 +
                           static_cast<Eigen::Index>(model[0] == 'r'   ? 8
                                                     : model[0] == 'e' ? 4
                                                                       : 1);
    camera.covariance = DrawnCovariance(n);
    const std::string lens = CameraSectionText(*config), mount = MountSectionText(*config);
    const auto again = Load(lens + mount);
    ASSERT_TRUE(again) << again.error().message;
    const Eigen::MatrixXd& read = again->set_up.rig.front().covariance;
    ASSERT_EQ(read.rows(), n);
    EXPECT_LT(OffInSigmas(read, camera.covariance), 1e-8) << lens << mount;
    // Read as a file of a camera it is the lens's part alone.
    const auto alone = ReadCameraFile(Write("camera.yaml", lens), "");
    ASSERT_TRUE(alone) << alone.error().message;
    ASSERT_EQ(alone->covariance.rows(), n);
    EXPECT_LT((alone->covariance - read).topLeftCorner(n - 6, n - 6).norm(), 1e-15);
    EXPECT_EQ(alone->covariance.rightCols(6).norm(), 0);
  }
}

// Of a mount beside another camera than its own its sigmas count, its correlations do not.
TEST_F(SetUpSigmas, OfAMountGoWithItsOwnLens) {
  auto config = Load(Camera(", principal_point_sigma_px: [2, 3]"));
  ASSERT_TRUE(config) << config.error().message;
  Eigen::MatrixXd& covariance = config->set_up.rig.front().covariance;
  covariance(13, 13) = 1e-4;
  covariance(2, 13) = covariance(13, 2) = 0.9 * 2 * 1e-2;
  ConfigFiles files;
  files.config = Write("c.yaml", CameraSectionText(*config) + MountSectionText(*config));
  const auto own = LoadConfig(files);
  ASSERT_TRUE(own) << own.error().message;
  EXPECT_NEAR(own->set_up.rig.front().covariance(13, 2), 0.018, 1e-9);
  files.camera_file = Write("other.yaml", Camera(", principal_point_sigma_px: [2, 3]"));
  const auto mixed = LoadConfig(files);
  ASSERT_TRUE(mixed) << mixed.error().message;
  EXPECT_NEAR(mixed->set_up.rig.front().covariance(2, 2), 4, 1e-12);
  EXPECT_NEAR(mixed->set_up.rig.front().covariance(13, 13), 1e-4, 1e-12);
  EXPECT_EQ(mixed->set_up.rig.front().covariance(13, 2), 0);
}

TEST_F(SetUpSigmas, ImpossibleOnesAreRefused) {
  EXPECT_THAT(Refusal(Camera(", principal_point_sigma_px: [1]")),
              HasSubstr("c.yaml:1: camera.principal_point_sigma_px: expected a list of 2 numbers"));
  EXPECT_THAT(Refusal(Camera(", principal_point_sigma_px: [1, .inf]")), HasSubstr("expected"));
  EXPECT_THAT(Refusal(Camera(", distortion_sigmas: [1, 1, 1, 1, 1, 1, 1, 1, 1]")),
              HasSubstr("camera.distortion_sigmas: expected at most 8 numbers, got 9"));
  EXPECT_THAT(Refusal(Camera(", focal_sigma: 0.1, correlations: [[0.5]]")),
              HasSubstr("camera.correlations: expected a list of 11 rows"));
  EXPECT_THAT(Refusal("cam_from_body: {quaternion_xyzw: [0, 0, 0, 1], translation_m: [0, 0, 0], "
                      "rotation_sigma_rad: [0.1, -0.1, 0.1]}\n"),
              HasSubstr("cam_from_body.rotation_sigma_rad: expected"));
  std::string rows = "[[1.5]";
  for (int row = 2; row < 12; ++row) {
    rows += ", [0";
    for (int k = 1; k < row; ++k) rows += ", 0";
    rows += "]";
  }
  EXPECT_THAT(Refusal(Camera(", focal_sigma: 0.1, aspect_sigma: 0.1, correlations: " + rows + "]")),
              HasSubstr("camera.correlations: expected correlations that can be"));
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

#include "estimator/online/config.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <iomanip>
#include <sstream>

#include "estimator/online/config_text.h"
#include "frontend/types/lens/lens.h"
#include "frontend/types/so3.h"
#include "tests/support/config_of_text.h"
#include "tests/support/test_files.h"

namespace tagtwist::internal::config_test {
namespace {

namespace fs = std::filesystem;
const fs::path kSource = TAGTWIST_SOURCE_DIR;

void ExpectSamePose(const Pose& a, const Pose& b, double tolerance = 1e-15) {
  EXPECT_LT(LogSo3(a.rotation().conjugate() * b.rotation()).norm(), tolerance);
  EXPECT_LT((a.translation() - b.translation()).norm(), tolerance);
}

void ExpectSameMap(const TagMap& a, const TagMap& b) {
  EXPECT_EQ(a.family(), b.family());
  ASSERT_EQ(a.tags().size(), b.tags().size());
  for (size_t i = 0; i < a.tags().size(); ++i) {
    EXPECT_EQ(a.tags()[i].id, b.tags()[i].id);
    EXPECT_EQ(a.tags()[i].size_m, b.tags()[i].size_m);
    EXPECT_EQ(a.tags()[i].world_from_tag.params, b.tags()[i].world_from_tag.params);
  }
}

// Every field of an options struct as text, by name.
struct FieldLister {
  template <typename T>
  void operator()(const char* name, const T& value) {
    std::ostringstream line;
    line << std::setprecision(17) << name << "=";
    if constexpr (std::is_arithmetic_v<T> || std::is_same_v<T, std::string>) {
      line << value;
    } else if constexpr (std::is_enum_v<T>) {
      line << NameOf(value);
    } else {
      value ? line << *value : line << "not given";
    }
    lines.push_back(line.str());
    names.emplace_back(name);
  }
  std::vector<std::string> lines, names;
};
FieldLister ListAllFields(const Config& config) {
  FieldLister lister;
  TagDetectorOptions::VisitFields(config.front_end.detector, lister);
  KltOptions::VisitFields(config.front_end.klt, lister);
  ClosedFormOptions::VisitFields(config.front_end.closed_form, lister);
  EstimatorOptions::VisitFields(config.estimator, lister);
  CalibrationOptions::VisitFields(config.calibration, lister);
  return lister;
}

void ExpectSameButCamera(const Config& a, const Config& b) {
  ExpectSamePose(a.set_up.rig.front().cam_from_body, b.set_up.rig.front().cam_from_body);
  ExpectSameMap(a.set_up.map, b.set_up.map);
  const std::vector<std::string> fields_a = ListAllFields(a).lines;
  const std::vector<std::string> fields_b = ListAllFields(b).lines;
  ASSERT_EQ(fields_a.size(), fields_b.size());
  for (size_t i = 0; i < fields_a.size(); ++i) EXPECT_EQ(fields_a[i], fields_b[i]);
}

void ExpectCamera(const Camera& camera, const std::array<double, 11>& numbers) {
  EXPECT_EQ((std::array<double, 11>{double(camera.width), double(camera.height), camera.fx,
                                    camera.fy, camera.cx, camera.cy, camera.k1, camera.k2,
                                    camera.p1, camera.p2, camera.k3}),
            numbers);
}

TEST(Config, DefaultIsTheCourse) {
  const Config config = DefaultConfig();
  ExpectCamera(config.set_up.rig.front().camera,
               {376, 240, 311.0520, 311.3885, 201.8724, 113.6210, 0, 0, 0, 0, 0});
  // Seed Eq. 1, by a hand-worked point: the body's x axis in the camera is (c, -c, 0).
  const double c = std::sqrt(0.5);
  EXPECT_LT((config.set_up.rig.front().cam_from_body * Eigen::Vector3d(1, 0, 0) -
             Eigen::Vector3d(c - 0.04, -c, -0.03))
                .norm(),
            1e-15);
  EXPECT_EQ(config.set_up.map.tags().size(), 108u);
}

TEST(Config, CourseFileEqualsTheDefaults) {
  const Result<Config> config = LoadConfig((kSource / "configs/course.yaml").string());
  ASSERT_TRUE(config) << config.error().message;
  ExpectCamera(config->set_up.rig.front().camera,
               {376, 240, 311.0520, 311.3885, 201.8724, 113.6210, 0, 0, 0, 0, 0});
  ExpectSameButCamera(*config, DefaultConfig());
}

TEST(Config, CourseFileNamesEveryKey) {
  const std::string text = ReadText(kSource / "configs/course.yaml");
  for (const std::string& name : ListAllFields(Config()).names) {
    const bool named = text.find("\n  " + name + ":") != std::string::npos ||
                       text.find("\n  # " + name + ":") != std::string::npos;
    EXPECT_TRUE(named) << name << " is not in course.yaml; commented where it has no default";
  }
}

TEST(Config, Course2017DiffersInTheCameraMatrixAlone) {
  const Result<Config> config = LoadConfig((kSource / "configs/course_2017.yaml").string());
  ASSERT_TRUE(config) << config.error().message;
  ExpectCamera(config->set_up.rig.front().camera,
               {376, 240, 314.1779, 314.2218, 199.4848, 113.7838, 0, 0, 0, 0, 0});
  ExpectSameButCamera(*config, DefaultConfig());
}

TEST(Config, EveryShippedFileLoads) {
  int files = 0;
  for (const char* folder : {"configs", "tests/configs"}) {
    for (const auto& entry : fs::directory_iterator(kSource / folder)) {
      if (entry.path().extension() != ".yaml") continue;
      const Result<Config> config = LoadConfig(entry.path().string());
      EXPECT_TRUE(config) << config.error().message;
      ++files;
    }
  }
  EXPECT_GE(files, 3);
}

TEST(Config, UmdFloorMatPutsTheTagsWhereTheMapSaysSo) {
  const Result<Config> config = LoadConfig((kSource / "tests/configs/umd_floor_mat.yaml").string());
  ASSERT_TRUE(config) << config.error().message;
  EXPECT_EQ(config->set_up.map.tags().size(), 81u);
  // Its tag 10 spans (0, 0) to (0.193, 0.193).
  const auto& corners = config->set_up.map.CornersInWorld(10);
  EXPECT_LT((corners[0] - Eigen::Vector3d(0, 0, 0)).norm(), 1e-4);
  EXPECT_LT((corners[2] - Eigen::Vector3d(0.193, 0.193, 0)).norm(), 1e-4);
}

TEST(Config, MovableTagsAreNotInTheMap) {
  const TempFolder folder;
  WriteText(folder / "x.yaml", "movable_tags: [7, 300, 7]\n");
  ConfigFiles files;
  files.config = folder / "x.yaml";
  files.movable_tags = {2};
  const Result<Config> config = LoadConfig(files);
  ASSERT_TRUE(config) << config.error().message;
  EXPECT_EQ(config->movable_tags, (std::vector<int>{2, 7, 300}));
  EXPECT_EQ(config->set_up.map.tags().size(), 106u);
  EXPECT_EQ(config->set_up.map.Find(2), nullptr);
  EXPECT_EQ(config->set_up.map.Find(7), nullptr);
  EXPECT_NE(config->set_up.map.Find(8), nullptr);
}

TEST(Config, PartsLeftOutKeepTheirDefaults) {
  const Result<Config> config = ConfigOfText("estimator: {window_frames: 20, accel_psd: 2.5}\n");
  ASSERT_TRUE(config) << config.error().message;
  EXPECT_EQ(config->estimator.window_frames, 20);
  EXPECT_EQ(config->estimator.accel_psd, std::optional<double>(2.5));
  EXPECT_FALSE(config->estimator.corner_sigma_px.has_value());
  EXPECT_EQ(config->estimator.max_iterations, EstimatorOptions().max_iterations);
  EXPECT_EQ(config->set_up.rig.front().camera.fx, Camera().fx);
  ExpectSameMap(config->set_up.map, DefaultConfig().set_up.map);
}

TEST(Config, QuaternionAndMatrixSayTheSame) {
  const Result<Config> config = ConfigOfText(
      "cam_from_body:\n"
      "  quaternion_xyzw: [0.9238795325112867, -0.3826834323650898, 0, 0]\n"
      "  translation_m: [-0.04, 0, -0.03]\n");
  ASSERT_TRUE(config) << config.error().message;
  ExpectSamePose(config->set_up.rig.front().cam_from_body,
                 DefaultConfig().set_up.rig.front().cam_from_body);
}

TEST(Config, DistortionIsReadInOpenCvsOrder) {
  const Result<Config> config = ConfigOfText(
      "camera: {width: 640, height: 480, fx: 400, fy: 401, cx: 320, cy: 240, distortion: [1e-1, "
      "-0.2, 3.0e-3, +4e-4]}\n");
  ASSERT_TRUE(config) << config.error().message;
  ExpectCamera(config->set_up.rig.front().camera,
               {640, 480, 400, 401, 320, 240, 0.1, -0.2, 3e-3, 4e-4, 0});
}

// What is written of any lens is read back as it is.
TEST(Config, EveryLensIsWrittenAsItIsRead) {
  for (const LensModel model :
       {LensModel::kRadialTangential, LensModel::kEquidistant, LensModel::kDoubleSphere,
        LensModel::kExtendedUnified, LensModel::kOmni, LensModel::kFieldOfView}) {
    Config config = DefaultConfig();
    Camera& camera = config.set_up.rig.front().camera;
    camera.lens = model;
    double value = 0.1;
    for (const LensCoefficient& coefficient : LensCoefficients(model)) {
      camera.*coefficient.value = value += 0.01;
    }
    const Result<Config> read = ConfigOfText(CameraSectionText(config));
    ASSERT_TRUE(read) << read.error().message;
    EXPECT_EQ(read->set_up.rig.front().camera.lens, model);
    for (const LensCoefficient& coefficient : LensCoefficients(model)) {
      EXPECT_EQ(read->set_up.rig.front().camera.*coefficient.value, camera.*coefficient.value)
          << LensName(model) << " " << coefficient.name;
    }
  }
}

TEST(Config, TagsInSpace) {
  const Result<Config> config = ConfigOfText(
      "tag_map:\n"
      "  tags:\n"
      "    - {id: 3, size_m: 0.2, position_m: [1, 2, 3]}\n"
      "    - {id: 5, size_m: 0.2, position_m: [0, 0, 0], yaw_rad: 1.5707963267948966}\n"
      "    - {id: 7, corners_m: [[0, 0, 0], [0, 0.4, 0], [0, 0.4, 0.4], [0, 0, 0.4]]}\n"
      "    - {id: 9, size_m: 2, position_m: [5, 0, 0], rotation: [0, 0, 1, 1, 0, 0, 0, 1, 0]}\n");
  ASSERT_TRUE(config) << config.error().message;
  const TagMap& map = config->set_up.map;
  const double tolerance = 1e-12;
  EXPECT_LT((map.CornersInWorld(3)[0] - Eigen::Vector3d(0.9, 1.9, 3)).norm(), tolerance);
  // A quarter turn to the left: bottom-left comes to lie bottom-right.
  EXPECT_LT((map.CornersInWorld(5)[0] - Eigen::Vector3d(0.1, -0.1, 0)).norm(), tolerance);
  EXPECT_NEAR(map.Find(7)->size_m, 0.4, tolerance);
  EXPECT_LT((map.CornersInWorld(7)[1] - Eigen::Vector3d(0, 0.4, 0)).norm(), tolerance);
  EXPECT_LT((map.CornersInWorld(7)[3] - Eigen::Vector3d(0, 0, 0.4)).norm(), tolerance);
  // Columns of the matrix are the tag's axes in W: x is the world's y, y is its z.
  EXPECT_LT((map.CornersInWorld(9)[2] - Eigen::Vector3d(5, 1, 1)).norm(), tolerance);
}

TEST(Config, GridWithOneGapForAll) {
  const Result<Config> config = ConfigOfText(
      "tag_map: {grid: {first_id: 10, rows: 2, columns: 2, tag_size_m: 0.1, row_gaps_m: 0.05, "
      "column_gaps_m: [0.2]}}\n");
  ASSERT_TRUE(config) << config.error().message;
  ASSERT_EQ(config->set_up.map.tags().size(), 4u);
  const Tag* last = config->set_up.map.Find(13);
  ASSERT_NE(last, nullptr);
  EXPECT_LT((last->world_from_tag.translation() - Eigen::Vector3d(0.2, 0.35, 0)).norm(), 1e-12);
}

}  // namespace
}  // namespace tagtwist::internal::config_test

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "estimator/online/config.h"
#include "tests/support/config_of_text.h"
#include "tests/support/test_files.h"

namespace tagtwist::internal::config_refusals_test {
namespace {

using ::testing::HasSubstr;

struct BadFile {
  const char* name;
  const char* text;
  const char* fault;  // the message holds it
};
void PrintTo(const BadFile& bad, std::ostream* out) { *out << bad.name; }

const BadFile kBadFiles[] = {
    {"UnknownSection", "camra: {}\n", "x.yaml:1: camra: expected one of cameras, camera, "},
    {"UnknownKey", "estimator:\n  windw_frames: 3\n",
     "x.yaml:2: estimator.windw_frames: expected one of "},
    {"RepeatedKey", "estimator:\n  window_frames: 7\n\n  window_frames: 8\n",
     "x.yaml:4: estimator.window_frames: expected the key once, got it again (first on line 2)"},
    {"RepeatedSection", "estimator: {}\nestimator: {}\n", "x.yaml:2: estimator: expected the key"},
    {"FractionForWhole", "estimator:\n  window_frames: 2.7\n",
     "x.yaml:2: estimator.window_frames: expected a whole number, got 2.7"},
    {"TextForWhole", "estimator:\n  window_frames: \"9\"\n", "got the text \"9\""},
    {"HugeWhole", "estimator: {window_frames: 99999999999}\n", "expected a whole number"},
    {"YesForBool", "estimator:\n  use_tracks: yes\n",
     "x.yaml:2: estimator.use_tracks: expected true or false, got yes"},
    {"TextForNumber", "estimator: {robust_scale: wide}\n",
     "x.yaml:1: estimator.robust_scale: expected a finite number, got wide"},
    {"ListForNumber", "estimator: {robust_scale: [1, 2]}\n", "got a list of 2"},
    {"TrailingText", "estimator: {robust_scale: 3px}\n", "expected a finite number, got 3px"},
    {"NotANumber", "estimator: {robust_scale: .nan}\n", "expected a finite number, got .nan"},
    {"PlainNan", "estimator: {robust_scale: nan}\n", "expected a finite number, got nan"},
    {"Infinite", "estimator: {accel_psd: .inf}\n", "estimator.accel_psd: expected a finite number"},
    {"Overflow", "estimator: {accel_psd: 1e999}\n", "expected a finite number"},
    {"OutOfRange", "estimator:\n  use_tracks: true\n  window_frames: -3\n",
     "x.yaml:3: estimator.window_frames: expected >= 2, got -3"},
    {"NegativeNoise", "estimator: {accel_psd: -1}\n", "estimator.accel_psd: expected > 0, got -1"},
    {"MovableNoList", "movable_tags: 3\n",
     "x.yaml:1: movable_tags: expected a list of tag ids, got 3"},
    {"MovableNoId", "movable_tags: [3, -1]\n",
     "x.yaml:1: movable_tags[1]: expected a tag id, >= 0, got -1"},
    {"AllMovable",
     "movable_tags: [4]\n"
     "tag_map: {family: tag36h11, tags: [{id: 4, size_m: 0.1, position_m: [0, 0, 0], "
     "quaternion_xyzw: [0, 0, 0, 1]}]}\n",
     "x.yaml: movable_tags: expected a tag of the map that stays, got none"},
    {"EmptySection", "estimator:\n", "x.yaml:1: estimator: expected a mapping, got nothing"},
    {"ListForSection", "camera: [1, 2]\n", "x.yaml:1: camera: expected a mapping, got a list of 2"},
    {"MissingNeededKey", "camera:\n  width: 376\n  height: 240\n",
     "x.yaml:1: camera.fx: expected a value, got none"},
    {"ZeroFocalLength", "camera: {width: 6, height: 4, fx: 0, fy: 3, cx: 3, cy: 2}\n",
     "camera.fx: expected > 0, got 0"},
    {"ShortDistortion",
     "camera: {width: 6, height: 4, fx: 3, fy: 3, cx: 3, cy: 2, distortion: [1]}\n",
     "camera.distortion: expected a list of 4, 5 or 8 numbers, got 1"},
    {"HugeImage", "camera: {width: 1000000, height: 4, fx: 3, fy: 3, cx: 3, cy: 2}\n",
     "camera.width: expected 1..16384, got 1000000"},
    {"SkewedRotation",
     "cam_from_body: {rotation: [1, 0.1, 0, 0, 1, 0, 0, 0, 1], translation_m: [0, 0, 0]}\n",
     "cam_from_body.rotation: expected an orthonormal matrix"},
    {"Reflection", "cam_from_body: {rotation: [1,0,0, 0,1,0, 0,0,-1], translation_m: [0, 0, 0]}\n",
     "cam_from_body.rotation: expected an orthonormal matrix with determinant +1"},
    {"LongQuaternion", "cam_from_body: {quaternion_xyzw: [0, 0, 1, 1], translation_m: [0, 0, 0]}\n",
     "cam_from_body.quaternion_xyzw: expected a unit quaternion, got norm 1.41"},
    {"NoRotation", "cam_from_body: {translation_m: [0, 0, 0]}\n",
     "cam_from_body: expected rotation or quaternion_xyzw, got neither"},
    {"NoTranslation", "cam_from_body: {quaternion_xyzw: [0, 0, 0, 1]}\n",
     "cam_from_body.translation_m: expected a value, got none"},
    {"OtherFamily",
     "tag_map:\n  family: tag36h12\n  tags: [{id: 1, size_m: 1, position_m: [0, 0, 0]}]\n",
     "x.yaml:2: tag_map.family: expected one of tag36h11, "},
    {"IdNotInOtherFamily",
     "tag_map: {family: tag16h5, tags: [{id: 30, size_m: 1, position_m: [0, 0, 0]}]}\n",
     "tag_map.tags[0].id: expected 0..29, got 30"},
    {"EvenWindow", "klt: {window_px: 16}\n", "x.yaml:1: klt.window_px: expected "},
    {"HammingOutOfRange", "detector: {max_hamming: 3}\n", "detector.max_hamming: expected "},
    {"RatioOutOfRange", "closed_form:\n  ransac_inlier_ratio: 1.5\n",
     "x.yaml:2: closed_form.ransac_inlier_ratio: expected "},
    {"NeitherGridNorTags", "tag_map: {family: tag36h11}\n",
     "x.yaml:1: tag_map: expected grid or tags, got neither"},
    {"NoTags", "tag_map: {tags: []}\n", "tag_map.tags: expected a list of tags, got a list of 0"},
    {"TagTwice",
     "tag_map:\n  tags:\n    - {id: 1, size_m: 1, position_m: [0, 0, 0]}\n"
     "    - {id: 1, size_m: 1, position_m: [2, 0, 0]}\n",
     "x.yaml:4: tag_map.tags[1]: expected each id once, got 1 again"},
    {"MixedFamilies",
     "tag_map:\n  tags:\n    - {id: 1, size_m: 1, position_m: [0, 0, 0], family: tag25h9}\n",
     "x.yaml:3: tag_map.tags[0].family: expected tag36h11 like all tags of the map, got tag25h9"},
    {"OverlappingTags",
     "tag_map:\n  tags:\n    - {id: 1, size_m: 1, position_m: [0, 0, 0]}\n"
     "    - {id: 2, size_m: 1, position_m: [0.9, 0, 0]}\n",
     "x.yaml:1: tag_map: expected a possible map, got tags 1 and 2 overlap"},
    {"TagIdNotInFamily", "tag_map: {tags: [{id: 587, size_m: 1, position_m: [0, 0, 0]}]}\n",
     "tag_map.tags[0].id: expected 0..586, got 587"},
    {"TagWithoutSize", "tag_map: {tags: [{id: 1, position_m: [0, 0, 0]}]}\n",
     "tag_map.tags[0].size_m: expected a value, got none"},
    {"TagOfNoSize", "tag_map: {tags: [{id: 1, size_m: 0, position_m: [0, 0, 0]}]}\n",
     "tag_map.tags[0].size_m: expected > 0, got 0"},
    {"TagBentTooFar",
     "tag_map:\n  tags:\n    - {id: 1, size_m: 1, position_m: [0, 0, 0], bend_m: -0.25}\n",
     "x.yaml:3: tag_map.tags[0].bend_m: expected less than a quarter of the side of 1"},
    {"CornersOfNoSquare",
     "tag_map: {tags: [{id: 1, corners_m: [[0, 0, 0], [1, 0, 0], [1.2, 1, 0], [0, 1, 0]]}]}\n",
     "tag_map.tags[0].corners_m: expected the corners of a square, got p"},
    {"CornersOnALine",
     "tag_map: {tags: [{id: 1, corners_m: [[0, 0, 0], [1, 0, 0], [1, 0, 0], [0, 0, 0]]}]}\n",
     "expected the corners of a square, got points on a line"},
    {"GapsDoNotFit",
     "tag_map:\n  grid: {rows: 3, columns: 1, tag_size_m: 1, row_gaps_m: [1], column_gaps_m: 0}\n",
     "x.yaml:2: tag_map.grid.row_gaps_m: expected 2 gaps, got 1"},
    {"GridTooLarge",
     "tag_map:\n  grid: {rows: 99999, columns: 99999, tag_size_m: 1, row_gaps_m: 1, "
     "column_gaps_m: 0}\n",
     "x.yaml:2: tag_map.grid.rows: expected first_id, rows and columns with ids 0..586"},
    {"NoGridSize", "tag_map: {grid: {rows: 3, columns: 1, row_gaps_m: 1, column_gaps_m: 0}}\n",
     "tag_map.grid.tag_size_m: expected a value, got none"},
    {"BrokenYaml", "camera:\n  fx: [1, 2\n", "not valid YAML"},
    {"TwoDocuments", "camera: {}\n---\ncamera: {}\n", "x.yaml: expected one YAML document, got 2"},
    {"Scalar", "just a text\n", "x.yaml:1: expected a mapping, got just a text"},
    {"CommentsOnly", "# nothing\n", "x.yaml: expected one YAML document, got 0"},
    {"Empty", "", "x.yaml: expected YAML, got an empty file"},
};

class BadConfig : public ::testing::TestWithParam<BadFile> {};

TEST_P(BadConfig, IsRefusedWithItsPlace) {
  EXPECT_THAT(FaultOfText(GetParam().text), HasSubstr(GetParam().fault));
}
INSTANTIATE_TEST_SUITE_P(All, BadConfig, ::testing::ValuesIn(kBadFiles),
                         [](const auto& test) { return std::string(test.param.name); });

TEST(ConfigRefusals, AbsentFileAndFolder) {
  const Result<Config> absent = LoadConfig("no/such/file.yaml");
  ASSERT_FALSE(absent);
  EXPECT_EQ(absent.error().message, "no/such/file.yaml: cannot open: No such file or directory");
  const TempFolder folder;
  const Result<Config> opened = LoadConfig(folder.path());
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().message, folder.path() + ": expected a file, got a folder");
}

TEST(ConfigRefusals, AnyTruncationIsReadOrRefusedInOneLine) {
  const std::string whole = ReadText(TAGTWIST_SOURCE_DIR "/configs/course.yaml");
  ASSERT_GT(whole.size(), 1000u);
  for (size_t size = 1; size < whole.size(); size += 31) {
    EXPECT_FALSE(FaultOfText(whole.substr(0, size)).empty());
  }
}

TEST(ConfigRefusals, Garbage) {
  unsigned state = 1;
  for (int i = 0; i < 100; ++i) {
    std::string bytes;
    for (int k = 0; k < 300; ++k) {
      state = state * 1664525u + 1013904223u;
      bytes += static_cast<char>(state >> 24);
    }
    EXPECT_NE(FaultOfText(bytes), "accepted") << i;
  }
}

TEST(ConfigRefusals, EndlessAliases) {
  std::string text = "a0: &a0 [1, 1]\n";
  for (int i = 1; i < 40; ++i) {
    const std::string last = "*a" + std::to_string(i - 1), name = "a" + std::to_string(i);
    text.append(name).append(": &").append(name).append(" [").append(last).append(", ");
    text.append(last).append("]\n");
  }
  EXPECT_THAT(FaultOfText(text), HasSubstr("expected a smaller file"));
}

TEST(ConfigRefusals, DeepNesting) {
  EXPECT_NE(FaultOfText("camera: " + std::string(100000, '[')), "accepted");
}

}  // namespace
}  // namespace tagtwist::internal::config_refusals_test

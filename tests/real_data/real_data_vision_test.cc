#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iomanip>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <sstream>

#include "frontend/closed_form.h"
#include "frontend/flow/klt_tracker.h"
#include "frontend/front_end.h"
#include "frontend/geometry/frame_pose.h"
#include "tests/support/flights/tag_scene.h"

namespace tagtwist::internal::real_data_vision_test {
namespace {

const std::filesystem::path kData = TAGTWIST_REAL_DATA_DIR;

// Numbers of a file, row by row; whatever is not part of a number separates.
std::vector<std::vector<double>> ReadNumbers(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::vector<std::vector<double>> rows;
  for (std::string line; std::getline(file, line);) {
    if (line.find_first_of("0123456789") == std::string::npos || line.find("id") < 9) continue;
    std::replace_if(
        line.begin(), line.end(),
        [](char c) { return std::string("0123456789.-+e").find(c) == std::string::npos; }, ' ');
    std::istringstream numbers(line);
    rows.emplace_back();
    for (double number = 0; numbers >> number;) rows.back().push_back(number);
  }
  return rows;
}

double Quantile(std::vector<double> values, double q) {
  std::sort(values.begin(), values.end());
  return values[static_cast<size_t>(q * static_cast<double>(values.size() - 1))];
}

// Trial 4's real frames: tags by stamp, Vicon by stamp.
struct CourseFrames {
  std::map<double, std::vector<TagDetection>> tags;
  std::map<double, Pose> world_from_body;
};

CourseFrames ReadCourseFrames() {
  CourseFrames out;
  for (const auto& row : ReadNumbers(kData / "course-dataset4-frames/detections.csv")) {
    TagDetection tag;
    tag.id = static_cast<int>(row[1]);
    for (size_t c = 0; c < 4; ++c) tag.corners[c] = {row[2 + 2 * c], row[3 + 2 * c]};
    out.tags[row[0]].push_back(tag);
  }
  for (const auto& row : ReadNumbers(kData / "course-dataset4-frames/ground_truth.csv")) {
    out.world_from_body[row[0]] =
        MakePose(Eigen::Quaterniond(row[7], row[4], row[5], row[6]), {row[1], row[2], row[3]});
  }
  return out;
}

Camera Course2017Camera() {
  Camera camera;
  camera.fx = 314.1779;
  camera.fy = 314.2218;
  camera.cx = 199.4848;
  camera.cy = 113.7838;
  return camera;
}

class RealDataVision : public testing::Test {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists(kData)) GTEST_SKIP() << "no real data at " << kData;
  }
};

TEST_F(RealDataVision, ClosedFormLiesNearViconOnEveryFrameOfTrial4) {
  const CourseFrames frames = ReadCourseFrames();
  ASSERT_EQ(frames.tags.size(), 61u);
  const TagMap map = MakeTagMap(TagGrid());
  const Camera camera = Course2017Camera();
  ClosedFormEstimator closed_form(camera, CourseCamFromBody(), map, {});
  std::vector<double> closed_form_m, frame_pose_m;
  for (const auto& [t, tags] : frames.tags) {
    const Pose& truth = frames.world_from_body.at(t);
    const auto result = closed_form.Update(static_cast<int64_t>(t * 1e9), tags, {});
    ASSERT_TRUE(result.world_from_body) << t;
    closed_form_m.push_back(PositionErrorM(*result.world_from_body, truth));
    const FramePose found = FindFramePose(tags, map, camera, CourseCamFromBody());
    ASSERT_EQ(found.status, FramePoseStatus::kOk) << t;
    EXPECT_EQ(std::count(found.tag_inlier.begin(), found.tag_inlier.end(), false), 0) << t;
    EXPECT_LT(found.rms_px, 2) << t;
    frame_pose_m.push_back(PositionErrorM(found.world_from_body, truth));
  }
  RecordProperty("closed_form_median_mm", std::to_string(1e3 * Quantile(closed_form_m, 0.5)));
  RecordProperty("closed_form_max_mm", std::to_string(1e3 * Quantile(closed_form_m, 1)));
  RecordProperty("frame_pose_median_mm", std::to_string(1e3 * Quantile(frame_pose_m, 0.5)));
  EXPECT_LT(Quantile(closed_form_m, 0.5), 0.025);
  EXPECT_LT(Quantile(closed_form_m, 1), 0.080);
  EXPECT_LT(Quantile(frame_pose_m, 0.5), 0.020);
  EXPECT_LT(Quantile(frame_pose_m, 1), 0.080);
}

TEST_F(RealDataVision, DetectorFindsTheTagsOfTrial4) {
  const CourseFrames frames = ReadCourseFrames();
  auto detector = TagDetector::Create("tag36h11", TagDetectorOptions());
  ASSERT_TRUE(detector);
  const TagMap map = MakeTagMap(TagGrid());
  size_t n_expected = 0, n_strange = 0, index = 0;
  std::vector<double> errors_px;
  for (const auto& [t, expected] : frames.tags) {
    std::ostringstream name;
    name << "course-dataset4-frames/images/" << std::setw(3) << std::setfill('0') << index++
         << ".png";
    const cv::Mat image = cv::imread((kData / name.str()).string(), cv::IMREAD_GRAYSCALE);
    ASSERT_FALSE(image.empty()) << name.str();
    const auto found = detector->Detect(image);
    n_expected += expected.size();
    for (const TagDetection& tag : found) {
      n_strange += map.Find(tag.id) == nullptr ? 1 : 0;
      const auto same = std::find_if(expected.begin(), expected.end(),
                                     [&](const auto& other) { return other.id == tag.id; });
      if (same == expected.end()) continue;
      for (size_t c = 0; c < 4; ++c) {
        errors_px.push_back((tag.corners[c] - same->corners[c]).norm());
      }
    }
  }
  RecordProperty("found_percent", std::to_string(25.0 * static_cast<double>(errors_px.size()) /
                                                 static_cast<double>(n_expected)));
  RecordProperty("corner_median_px", std::to_string(Quantile(errors_px, 0.5)));
  EXPECT_GE(errors_px.size(), 4 * n_expected * 9 / 10);
  EXPECT_LT(Quantile(errors_px, 0.5), 1);
  EXPECT_EQ(n_strange, 0u);
}

// The photos of the AprilTag library's own tests, all tags of id 0. The corners listed beside them
// are another version's of the library, in its pixel convention, where tags are small whole pixels.
TEST_F(RealDataVision, DetectorFindsTheTagsOfThePhotos) {
  auto detector = TagDetector::Create("tag36h11", TagDetectorOptions());
  ASSERT_TRUE(detector);
  for (const char* name :
       {"33369213973_9d9bb4cc96_c", "34085369442_304b6bafd9_c", "34139872896_defdb2f8d9_c"}) {
    const auto base = kData / "apriltag-test-images" / name;
    const cv::Mat image = cv::imread(base.string() + ".jpg", cv::IMREAD_GRAYSCALE);
    ASSERT_FALSE(image.empty()) << base;
    const auto tags = detector->Detect(image);
    const auto expected = ReadNumbers(base.string() + ".txt");
    ASSERT_FALSE(expected.empty());
    double n_near = 0;
    Eigen::Vector2d offset = Eigen::Vector2d::Zero();
    for (const auto& row : expected) {
      ASSERT_EQ(row.size(), 9u);
      for (const TagDetection& tag : tags) {
        double worst = 0;
        Eigen::Vector2d mean = Eigen::Vector2d::Zero();
        for (size_t c = 0; c < 4; ++c) {
          const Eigen::Vector2d corner(row[1 + 2 * c] - 0.5, row[2 + 2 * c] - 0.5);
          worst = std::max(worst, (corner - tag.corners[c]).norm());
          mean += (tag.corners[c] - corner) / 4;
        }
        if (worst > 1.2) continue;
        ++n_near;
        offset += mean;
        break;
      }
    }
    EXPECT_GE(n_near, 0.88 * static_cast<double>(expected.size())) << name;
    EXPECT_LT((offset / n_near).norm(), 0.25) << name << ": a systematic offset";
    RecordProperty(std::string("offset_px_") + name, std::to_string((offset / n_near).norm()));
  }
}

// The hand-held floor mat: large motion between frames at 15 Hz.
TEST_F(RealDataVision, TracksLastOverTheFloorMat) {
  auto detector = TagDetector::Create("tag36h11", TagDetectorOptions());
  ASSERT_TRUE(detector);
  KltTracker tracker{KltOptions()};
  std::map<int64_t, Eigen::Vector2d> last;
  std::vector<double> followed;
  for (int i = 1; i <= 60; ++i) {
    std::ostringstream name;
    name << "umd-floor-mat/images/" << std::setw(4) << std::setfill('0') << i << ".jpg";
    const cv::Mat image = cv::imread((kData / name.str()).string(), cv::IMREAD_GRAYSCALE);
    ASSERT_FALSE(image.empty()) << name.str();
    std::map<int64_t, Eigen::Vector2d> now;
    for (const auto& track : tracker.Track(image, detector->Detect(image))) {
      now[track.track_id] = track.pixel;
    }
    double n = 0;
    for (const auto& [id, pixel] : last) n += static_cast<double>(now.count(id));
    if (i > 1) followed.push_back(n / static_cast<double>(last.size()));
    last = now;
  }
  RecordProperty("followed_median", std::to_string(Quantile(followed, 0.5)));
  EXPECT_GT(Quantile(followed, 0.5), 0.6);
}

}  // namespace
}  // namespace tagtwist::internal::real_data_vision_test

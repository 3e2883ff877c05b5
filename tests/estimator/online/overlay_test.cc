#include "estimator/jobs/overlay/overlay.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <opencv2/core.hpp>
#include <opencv2/videoio.hpp>

#include "frontend/io/images/video_file.h"
#include "tests/support/temp_folder.h"

namespace tagtwist::internal::overlay_test {
namespace {

namespace fs = std::filesystem;

TagMap OneTag() {
  return TagMap("tag36h11", {{7, MakePose(Eigen::Quaterniond::Identity(), {0, 0, 0}), 0.2}});
}

// One metre above the tag, looking down: camera y down is world -y.
Pose CamFromWorld() {
  return MakePose(Eigen::Quaterniond(Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitX())), {0, 0, 1});
}

TagDetection Seen(const Camera& camera) {
  TagDetection out;
  out.id = 7;
  const TagMap map = OneTag();
  for (size_t c = 0; c < 4; ++c) {
    out.corners[c].setZero();
    EXPECT_TRUE(camera.Project(CamFromWorld() * map.CornersInWorld(7)[c], &out.corners[c]));
  }
  return out;
}

// Whether a pixel of about that colour lies within two pixels of an image point.
bool IsNear(const cv::Mat& canvas, int scale, const Eigen::Vector2d& pixel, const cv::Vec3b& bgr) {
  const Eigen::Vector2d at = scale * (pixel.array() + 0.5) - 0.5;
  for (int dv = -2; dv <= 2; ++dv) {
    for (int du = -2; du <= 2; ++du) {
      const cv::Point p(cvRound(at.x()) + du, cvRound(at.y()) + dv);
      if (cv::norm(canvas.at<cv::Vec3b>(p), bgr) < 110)
        return true;  // thin lines are blended with what is below
    }
  }
  return false;
}

const cv::Vec3b kGreen(80, 220, 80), kOrange(0, 150, 255), kBlue(255, 170, 60);

TEST(Overlay, DrawsTagsWhereTheyWereSeenAndTheMapWhereThePosePutsIt) {
  const Camera camera;
  OverlayDrawing drawing(camera, OneTag());
  EXPECT_EQ(drawing.scale(), 2);
  OverlayFrame frame;
  frame.image = cv::Mat(camera.height, camera.width, CV_8UC1, cv::Scalar(128));
  const TagDetection seen = Seen(camera);
  frame.tags = {seen};
  const cv::Mat with_tag = drawing.Draw(frame);
  EXPECT_EQ(with_tag.cols % 2 + with_tag.rows % 2, 0);
  frame.tags = {};
  frame.cam_from_world = CamFromWorld();
  const cv::Mat with_map = drawing.Draw(frame);
  frame.cam_from_world.reset();
  const cv::Mat bare = drawing.Draw(frame);
  for (size_t c = 0; c < 4; ++c) {
    const Eigen::Vector2d side = 0.5 * (seen.corners[c] + seen.corners[(c + 1) % 4]);
    for (const Eigen::Vector2d& at : {seen.corners[c], side}) {
      EXPECT_TRUE(IsNear(with_tag, 2, at, kGreen)) << c;
      EXPECT_TRUE(IsNear(with_map, 2, at, kOrange)) << c;
      EXPECT_FALSE(IsNear(bare, 2, at, kGreen) || IsNear(bare, 2, at, kOrange)) << c;
    }
  }
}

TEST(Overlay, TracksRunFromWhereTheyWere) {
  const Camera camera;
  OverlayDrawing drawing(camera, OneTag());
  OverlayFrame frame;  // no image: on black
  frame.tracks = {{5, {100, 100}}};
  drawing.Draw(frame);
  frame.tracks = {{5, {140, 100}}, {6, {20, 20}}};
  const cv::Mat second = drawing.Draw(frame);
  EXPECT_TRUE(IsNear(second, 2, {120, 100}, kBlue));
  EXPECT_TRUE(IsNear(second, 2, {20, 20}, kBlue));
  frame.tracks = {};
  EXPECT_FALSE(IsNear(drawing.Draw(frame), 2, {120, 100}, kBlue));
}

TEST(Overlay, AVideoAppearsWhenItIsWhole) {
  const TempFolder folder;
  for (const char* name : {"flight.mp4", "flight.avi"}) {
    const std::string path = folder / name;
    {
      auto video = VideoFile::Create(path, 20, {320, 240});
      ASSERT_TRUE(video) << video.error().message;
      for (int i = 0; i < 7; ++i) {
        (*video)->Add(cv::Mat(240, 320, CV_8UC3, cv::Scalar(30 * i, 0, 0)));
        EXPECT_FALSE(fs::exists(path));
      }
      const auto done = (*video)->Finish();
      ASSERT_TRUE(done) << done.error().message;
    }
    cv::VideoCapture read(path);
    cv::Mat image;
    int frames = 0;
    while (read.read(image)) ++frames;
    EXPECT_EQ(frames, 7) << name;
    { auto left = VideoFile::Create((folder / "never.mp4"), 20, {320, 240}); }
    EXPECT_FALSE(fs::exists(folder / "never.mp4"));
  }
  EXPECT_EQ(folder.CountEntries(), 2u) << "partial files are gone";
}

TEST(Overlay, RefusesOtherNamesAndPlaces) {
  const TempFolder folder;
  EXPECT_EQ(CheckVideoName("out/film.mov").error().message,
            "out/film.mov: expected a name that ends in .mp4 or .avi");
  const auto nowhere = VideoFile::Create((folder / "missing/film.mp4"), 20, {320, 240});
  ASSERT_FALSE(nowhere);
  EXPECT_NE(nowhere.error().message.find("film.mp4: its folder is missing"), std::string::npos);
}

}  // namespace
}  // namespace tagtwist::internal::overlay_test

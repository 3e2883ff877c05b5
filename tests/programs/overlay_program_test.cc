// tagtwist_estimate --overlay, as it is run.
#include <gtest/gtest.h>

#include <filesystem>
#include <opencv2/videoio.hpp>

#include "tests/support/program_test_util.h"
#include "tests/support/temp_folder.h"

namespace tagtwist::internal::overlay_program_test {
namespace {

using Arguments = std::vector<std::string>;

class OverlayProgram : public testing::Test {
 protected:
  ProgramRun Estimate(const Arguments& more) const {
    Arguments arguments = {"--dataset", "rec", "--output", "out"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return RunProgram(folder_.path(), "tagtwist_estimate", arguments);
  }
  void MakeImages(bool images) const {
    MakeRecording(folder_.path(), "rec", DatasetFormat::kFolder, images);
  }
  // Nothing but the recording.
  void ExpectNothingWritten() const { EXPECT_EQ(folder_.CountEntries(), 1u); }

  TempFolder folder_;
};

// Pixels of the colour that tags are drawn in.
int GreenPixels(const cv::Mat& image) {
  int count = 0;
  for (int v = 0; v < image.rows; ++v) {
    for (int u = 0; u < image.cols; ++u) {
      const auto& bgr = image.at<cv::Vec3b>(v, u);
      if (bgr[1] > 170 && bgr[0] < 140 && bgr[2] < 140) ++count;
    }
  }
  return count;
}

TEST_F(OverlayProgram, ShowsEveryFrameInBatchAndWindow) {
  MakeImages(true);
  for (const Arguments& mode : {Arguments{}, Arguments{"--sliding_window"},
                                Arguments{"--use_detections", "--tracks=false"}}) {
    Arguments arguments = {"--overlay", "film.mp4"};
    arguments.insert(arguments.end(), mode.begin(), mode.end());
    const ProgramRun run = Estimate(arguments);
    ASSERT_EQ(run.status, 0) << run.err;
    EXPECT_NE(run.out.find("overlay: film.mp4"), std::string::npos);
    cv::VideoCapture video(folder_ / "film.mp4");
    cv::Mat image;
    int frames = 0;
    EXPECT_EQ(video.get(cv::CAP_PROP_FRAME_WIDTH), 752);
    for (; video.read(image); ++frames) EXPECT_GT(GreenPixels(image), 200) << frames;
    EXPECT_EQ(frames, 6);
    std::filesystem::remove(folder_ / "film.mp4");
  }
}

TEST_F(OverlayProgram, EndsWhereTheEstimateEnds) {
  MakeImages(true);
  const ProgramRun run = Estimate({"--overlay", "film.avi", "--max_frames", "3"});
  ASSERT_EQ(run.status, 0) << run.err;
  cv::VideoCapture video(folder_ / "film.avi");
  EXPECT_EQ(video.get(cv::CAP_PROP_FRAME_COUNT), 3);
}

TEST_F(OverlayProgram, RefusesARecordingWithoutImages) {
  MakeImages(false);
  const ProgramRun run = Estimate({"--use_detections", "--overlay", "film.mp4"});
  EXPECT_EQ(run.status, 1);
  EXPECT_EQ(run.err, "tagtwist_estimate: rec: has no images to draw film.mp4 on\n");
  ExpectNothingWritten();
}

TEST_F(OverlayProgram, RefusesNamesThatAreNoVideosAndMissingFolders) {
  MakeImages(true);
  const ProgramRun run = Estimate({"--overlay", "film.mov"});
  EXPECT_EQ(run.status, 1);
  EXPECT_EQ(run.err, "tagtwist_estimate: film.mov: expected a name that ends in .mp4 or .avi\n");
  const ProgramRun missing = Estimate({"--overlay", "nowhere/film.mp4"});
  EXPECT_EQ(missing.status, 1);
  EXPECT_EQ(missing.err, "tagtwist_estimate: nowhere/film.mp4: its folder is missing\n");
  ExpectNothingWritten();
}

TEST_F(OverlayProgram, ExcludesLiveRuns) {
  MakeImages(true);
  const ProgramRun run = Estimate({"--sliding_window", "--realtime", "--overlay", "film.mp4"});
  EXPECT_EQ(run.status, 2);
  EXPECT_EQ(run.err, "tagtwist_estimate: --realtime: excludes --overlay\n");
}

}  // namespace
}  // namespace tagtwist::internal::overlay_program_test

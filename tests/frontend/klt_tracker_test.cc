#include "frontend/flow/klt_tracker.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <opencv2/core/utility.hpp>
#include <opencv2/imgproc.hpp>
#include <random>

#include "tests/support/texture.h"

namespace tagtwist::internal::klt_tracker_test {
namespace {

// Waves over the plane, shifted without interpolation: OpenCV's warps are good to 0.05 px only.
cv::Mat Waves(const Eigen::Vector2d& shift) {
  std::mt19937_64 engine(3);
  std::uniform_real_distribution<double> frequency(-1, 1), phase(0, 2 * M_PI);
  cv::Mat sum(240, 376, CV_64FC1, cv::Scalar(128));
  for (int i = 0; i < 25; ++i) {
    const double fx = frequency(engine), fy = frequency(engine), start = phase(engine);
    for (int y = 0; y < sum.rows; ++y) {
      for (int x = 0; x < sum.cols; ++x) {
        sum.at<double>(y, x) += 14 * std::cos(fx * (x + shift.x()) + fy * (y + shift.y()) + start);
      }
    }
  }
  cv::Mat image;
  sum.convertTo(image, CV_8U);
  return image;
}

double Median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<long>(values.size() / 2),
                   values.end());
  return values[values.size() / 2];
}

TEST(KltTracker, FollowsAShiftToATenthOfAPixel) {
  KltTracker tracker{KltOptions()};
  const auto first = ById(tracker.Track(Waves({0, 0}), {}));
  EXPECT_GT(first.size(), 220u);
  EXPECT_LE(first.size(), 250u);
  const Eigen::Vector2d shift(3.3, -5.7);
  const auto second = ById(tracker.Track(Waves(shift), {}));
  std::vector<double> errors;
  for (const auto& [id, pixel] : first) {
    const auto it = second.find(id);
    if (it != second.end()) errors.push_back((pixel - shift - it->second).norm());
  }
  ASSERT_GT(errors.size(), 200u);
  EXPECT_LT(Median(errors), 0.04);
  EXPECT_GT(std::count_if(errors.begin(), errors.end(), [](double e) { return e < 0.1; }),
            static_cast<long>(95 * errors.size() / 100));
}

TEST(KltTracker, FollowsATurnAndZoom) {
  const cv::Mat world = Texture(600, 500);
  KltTracker tracker{KltOptions()};
  const auto first = ById(tracker.Track(Shifted(world, 100, 100), {}));
  const double angle = 0.03, zoom = 0.98;
  Eigen::Matrix2d a;
  a << zoom * std::cos(angle), -zoom * std::sin(angle), zoom * std::sin(angle),
      zoom * std::cos(angle);
  const Eigen::Vector2d b(105, 97);
  const auto second = ById(tracker.Track(See(world, a, b), {}));
  std::vector<double> errors;
  for (const auto& [id, pixel] : first) {
    const auto it = second.find(id);
    if (it == second.end()) continue;
    const Eigen::Vector2d expected = a.inverse() * (pixel + Eigen::Vector2d(100, 100) - b);
    errors.push_back((expected - it->second).norm());
  }
  ASSERT_GT(errors.size(), 180u);
  EXPECT_LT(Median(errors), 0.1);
}

TEST(KltTracker, IdsPersistGrowAndAreNeverUsedAgain) {
  const cv::Mat world = Texture(700, 400);
  KltTracker tracker{KltOptions()};
  int64_t newest = -1;
  std::map<int64_t, int> times_seen;
  std::vector<int64_t> ended;
  std::map<int64_t, Eigen::Vector2d> last;
  for (int i = 0; i < 30; ++i) {
    const auto tracks = tracker.Track(Shifted(world, 20 + 8 * i, 60), {});
    EXPECT_TRUE(std::is_sorted(tracks.begin(), tracks.end(), [](const auto& x, const auto& y) {
      return x.track_id < y.track_id;
    }));
    const auto now = ById(tracks);
    ASSERT_EQ(now.size(), tracks.size());
    for (const auto& [id, pixel] : last) {
      if (now.count(id) == 0) ended.push_back(id);
    }
    for (const auto& [id, pixel] : now) {
      if (last.count(id) == 0) {
        EXPECT_GT(id, newest);
      }
      ++times_seen[id];
    }
    for (const int64_t id : ended) EXPECT_EQ(now.count(id), 0u);
    newest = std::max(newest, now.rbegin()->first);
    last = now;
  }
  EXPECT_FALSE(ended.empty());
  EXPECT_GT(std::max_element(times_seen.begin(), times_seen.end(),
                             [](const auto& x, const auto& y) { return x.second < y.second; })
                ->second,
            20)
      << "a track lives as long as its point is seen";
}

TEST(KltTracker, DropsWhatAnOccluderCovers) {
  const cv::Mat world = Texture(500, 400);
  KltTracker tracker{KltOptions()};
  const auto first = ById(tracker.Track(Shifted(world, 50, 60), {}));
  cv::Mat covered = Shifted(world, 52, 61);
  const cv::Rect occluder(120, 60, 110, 110);
  Texture(500, 400, 99)(occluder).copyTo(covered(occluder));
  const auto second = ById(tracker.Track(covered, {}));
  int n_behind = 0, n_kept = 0, n_elsewhere = 0, n_elsewhere_kept = 0;
  for (const auto& [id, pixel] : first) {
    const Eigen::Vector2d expected = pixel - Eigen::Vector2d(2, 1);
    const bool behind = expected.x() > 130 && expected.x() < 220 && expected.y() > 70 &&
                        expected.y() < 160;  // with its whole window
    const bool clear = expected.x() < 105 || expected.x() > 245 || expected.y() > 185;
    const bool kept = second.count(id) > 0;
    n_behind += behind ? 1 : 0;
    n_kept += behind && kept ? 1 : 0;
    n_elsewhere += clear ? 1 : 0;
    n_elsewhere_kept += clear && kept ? 1 : 0;
  }
  ASSERT_GT(n_behind, 15);
  EXPECT_LE(n_kept, n_behind / 10);
  EXPECT_GT(n_elsewhere_kept, 9 * n_elsewhere / 10);
}

TEST(KltTracker, SpreadsItsPointsAndKeepsThemApart) {
  // Strong texture in the left third, faint texture elsewhere.
  cv::Mat image = Texture(376, 240);
  cv::Mat faint = image(cv::Rect(125, 0, 251, 240));
  faint.convertTo(faint, -1, 0.25, 96);
  KltTracker tracker{KltOptions()};
  const auto tracks = tracker.Track(image, {});
  ASSERT_GT(tracks.size(), 200u);
  long n_faint = 0;
  for (const auto& track : tracks) {
    n_faint += track.pixel.x() > 125 ? 1 : 0;
    for (const auto& other : tracks) {
      if (other.track_id != track.track_id) {
        EXPECT_GE((other.pixel - track.pixel).norm(), KltOptions().min_distance_px);
      }
    }
  }
  EXPECT_GT(n_faint, static_cast<long>(tracks.size() / 2)) << "two thirds of the image";
}

TEST(KltTracker, AnImageThatIsEmptyOrOfAnotherSizeEndsAllTracks) {
  const cv::Mat world = Texture(500, 400);
  KltTracker tracker{KltOptions()};
  const auto first = tracker.Track(Shifted(world, 50, 60), {});
  EXPECT_TRUE(tracker.Track(cv::Mat(), {}).empty());
  const auto second = tracker.Track(Shifted(world, 50, 60), {});
  EXPECT_GT(second.front().track_id, first.back().track_id);
  const auto third = tracker.Track(world, {});
  EXPECT_GT(third.front().track_id, second.back().track_id);
  EXPECT_TRUE(tracker.Track(cv::Mat(240, 376, CV_8UC3, cv::Scalar::all(9)), {}).empty());
  EXPECT_TRUE(tracker.Track(cv::Mat(240, 376, CV_8UC1, cv::Scalar(128)), {}).empty());
}

TEST(KltTracker, TheNumberOfThreadsChangesNothing) {
  const cv::Mat world = Texture(500, 400);
  const int threads_before = cv::getNumThreads();
  std::vector<std::vector<TrackObservation>> last;
  for (const int threads : {1, 2, 4}) {
    cv::setNumThreads(threads);
    KltTracker tracker{KltOptions()};
    tracker.Track(Shifted(world, 50, 60), {});
    tracker.Track(Shifted(world, 56.5, 63), {});
    last.push_back(tracker.Track(Shifted(world, 62, 69.25), {}));
  }
  cv::setNumThreads(threads_before);
  for (const auto& tracks : last) {
    ASSERT_EQ(tracks.size(), last[0].size());
    for (size_t i = 0; i < tracks.size(); ++i) {
      EXPECT_EQ(tracks[i].track_id, last[0][i].track_id);
      EXPECT_EQ(tracks[i].pixel, last[0][i].pixel);
    }
  }
}

// While tags are enough nothing is followed; then tracks come with their places in the image
// before.
TEST(KltTracker, TracksBeginInTheImageBeforeTheOneWithoutEnoughTags) {
  const cv::Mat world = Texture(700, 600);
  KltOptions options;
  options.enough_tags = 1;
  KltTracker tracker(options);
  TagDetection tag;
  tag.corners = {Eigen::Vector2d(50, 80), {80, 80}, {80, 50}, {50, 50}};
  EXPECT_TRUE(tracker.Track(Shifted(world, 100, 100), {tag}).empty());
  EXPECT_TRUE(tracker.Track(Shifted(world, 103, 99), {tag}).empty());
  const auto first = tracker.Track(Shifted(world, 106, 98), {});
  int told = 0;
  for (const TrackObservation& track : first) {
    if (!track.pixel_before) continue;
    const double off_px = (*track.pixel_before - Eigen::Vector2d(3, -1) - track.pixel).norm();
    told += off_px < 0.2 ? 1 : 0;
  }
  EXPECT_GT(told, 150);
  const auto second = tracker.Track(Shifted(world, 109, 97), {});
  EXPECT_GT(second.size(), 150U);
  for (const TrackObservation& track : second) EXPECT_FALSE(track.pixel_before);
  EXPECT_TRUE(tracker.Track(Shifted(world, 112, 96), {tag}).empty());
  // An image that is bad, or of another size, leaves nothing to begin in.
  tracker.Track(cv::Mat(), {});
  for (const auto& track : tracker.Track(Shifted(world, 115, 95), {})) {
    EXPECT_FALSE(track.pixel_before);
  }
}

}  // namespace
}  // namespace tagtwist::internal::klt_tracker_test

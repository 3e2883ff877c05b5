#include <gtest/gtest.h>

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <random>

#include "frontend/flow/klt_tracker.h"
#include "tests/support/texture.h"

namespace tagtwist::internal::klt_motion_test {
namespace {

TEST(KltMotion, TagsSaySoAndPredictALargeMotion) {
  const cv::Mat world = Texture(900, 700);
  const auto tag_at = [](int id, double x, double y) {
    TagDetection tag;
    tag.id = id;
    tag.corners = {Eigen::Vector2d(x, y + 30), {x + 30, y + 30}, {x + 30, y}, {x, y}};
    return tag;
  };
  const Eigen::Vector2d shift(200, -120);  // the image as a whole does not tell
  std::vector<TagDetection> before = {tag_at(1, 215, 20), tag_at(2, 300, 60)}, after = before;
  for (auto& tag : after) {
    for (auto& corner : tag.corners) corner -= shift;
  }
  const auto n_followed = [&](bool with_tags) {
    KltTracker tracker{KltOptions()};
    const auto first =
        tracker.Track(Shifted(world, 200, 200), with_tags ? before : decltype(before)());
    if (with_tags) {
      for (const auto& track : first) {
        const bool on_first = track.pixel.x() > 209.4 && track.pixel.x() < 250.6 &&
                              track.pixel.y() > 14.4 && track.pixel.y() < 55.6;
        const bool on_second = track.pixel.x() > 294.4 && track.pixel.x() < 335.6 &&
                               track.pixel.y() > 54.4 && track.pixel.y() < 95.6;
        EXPECT_EQ(track.on_tag, on_first || on_second) << track.pixel.transpose();
      }
    }
    const auto then = ById(first);
    const auto second = ById(tracker.Track(Shifted(world, 200 + shift.x(), 200 + shift.y()),
                                           with_tags ? after : decltype(after)()));
    return std::count_if(then.begin(), then.end(), [&](const auto& track) {
      const auto it = second.find(track.first);
      return it != second.end() && (track.second - shift - it->second).norm() < 0.3;
    });
  };
  EXPECT_GT(n_followed(true), 30);  // what stays in the image
  EXPECT_LT(n_followed(false), n_followed(true) / 4);
}

// A tag of a body that moves is no point of the map's, and tells nothing of the camera's motion.
TEST(KltMotion, PointsOnMovingTagsAreMarked) {
  TagDetection tag;
  tag.corners = {Eigen::Vector2d(100, 160), {200, 160}, {200, 60}, {100, 60}};
  KltTracker tracker{KltOptions()};
  int n_on_tag = 0;
  for (const TrackObservation& track : tracker.Track(Texture(376, 240), {}, 0, {tag})) {
    const double reach = 100 * KltOptions().tag_margin;
    const bool on_tag = track.pixel.x() > 100 - reach && track.pixel.x() < 200 + reach &&
                        track.pixel.y() > 60 - reach && track.pixel.y() < 160 + reach;
    EXPECT_EQ(track.on_tag, on_tag) << track.pixel.transpose();
    n_on_tag += track.on_tag ? 1 : 0;
  }
  EXPECT_GT(n_on_tag, 20);
}

// Beyond the reach of the search around each point: it begins where the image as a whole went.
TEST(KltMotion, ALargeShiftIsFollowedWithoutTags) {
  const cv::Mat world = Texture(900, 700);
  for (const Eigen::Vector2d& shift : {Eigen::Vector2d(70, -40), {-90, 20}, {10, 70}}) {
    KltTracker tracker{KltOptions()};
    const auto then = ById(tracker.Track(Shifted(world, 200, 200), {}));
    const auto now = ById(tracker.Track(Shifted(world, 200 + shift.x(), 200 + shift.y()), {}));
    int n_followed = 0;
    for (const auto& [id, pixel] : then) {
      const auto it = now.find(id);
      if (it == now.end()) continue;
      ++n_followed;
      EXPECT_LT((pixel - shift - it->second).norm(), 0.5) << shift.transpose();
    }
    EXPECT_GT(n_followed, 120) << shift.transpose();
  }
}

// A bare floor, shaded, before a camera that moves: the noise is no point of it.
TEST(KltMotion, NoiseIsNotFollowed) {
  std::mt19937_64 engine(4);
  std::normal_distribution<double> noise(0, 2);
  KltTracker tracker{KltOptions()};
  std::vector<TrackObservation> tracks;
  size_t n_seen = 0;
  for (int frame = 0; frame < 6; ++frame) {
    cv::Mat image(240, 376, CV_8UC1);
    for (int y = 0; y < image.rows; ++y) {
      for (int x = 0; x < image.cols; ++x) {
        const double shade = 150 + 0.1 * x - 1e-3 * (y - 120) * (y - 120);
        image.at<uchar>(y, x) = cv::saturate_cast<uchar>(shade + noise(engine));
      }
    }
    n_seen += tracker.Track(image, {}).size();
  }
  EXPECT_LT(n_seen, 20U);
}

// On a sheet of tags, whose corners are alike, the few points that seem to be found after too large
// a motion are wrong together: no track goes on.
TEST(KltMotion, AllTracksEndWhereMostAreNotFoundAgain) {
  cv::Mat sheet(900, 1200, CV_8UC1, cv::Scalar(235));
  std::mt19937_64 engine(5);
  for (int y = 10; y + 40 < sheet.rows; y += 80) {
    for (int x = 10; x + 40 < sheet.cols; x += 80) {
      cv::rectangle(sheet, {x, y, 40, 40}, cv::Scalar(20), cv::FILLED);
      for (int cell = 0; cell < 36; ++cell) {
        if ((engine() & 1U) == 0) continue;
        cv::rectangle(sheet, {x + 5 + cell % 6 * 5, y + 5 + cell / 6 * 5, 5, 5}, cv::Scalar(235),
                      cv::FILLED);
      }
    }
  }
  cv::GaussianBlur(sheet, sheet, {0, 0}, 0.7);
  KltTracker tracker{KltOptions()};
  const auto first = ById(tracker.Track(Shifted(sheet, 100, 100), {}));
  const auto near = ById(tracker.Track(Shifted(sheet, 106, 103), {}));
  const auto kept = std::count_if(first.begin(), first.end(),
                                  [&](const auto& track) { return near.count(track.first) > 0; });
  EXPECT_GT(kept, 150);
  const int64_t last_id = near.rbegin()->first;
  const auto far = tracker.Track(Shifted(sheet, 106 + 330, 103 + 190), {});
  ASSERT_FALSE(far.empty());
  for (const TrackObservation& track : far) EXPECT_GT(track.track_id, last_id);
}

}  // namespace
}  // namespace tagtwist::internal::klt_motion_test

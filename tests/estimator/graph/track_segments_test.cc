#include "estimator/graph/track_segments.h"

#include <gtest/gtest.h>

#include <map>
#include <set>

namespace tagtwist::internal::track_segments_test {
namespace {

std::vector<TrackObservation> Views(int frame, int n_tracks) {
  std::vector<TrackObservation> out;
  for (int i = 0; i < n_tracks; ++i) {
    out.push_back({i, Eigen::Vector2d(10.0 * i, frame), false});
  }
  return out;
}

TEST(TrackSegments, EveryViewIsInOneSegmentAndSegmentsAreShort) {
  TrackSegmenter segmenter({40, 6});
  for (int frame = 0; frame < 25; ++frame) segmenter.Add(Views(frame, 10), 0);
  std::set<std::pair<int64_t, int>> seen;
  for (const TrackSegment& segment : segmenter.segments()) {
    EXPECT_LE(segment.pixels.size(), 6u);
    for (size_t k = 0; k < segment.pixels.size(); ++k) {
      const int frame = segment.first_frame + static_cast<int>(k);
      EXPECT_EQ(segment.pixels[k].y(), frame);
      EXPECT_EQ(segment.pixels[k].x(), 10.0 * static_cast<double>(segment.track_id));
      EXPECT_TRUE(seen.emplace(segment.track_id, frame).second) << "a view counted twice";
    }
  }
  EXPECT_EQ(seen.size(), 250u);
}

// A piece's end is chosen by a scattered 31-bit number of its track plus its first frame, which
// after many frames and tracks passes 2^31.
TEST(TrackSegments, SegmentsAreShortAfterAnyNumberOfFramesAndTracks) {
  constexpr int kFrames = 2'000'000, kTracks = 20'000;
  TrackSegmenter segmenter({kTracks, 6});
  for (int frame = 0; frame < kFrames; ++frame) segmenter.Add({}, 0);
  for (int frame = kFrames; frame < kFrames + 8; ++frame) segmenter.Add(Views(frame, kTracks), 0);
  ASSERT_GE(segmenter.segments().size(), static_cast<size_t>(kTracks));
  for (const TrackSegment& s : segmenter.segments()) ASSERT_LE(s.pixels.size(), 6u) << s.track_id;
}

TEST(TrackSegments, SomeSegmentSpansEveryBoundary) {
  TrackSegmenter segmenter({40, 6});
  for (int frame = 0; frame < 25; ++frame) segmenter.Add(Views(frame, 30), 0);
  std::map<int, int> spanned;
  for (const TrackSegment& s : segmenter.segments()) {
    for (int frame = s.first_frame; frame < s.last_frame(); ++frame) ++spanned[frame];
  }
  for (int frame = 0; frame < 24; ++frame) EXPECT_GT(spanned[frame], 5) << frame;
}

TEST(TrackSegments, TagsMakeUpForTracksAndAGapIsTiedToTheFrameBeforeIt) {
  TrackSegmenter segmenter({40, 6});
  for (int frame = 0; frame < 5; ++frame) segmenter.Add(Views(frame, 30), 10);
  EXPECT_TRUE(segmenter.segments().empty());
  segmenter.Add(Views(5, 30), 0);
  ASSERT_EQ(segmenter.segments().size(), 30u);
  for (const TrackSegment& segment : segmenter.segments()) EXPECT_EQ(segment.first_frame, 4);
}

TEST(TrackSegments, ATrackToldLateHasTheViewBefore) {
  TrackSegmenter segmenter({40, 6});
  for (int frame = 0; frame < 5; ++frame) segmenter.Add({}, TagsThatReplaceTracks(40));
  auto views = Views(5, 10);
  for (TrackObservation& view : views) view.pixel_before = view.pixel - Eigen::Vector2d(0, 1);
  segmenter.Add(views, 0);
  ASSERT_EQ(segmenter.segments().size(), 10u);
  for (const TrackSegment& segment : segmenter.segments()) {
    EXPECT_EQ(segment.first_frame, 4);
    ASSERT_EQ(segment.pixels.size(), 2u);
    EXPECT_EQ(segment.pixels[0].y(), 4);
  }
}

TEST(TrackSegments, SoManyTagsLeaveNoRoomForTracks) {
  for (const int most : {1, 7, 20, 40}) {
    for (const int fewer : {0, 1}) {
      TrackSegmenter segmenter({most, 6});
      const int tags = TagsThatReplaceTracks(most) - fewer;
      segmenter.Add(Views(0, 50), tags);
      EXPECT_EQ(segmenter.segments().empty(), fewer == 0) << most;
    }
  }
}

TEST(TrackSegments, ViewsOnTagsAndBeyondTheBudgetStayOut) {
  TrackSegmenter segmenter({8, 6});
  auto views = Views(0, 20);
  for (int i = 0; i < 15; ++i) views[static_cast<size_t>(i)].on_tag = true;
  segmenter.Add(views, 0);
  EXPECT_EQ(segmenter.segments().size(), 5u);
  segmenter.Add(Views(1, 20), 0);
  EXPECT_EQ(segmenter.segments().size(), 8u);
}

TEST(TrackSegments, RejectedAndOldOnesDoNotGrow) {
  TrackSegmenter segmenter({40, 6});
  segmenter.Add(Views(0, 4), 0);
  segmenter.Reject({true, false, false, false});
  EXPECT_TRUE(segmenter.segments().front().pixels.empty());
  segmenter.DropBefore(1);
  EXPECT_TRUE(segmenter.segments().empty());
  segmenter.Add(Views(1, 4), 0);
  for (const TrackSegment& segment : segmenter.segments()) {
    EXPECT_EQ(segment.first_frame, 1);
    EXPECT_EQ(segment.pixels.size(), 1u);
  }
}

std::vector<TrackObservation> ViewsOfCamera(int frame, int camera, int n_tracks) {
  std::vector<TrackObservation> out = Views(frame, n_tracks);
  for (TrackObservation& view : out) {
    view.track_id = 2 * view.track_id + camera;
    view.camera = camera;
  }
  return out;
}

// Cameras that take their images in turn: a piece passes over the other's frames, and is no longer
// than another.
TEST(TrackSegments, GoOnInTheCamerasNextFrame) {
  TrackSegmenter segmenter({40, 6});
  for (int frame = 0; frame < 24; ++frame) {
    segmenter.Add(ViewsOfCamera(frame, frame % 2, 10), 0, {frame % 2});
  }
  std::set<std::pair<int64_t, int>> seen;
  size_t in_pairs = 0;
  for (const TrackSegment& segment : segmenter.segments()) {
    EXPECT_LT(segment.last_frame() - segment.first_frame, 6);
    EXPECT_EQ(segment.camera, segment.track_id % 2);
    in_pairs += segment.pixels.size() > 1 ? segment.pixels.size() : 0;
    for (size_t k = 0; k < segment.pixels.size(); ++k) {
      const int frame = segment.first_frame + segment.FramesAfter(k);
      EXPECT_EQ(frame % 2, segment.camera);
      EXPECT_EQ(segment.pixels[k].y(), frame);
      EXPECT_TRUE(seen.emplace(segment.track_id, frame).second) << "a view counted twice";
    }
  }
  EXPECT_EQ(seen.size(), 240u);
  EXPECT_GT(in_pairs, 200u);
}

TEST(TrackSegments, WhatACameraSawBeforeIsInItsOwnLastFrame) {
  TrackSegmenter segmenter({40, 6});
  segmenter.Add({}, 10, {0});
  segmenter.Add({}, 10, {1});
  auto views = ViewsOfCamera(2, 0, 3);
  for (TrackObservation& view : views) view.pixel_before = view.pixel - Eigen::Vector2d(0, 2);
  segmenter.Add(views, 0, {0});
  ASSERT_EQ(segmenter.segments().size(), 3u);
  for (const TrackSegment& segment : segmenter.segments()) {
    EXPECT_EQ(segment.first_frame, 0);
    EXPECT_EQ(segment.last_frame(), 2);
    EXPECT_EQ(segment.pixels.front().y(), 0);
  }
}

}  // namespace
}  // namespace tagtwist::internal::track_segments_test

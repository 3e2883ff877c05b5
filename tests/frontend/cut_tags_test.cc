#include <gtest/gtest.h>

#include <Eigen/LU>
#include <random>

#include "frontend/tags/find_tags.h"
#include "tests/support/flights/corner_flight.h"

namespace tagtwist::internal::cut_tags_test {
namespace {

constexpr double kFiveSigma = 28.7;  // squared, of two degrees of freedom

// A picture, its camera, and where the tags are in it.
struct Picture {
  cv::Mat image;
  Camera camera;
  Pose cam_from_world;
};

Picture Take(const Flight& flight, double share) {
  const SimulatedFrame frame = MakeFrame(flight, share);
  return {frame.image, {}, CourseCamFromBody() * Inverse(frame.truth.world_from_body)};
}

// Cut off along a line of the image: what a smaller sensor would have seen.
Picture Crop(const Picture& whole, const cv::Rect& part) {
  Picture out = whole;
  out.image = whole.image(part).clone();
  out.camera.width = part.width;
  out.camera.height = part.height;
  out.camera.cx -= part.x;
  out.camera.cy -= part.y;
  return out;
}

Corners TrueCorners(const Picture& picture, int id) {
  static const TagMap map = MakeTagMap(TagGrid());
  Corners out;
  for (size_t c = 0; c < 4; ++c) {
    EXPECT_TRUE(
        picture.camera.Project(picture.cam_from_world * map.CornersInWorld(id)[c], &out[c]));
  }
  return out;
}

// Corners by how far they are off.
struct Tally {
  int tags = 0, corners = 0, beyond = 0, whole = 0, whole_found = 0;
  double worst_px = 0;
};

struct Finder {
  TagMap map = MakeTagMap(TagGrid());
  CornerRefiner refiner = MakeRefiner();
  TagDetectorOptions options;
  Result<TagDetector> detector = TagDetector::Create("tag36h11", options);

  void Find(const Picture& picture, Tally* tally) const {
    const auto tags = FindTags(picture.image, *detector, refiner, map, picture.camera, options);
    for (const TagDetection& tag : tags) {
      const auto error = Difference(tag.corners, TrueCorners(picture, tag.id));
      ++tally->tags;
      for (int c = 0; c < 4; ++c) {
        const Eigen::Vector2d e = error.segment<2>(2 * c);
        const Eigen::Matrix2d p = tag.covariance->block<2, 2>(2 * c, 2 * c);
        const bool beyond = e.dot(p.inverse() * e) > kFiveSigma;
        ++tally->corners;
        tally->beyond += beyond ? 1 : 0;
        tally->worst_px = std::max(tally->worst_px, e.norm());
      }
    }
    for (const Tag& tag : map.tags()) {
      bool whole = true;
      for (const auto& corner : map.CornersInWorld(tag.id)) {
        Eigen::Vector2d pixel;
        whole = whole && picture.camera.Project(picture.cam_from_world * corner, &pixel) &&
                picture.camera.Contains(pixel, 6);
      }
      if (!whole) continue;
      ++tally->whole;
      tally->whole_found += std::any_of(tags.begin(), tags.end(),
                                        [&](const TagDetection& seen) { return seen.id == tag.id; })
                                ? 1
                                : 0;
    }
  }
};

// Parts of the image whose border on the given side runs through the middle third of the image.
cv::Rect PartOf(const cv::Size& size, int side, double share) {
  const int x = static_cast<int>(size.width * (0.2 + 0.4 * share));
  const int y = static_cast<int>(size.height * (0.2 + 0.4 * share));
  if (side == 0) return {x, 0, size.width - x, size.height};
  if (side == 1) return {0, 0, size.width - x, size.height};
  if (side == 2) return {0, y, size.width, size.height - y};
  return {0, 0, size.width, size.height - y};
}

Tally CutAtBorders(const Setting& setting, int frames) {
  const Flight flight = MakeFlightOf(setting);
  const Finder finder;
  std::mt19937_64 engine(5);
  std::uniform_real_distribution<double> unit(0, 1);
  Tally out;
  for (int i = 0; i < frames; ++i) {
    const Picture whole = Take(flight, (i + 0.5) / frames);
    for (int side = 0; side < 4; ++side) {
      for (int cut = 0; cut < 3; ++cut) {
        finder.Find(Crop(whole, PartOf(whole.image.size(), side, unit(engine))), &out);
      }
    }
  }
  return out;
}

void ExpectHonest(const Tally& tally) {
  EXPECT_GT(tally.tags, 200);
  EXPECT_LE(tally.beyond, tally.corners / 10000);
  EXPECT_LT(tally.worst_px, 0.5);
  EXPECT_GT(tally.whole, 1000);
  EXPECT_GE(tally.whole_found, tally.whole * 99 / 100);
}

TEST(CutTags, AtTheImagesBorder) { ExpectHonest(CutAtBorders({3, 0.5}, 20)); }
TEST(CutTags, SlowAtTheImagesBorderTilted) {
  ExpectHonest(CutAtBorders({3, 0.7, 0, 0.2, "agile"}, 20));
}

}  // namespace
}  // namespace tagtwist::internal::cut_tags_test

#include "frontend/tags/tag_sweep.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "frontend/tags/camera_motion.h"
#include "frontend/tags/find_tags.h"
#include "tests/support/flights/flight_scene.h"

namespace tagtwist::internal::tag_sweep_test {
namespace {

constexpr double kIntervalS = 0.02;

struct Film {
  std::vector<SweepImage> images;
  std::vector<Pose> cam_from_world;
};

Film Render(const std::string& name, double from_s, int frames, double exposure_s) {
  SimulatorOptions options;
  options.exposure_s = exposure_s;
  options.renderer.supersampling = 2;
  const RenderedFlight flight = MakeRenderedFlight(name, MakeTagMap({}), options);
  Film out;
  for (int i = 0; i < frames; ++i) {
    const SimulatedFrame frame = flight.simulator.MakeFrame(
        static_cast<uint64_t>(i), flight.StampAt(from_s + kIntervalS * i));
    out.images.push_back({frame.t_ns, frame.image});
    out.cam_from_world.push_back(CourseCamFromBody() * Inverse(frame.truth.world_from_body));
  }
  return out;
}

const Film& Agile() {
  static const Film film = Render("agile", 2, 32, 0.002);
  return film;
}

// Both ways of finding the tags of a film.
struct Finder {
  SetUp set_up = MakeSetUp({}, CourseCamFromBody(), MakeTagMap({}));
  TagDetectorOptions options;
  Result<CornerRefiner> refiner = CornerRefiner::Create(set_up.map, set_up.rig.front().camera);
  Result<TagDetector> detector = TagDetector::Create(set_up.map.family(), options);
  Result<TagSweep> sweep = TagSweep::Create(set_up, options, *refiner);

  std::vector<SweptTags> Sweep(const std::vector<SweepImage>& images) {
    return sweep->Find(images);
  }
  std::vector<SweptTags> Search(const std::vector<SweepImage>& images) const {
    std::vector<SweptTags> out;
    for (const SweepImage& image : images) {
      SweptTags found;
      found.tags = FindTags(image.gray, *detector, *refiner, set_up.map, set_up.rig.front().camera,
                            options, &found.doubled_ids);
      out.push_back(std::move(found));
    }
    return out;
  }
};

struct Tally {
  int tags = 0, wrong = 0;
  double squared_px2 = 0;

  double rms_px() const { return std::sqrt(squared_px2 / (4 * tags)); }
};

Tally Judge(const Film& film, const std::vector<SweptTags>& found) {
  const TagMap map = MakeTagMap({});
  Tally out;
  for (size_t i = 0; i < found.size(); ++i) {
    for (const TagDetection& tag : found[i].tags) {
      double squared = 0;
      for (size_t c = 0; c < 4; ++c) {
        Eigen::Vector2d corner(0, 0);
        EXPECT_TRUE(
            Camera().Project(film.cam_from_world[i] * map.CornersInWorld(tag.id)[c], &corner));
        squared += (tag.corners[c] - corner).squaredNorm();
      }
      ++out.tags;
      out.wrong += squared > 4 ? 1 : 0;
      out.squared_px2 += squared;
    }
  }
  return out;
}

std::vector<int> Ids(const SweptTags& found) {
  std::vector<int> out;
  for (const TagDetection& tag : found.tags) out.push_back(tag.id);
  return out;
}

// A tag's picture, copied to another place of the image.
void PasteTag(const cv::Mat& from, const TagDetection& tag, const Eigen::Vector2i& to,
              cv::Mat* image) {
  Eigen::AlignedBox2d box;
  for (const Eigen::Vector2d& corner : tag.corners) box.extend(corner);
  const auto low = [](double least) { return static_cast<int>(std::max(0.0, least - 8)); };
  const cv::Rect part(low(box.min().x()), low(box.min().y()),
                      static_cast<int>(box.sizes().x()) + 14,
                      static_cast<int>(box.sizes().y()) + 14);
  const cv::Mat tag_image = from(part & cv::Rect({0, 0}, from.size()));
  tag_image.copyTo((*image)(cv::Rect({to.x(), to.y()}, tag_image.size())));
}

TEST(TagSweep, SlowAsGoodAsSearchingEveryImage) {
  for (const Film& film : {Agile(), Render("circle", 3, 16, 0.008)}) {
    Finder finder;
    const Tally swept = Judge(film, finder.Sweep(film.images));
    const Tally searched = Judge(film, finder.Search(film.images));
    EXPECT_GE(swept.tags, searched.tags * 0.995);
    // Of the pixels far from edges a followed fit takes some: the states differ by a hundredth.
    EXPECT_LT(swept.rms_px(), 1.1 * searched.rms_px());
    EXPECT_EQ(swept.wrong, 0);
  }
}

TEST(TagSweep, NothingIsKeptFromPieceToPiece) {
  Finder finder;
  const std::vector<SweepImage> first(Agile().images.begin(), Agile().images.begin() + 12);
  const std::vector<SweepImage> second(Agile().images.begin() + 14, Agile().images.begin() + 26);
  const auto fresh = finder.Sweep(first);
  finder.Sweep(second);
  const auto again = finder.Sweep(first);
  for (size_t i = 0; i < first.size(); ++i) {
    ASSERT_EQ(Ids(fresh[i]), Ids(again[i]));
    for (size_t k = 0; k < fresh[i].tags.size(); ++k) {
      EXPECT_EQ(fresh[i].tags[k].corners, again[i].tags[k].corners);
      EXPECT_EQ(fresh[i].tags[k].covariance, again[i].tags[k].covariance);
    }
  }
}

// Images that are missing, black, or of elsewhere end nothing.
TEST(TagSweep, SlowFindsItsWayAgain) {
  Film film = Agile();
  const Film elsewhere = Render("circle", 12, 8, 0.002);
  for (size_t i = 8; i < 11; ++i) film.images[i].gray = cv::Mat();
  film.images[14].gray = cv::Mat::zeros(film.images[14].gray.size(), CV_8U);
  for (size_t i = 20; i < 28; ++i) {
    film.images[i].gray = elsewhere.images[i - 20].gray;
    film.cam_from_world[i] = elsewhere.cam_from_world[i - 20];
  }
  Finder finder;
  const auto swept = finder.Sweep(film.images), searched = finder.Search(film.images);
  const Tally tally = Judge(film, swept);
  EXPECT_EQ(tally.wrong, 0);
  EXPECT_GE(tally.tags, Judge(film, searched).tags * 0.99);
  for (size_t i = 0; i < swept.size(); ++i) {
    EXPECT_EQ(swept[i].tags.empty(), searched[i].tags.empty()) << i;
  }
}

// An id at a second place from one image on: told of every image that shows both.
TEST(TagSweep, SlowTellsOfDoubledIds) {
  constexpr size_t kFrom = 13;
  Film film = Render("hover", 2, 20, 0.002);
  Finder finder;
  const auto before = finder.Search(film.images);
  for (size_t i = kFrom; i < film.images.size(); ++i) {
    const cv::Mat whole = film.images[i].gray.clone();
    PasteTag(whole, before[i].tags.front(), {4, 4}, &film.images[i].gray);
  }
  const auto swept = finder.Sweep(film.images), searched = finder.Search(film.images);
  for (size_t i = 0; i < swept.size(); ++i) {
    EXPECT_EQ(swept[i].doubled_ids, searched[i].doubled_ids) << i;
    EXPECT_EQ(Ids(swept[i]), Ids(searched[i])) << i;
  }
  EXPECT_FALSE(swept[kFrom].doubled_ids.empty());
}

// A tag that comes into view elsewhere than the map has it is found as by searching.
TEST(TagSweep, FindsTagsThatAreNotWhereTheMapHasThem) {
  constexpr size_t kFrom = 9;
  Film film = Render("hover", 2, 20, 0.002);
  Finder finder;
  const auto before = finder.Search(film.images);
  const int id = before[0].tags.front().id;
  for (size_t i = kFrom; i < film.images.size(); ++i) {
    const cv::Mat whole = film.images[i].gray.clone();
    const TagDetection tag = before[i].tags.front();
    ASSERT_EQ(tag.id, id);
    std::vector<cv::Point> outline;
    for (const auto& c : tag.corners) outline.emplace_back(std::lround(c.x()), std::lround(c.y()));
    PasteTag(whole, before[i].tags.back(), {4, 4}, &film.images[i].gray);
    cv::fillConvexPoly(film.images[i].gray, outline, 128);
  }
  const auto swept = finder.Sweep(film.images), searched = finder.Search(film.images);
  for (size_t i = 0; i < swept.size(); ++i) {
    EXPECT_EQ(Ids(swept[i]), Ids(searched[i])) << i;
    EXPECT_EQ(swept[i].doubled_ids, searched[i].doubled_ids) << i;
  }
}

TEST(TagSweep, PiecesAreShorterWhereImagesAreLarge) {
  Camera camera;
  EXPECT_EQ(TagSweep::PieceLength(camera), 48u);
  camera.width = 1920;
  camera.height = 1080;
  EXPECT_EQ(TagSweep::PieceLength(camera), 32u);
  camera.width = 8000;
  camera.height = 6000;
  EXPECT_EQ(TagSweep::PieceLength(camera), 16u);
}

PosePrediction At(double x_m) {
  PosePrediction out;
  out.world_from_body = MakePose(Eigen::Quaterniond::Identity(), {x_m, 0, 1});
  return out;
}

TEST(CameraMotion, GoesOnAsItWasAndKnowsHowWell) {
  CameraMotion motion;
  constexpr int64_t kStep = 20'000'000;
  const auto x_m = [](double t_s) { return 0.1 + 2 * t_s + 0.5 * 3 * t_s * t_s; };
  for (int i = 0; i < 3; ++i) {
    EXPECT_FALSE(motion.At(i * kStep));
    motion.Add(i * kStep, At(x_m(0.02 * i)));
  }
  const auto next = motion.At(3 * kStep);
  ASSERT_TRUE(next);
  // An acceleration of 3 m/s^2 kept leads this far from where the last interval's velocity does.
  const double off_m = x_m(0.06) - next->world_from_body.translation().x();
  EXPECT_NEAR(off_m, 3 * 0.02 * 0.02, 1e-9);
  EXPECT_NEAR(std::sqrt(next->covariance(3, 3)), off_m, 1e-9);
  const auto later = motion.At(5 * kStep);
  EXPECT_GT(later->covariance(3, 3), 9 * next->covariance(3, 3));
}

}  // namespace
}  // namespace tagtwist::internal::tag_sweep_test

// Images of a rig: each camera's tags are found by themselves, through its own mount.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "estimator/jobs/measurement_stream.h"
#include "estimator/online/measure_frame.h"
#include "estimator/online/online_estimator.h"
#include "estimator/rig/rig_tags.h"
#include "tests/support/flights/flight_scene.h"
#include "tests/support/flights/rig_flights.h"

namespace tagtwist::internal::rig_images_test {
namespace {

constexpr size_t kImages = 12;

// The first two cameras of the rig, and what each takes of one flight, rendered once.
struct FilmedRig {
  tagtwist::SetUp set_up = RigOfThree();
  std::vector<std::vector<SimulatedFrame>> frames;  // of each camera
};

const FilmedRig& Filmed() {
  static const FilmedRig filmed = [] {
    FilmedRig out;
    out.set_up.rig.cameras.resize(2);
    SimulatorOptions options;
    options.exposure_s = 0;
    options.renderer.supersampling = 1;
    const auto trajectory = FlightPath("figure8", out.set_up.map, {});
    for (size_t i = 0; i < out.set_up.rig.cameras.size(); ++i) {
      const auto simulator = Simulator::Make(SetUpOfCamera(out.set_up, i), *trajectory, options);
      out.frames.emplace_back();
      for (size_t k = 0; k < kImages; ++k) {
        const auto t_ns = trajectory->first_ns() + static_cast<int64_t>(20'000'000 * k);
        out.frames.back().push_back(simulator->MakeFrame(k, t_ns));
      }
    }
    return out;
  }();
  return filmed;
}

Config RigConfig() {
  Config out;
  out.set_up = Filmed().set_up;
  return out;
}

std::vector<TagDetection> Told(size_t k) {
  std::vector<TagDetection> out;
  for (size_t i = 0; i < 2; ++i) {
    for (TagDetection tag : Filmed().frames[i][k].detections) {
      tag.camera = static_cast<int>(i);
      out.push_back(tag);
    }
  }
  return out;
}

size_t CountOf(const std::vector<TagDetection>& tags, int camera) {
  return static_cast<size_t>(std::count_if(
      tags.begin(), tags.end(), [camera](const TagDetection& t) { return t.camera == camera; }));
}

// A search of these images finds nothing, so what is found is where the body's prediction and the
// camera's own mount put it. The cameras take their images at once, or in turn.
TEST(RigImages, EachCameraIsGuidedThroughItsMount) {
  Config config = RigConfig();
  config.front_end.detector.min_decision_margin = 1e6;
  for (const bool at_once : {true, false}) {
    auto estimator = OnlineEstimator::Create(config);
    ASSERT_TRUE(estimator);
    EXPECT_TRUE(estimator->is_guided());
    for (size_t k = 0; k < kImages; ++k) {
      const auto& frames = Filmed().frames;
      const int64_t t_ns = frames[0][k].t_ns;
      std::vector<CameraImage> images;
      for (size_t i = 0; i < 2; ++i) {
        if (at_once || k % 2 == i) images.push_back({static_cast<int>(i), frames[i][k].image});
      }
      const bool is_told = k < 4;
      const auto output =
          is_told ? estimator->AddTags(t_ns, Told(k)) : estimator->AddImages(t_ns, images);
      ASSERT_TRUE(output) << output.error().message;
      if (is_told) continue;
      const std::vector<TagDetection>& tags = estimator->measurements().tags;
      for (int i = 0; i < 2; ++i) {
        const bool is_there = at_once || static_cast<int>(k % 2) == i;
        EXPECT_EQ(CountOf(tags, i) > 6, is_there) << k << " " << i;
      }
      const Pose& truth = frames[0][k].truth.world_from_body;
      EXPECT_LT(PositionErrorM(output->current.state.world_from_body, truth), 1e-3) << k;
      EXPECT_TRUE(estimator->measurements().closed_form.world_from_body);
    }
  }
}

TEST(RigImages, RefusesCamerasThatItCannotTell) {
  auto estimator = OnlineEstimator::Create(RigConfig());
  ASSERT_TRUE(estimator);
  const cv::Mat gray(240, 376, CV_8U, cv::Scalar(0));
  for (const std::vector<CameraImage>& images : std::vector<std::vector<CameraImage>>{
           {}, {{2, gray}}, {{-1, gray}}, {{1, gray}, {0, gray}}, {{0, gray}, {0, gray}}}) {
    EXPECT_FALSE(estimator->AddImages(1, images));
  }
  EXPECT_TRUE(estimator->AddImages(1, {{1, gray}}));
}

constexpr size_t kTold = 4;

// The film, of both cameras, the second's at every other stamp; or of one camera alone. With the
// first frames' tags, where they are told.
class Film : public DataSource {
 public:
  explicit Film(std::vector<size_t> cameras, bool tags_are_told = false)
      : cameras_(std::move(cameras)), tags_are_told_(tags_are_told) {}
  Result<std::optional<Frame>> Next() override {
    if (next_ == kImages) return std::optional<Frame>();
    const size_t k = next_++;
    std::optional<Frame> out;
    for (size_t i = 0; i < cameras_.size(); ++i) {
      if (cameras_[i] == 1 && k % 2 == 1) continue;
      const SimulatedFrame& taken = Filmed().frames[cameras_[i]][k];
      Frame frame;
      frame.t_ns = taken.t_ns;
      frame.image = taken.image;
      frame.camera = static_cast<int>(i);
      if (tags_are_told_ && k < kTold) frame.detections = TagsOfCamera(Told(k), frame.camera);
      if (out) {
        out->others.push_back(std::move(frame));
      } else {
        out = std::move(frame);
      }
    }
    return out ? Result<std::optional<Frame>>(std::move(out)) : Next();
  }
  const std::vector<int64_t>& stamps_ns() const override { return stamps_ns_; }

 private:
  std::vector<size_t> cameras_;
  bool tags_are_told_;
  size_t next_ = 0;
  std::vector<int64_t> stamps_ns_;
};

// Tags by stamp, as a batch finds them.
std::map<int64_t, std::vector<TagDetection>> Swept(const std::vector<size_t>& cameras) {
  Film film(cameras);
  Config config = RigConfig();
  if (cameras.size() == 1) config.set_up = SetUpOfCamera(config.set_up, cameras.front());
  StreamOptions options;
  options.detection = DetectionMode::kAuto;
  auto stream = MeasurementStream::Create(&film, config, options);
  EXPECT_TRUE(stream);
  std::map<int64_t, std::vector<TagDetection>> out;
  while (true) {
    auto frame = stream->Next();
    if (!frame || !*frame) return out;
    out[(*frame)->measurements.t_ns] = (*frame)->measurements.tags;
  }
}

// What a batch finds in a camera's images does not depend on what others see.
TEST(RigImages, ABatchGoesOverEachCamerasByThemselves) {
  const auto both = Swept({0, 1});
  EXPECT_EQ(both.size(), kImages);
  for (const int camera : {0, 1}) {
    const auto alone = Swept({static_cast<size_t>(camera)});
    for (const auto& [t_ns, tags] : alone) {
      const auto own = TagsOfCamera(both.at(t_ns), camera);
      ASSERT_EQ(own.size(), tags.size());
      EXPECT_GT(tags.size(), 6u);
      for (size_t i = 0; i < tags.size(); ++i) {
        EXPECT_EQ(own[i].id, tags[i].id);
        EXPECT_EQ(own[i].corners, tags[i].corners);
      }
    }
  }
}

// Where tracks show the floor, by the body's true poses and each camera's mount: each one place, in
// its camera's images, the one before it was told for the first time included.
void ExpectTracksOfBothCameras(const std::vector<FrameMeasurements>& frames) {
  const EstimatorSetup setup = MakeEstimatorSetup(RigConfig().set_up, {});
  struct Track {
    int camera = 0;
    std::vector<Eigen::Vector2d> places;
  };
  std::map<int64_t, Track> tracks;
  std::map<int, size_t> last_image;
  for (size_t k = 0; k < frames.size(); ++k) {
    for (const TrackObservation& seen : frames[k].tracks) {
      Track& track = tracks.try_emplace(seen.track_id, Track{seen.camera, {}}).first->second;
      EXPECT_EQ(track.camera, seen.camera);
      const auto add = [&](size_t frame, const Eigen::Vector2d& pixel) {
        const Pose& body = Filmed().frames[0][frame].truth.world_from_body;
        const auto place = PointOnPlane(setup, body, Pose(), pixel, seen.camera);
        if (place) track.places.push_back(*place);
      };
      if (seen.pixel_before) add(last_image[seen.camera], *seen.pixel_before);
      add(k, seen.pixel);
    }
    for (const int camera : frames[k].cameras) last_image[camera] = k;
  }
  size_t n[2] = {}, still[2] = {};
  for (const auto& [id, track] : tracks) {
    if (track.places.size() < 3) continue;
    constexpr double kStillM = 0.003;
    ++n[track.camera];
    if ((track.places.back() - track.places.front()).norm() < kStillM) ++still[track.camera];
  }
  for (const int camera : {0, 1}) {
    EXPECT_GT(n[camera], 20u) << camera;
    EXPECT_GT(static_cast<double>(still[camera]), 0.8 * static_cast<double>(n[camera])) << camera;
  }
}

TEST(RigImages, TracksAreOfEachCamera) {
  Film film({0, 1}, /*tags_are_told=*/true);
  StreamOptions told;
  told.use_detections = true;
  auto stream = MeasurementStream::Create(&film, RigConfig(), told);
  ASSERT_TRUE(stream);
  std::vector<FrameMeasurements> frames;
  while (true) {
    auto frame = stream->Next();
    ASSERT_TRUE(frame);
    if (!*frame) break;
    frames.push_back((*frame)->measurements);
    EXPECT_EQ(frames.back().cameras.size(), frames.size() % 2 == 1 ? 2u : 1u);
  }
  ASSERT_EQ(frames.size(), kImages);
  ExpectTracksOfBothCameras(frames);

  Config blind = RigConfig();
  blind.front_end.detector.min_decision_margin = 1e6;
  auto estimator = OnlineEstimator::Create(blind);
  ASSERT_TRUE(estimator);
  frames.clear();
  for (size_t k = 0; k < kImages; ++k) {
    std::vector<CameraImage> images;
    for (size_t i = 0; i < 2; ++i) {
      if (i == 0 || k % 2 == 0) {
        images.push_back({static_cast<int>(i), Filmed().frames[i][k].image});
      }
    }
    ASSERT_TRUE(estimator->AddImages(Filmed().frames[0][k].t_ns, images));
    frames.push_back(estimator->measurements());
  }
  ExpectTracksOfBothCameras(frames);
}

}  // namespace
}  // namespace tagtwist::internal::rig_images_test

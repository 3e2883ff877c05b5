#include "estimator/jobs/measurement_stream.h"

#include <gtest/gtest.h>

#include <memory>

#include "estimator/jobs/pieces/measure_corners.h"
#include "tests/support/flights/flight_scene.h"

namespace tagtwist::internal::measurement_stream_test {
namespace {

constexpr size_t kFrames = 60;  // more than a piece of images that are searched together

// A rendered flight; a frame of another size stands where the recording breaks off.
class Film : public DataSource {
 public:
  explicit Film(size_t broken_at = kFrames) : broken_at_(broken_at) {
    for (const Frame& frame : Frames()) stamps_ns_.push_back(frame.t_ns);
  }
  Result<std::optional<Frame>> Next() override {
    if (next_ == kFrames) return std::optional<Frame>();
    Frame frame = Frames()[next_];
    if (next_++ == broken_at_) frame.image = cv::Mat::zeros(10, 10, CV_8U);
    return std::optional<Frame>(frame);
  }
  const std::vector<int64_t>& stamps_ns() const override { return stamps_ns_; }

 private:
  static const std::vector<Frame>& Frames() {
    static const std::vector<Frame> frames = [] {
      SimulatorOptions options;
      options.exposure_s = 0;
      options.renderer.supersampling = 1;
      const RenderedFlight flight = MakeRenderedFlight("figure8", MakeTagMap({}), options);
      std::vector<Frame> out;
      for (size_t i = 0; i < kFrames; ++i) {
        const int64_t t_ns = flight.StampAt(2 + 0.02 * static_cast<double>(i));
        out.push_back({t_ns, "film", flight.simulator.MakeFrame(i, t_ns).image, "", {}, {}});
      }
      return out;
    }();
    return frames;
  }

  size_t broken_at_, next_ = 0;
  std::vector<int64_t> stamps_ns_;
};

Config FilmConfig() {
  Config config;
  config.set_up = MakeSetUp({}, CourseCamFromBody(), MakeTagMap({}));
  return config;
}

std::string Corners(const FrameRange& range, int threads,
                    DetectionMode detection = DetectionMode::kAuto) {
  RunOptions options;
  options.threads = threads;
  options.detection = detection;
  options.progress = false;
  const auto out = MeasureCorners(std::make_unique<Film>(), range, FilmConfig(), options);
  EXPECT_TRUE(out);
  return *out;
}

TEST(MeasurementStream, SlowFindsTheSameCornersOnAnyNumberOfThreads) {
  ASSERT_LT(FramesPerPiece(FilmConfig(), DetectionMode::kAuto), kFrames);
  const std::string one = Corners({0, kFrames}, 1);
  EXPECT_GT(one.size(), 1000 * kFrames);
  EXPECT_EQ(one, Corners({0, kFrames}, 3));
  EXPECT_NE(one, Corners({0, kFrames}, 3, DetectionMode::kFull));
}

TEST(MeasurementStream, SlowRangesJoinedAreTheSameCornersAsAllAtOnce) {
  std::string joined;
  for (const FrameRange& range : {FrameRange{0, 20}, {20, 50}, {50, kFrames}}) {
    const std::string corners = Corners(range, 2);
    joined += joined.empty() ? corners : corners.substr(corners.find('\n') + 1);
  }
  EXPECT_EQ(joined, Corners({0, kFrames}, 2));
}

// What came before a frame that cannot be used is measured, and no frame beyond the limit is read.
TEST(MeasurementStream, EndsWhereItIsTold) {
  constexpr size_t kBroken = 5;
  StreamOptions options;
  options.threads = 2;
  options.detection = DetectionMode::kAuto;
  for (const size_t most : {kBroken, kFrames}) {
    Film film(kBroken);
    options.max_frames = most;
    auto stream = MeasurementStream::Create(&film, FilmConfig(), options);
    ASSERT_TRUE(stream);
    for (size_t i = 0; i < kBroken; ++i) {
      const auto frame = stream->Next();
      ASSERT_TRUE(frame && *frame) << i;
      EXPECT_FALSE((*frame)->measurements.tags.empty()) << i;
    }
    const auto last = stream->Next();
    EXPECT_EQ(static_cast<bool>(last), most == kBroken);
    EXPECT_FALSE(last && *last);
  }
}

}  // namespace
}  // namespace tagtwist::internal::measurement_stream_test

// Simulated corners of set-ups with one mistake, and of right ones.
#include "estimator/calibration/set_up/set_up_fault.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "frontend/simulation/named_flights.h"
#include "frontend/simulation/simulator.h"

namespace tagtwist::internal::set_up_fault_test {
namespace {

using ::testing::HasSubstr;

struct Seen {
  Camera camera;
  double line_time_s = 0;
  TagMap map = MakeTagMap(TagGrid());
  std::vector<SeenTags> frames;
};

Pose Downwards() {
  return MakePose(
      Eigen::Quaterniond(Eigen::AngleAxisd(M_PI, Eigen::Vector3d(1, -1, 0).normalized())),
      Eigen::Vector3d::Zero());
}

Seen Fly(const std::string& flight, double noise_px, uint64_t seed, const Camera& camera = {},
         double line_time_s = 0) {
  Seen out;
  out.camera = camera;
  out.line_time_s = line_time_s;
  const auto trajectory = FlightPath(flight, out.map, {});
  EXPECT_TRUE(trajectory);
  SimulatorOptions options;
  options.images = false;
  options.random_seed = seed;
  options.corner_noise_px = noise_px;
  options.line_time_s = line_time_s;
  tagtwist::SetUp set_up;
  set_up.rig.front().camera = camera;
  set_up.rig.front().cam_from_body = Downwards();
  set_up.map = out.map;
  const auto simulator = Simulator::Make(set_up, *trajectory, options);
  EXPECT_TRUE(simulator);
  for (uint64_t i = 0; i < 240; ++i) {
    const int64_t t_ns = trajectory->first_ns() + static_cast<int64_t>(i) * 30'000'000;
    out.frames.push_back({t_ns, simulator->MakeFrame(i, t_ns).detections});
  }
  return out;
}

std::string FaultOf(const Seen& seen) {
  const auto fault = FindSetUpFault(seen.frames, seen.camera, seen.line_time_s, seen.map);
  return fault ? fault->fact : "";
}

Camera Bent() {
  Camera camera;
  camera.k1 = -0.25;
  camera.k2 = 0.07;
  return camera;
}

TEST(SetUpFault, SlowRightSetUpsAreLeftAlone) {
  for (const char* flight : {"figure8", "agile", "circle", "hover"}) {
    for (const uint64_t seed : {1U, 2U, 3U}) {
      EXPECT_EQ(FaultOf(Fly(flight, 0.1 * static_cast<double>(seed), seed)), "") << flight;
    }
    EXPECT_EQ(FaultOf(Fly(flight, 0.2, 7, Bent())), "") << flight;
    EXPECT_EQ(FaultOf(Fly(flight, 0.2, 8, {}, 6e-5)), "") << flight;
  }
}

// A calibration is never exact.
TEST(SetUpFault, ToleratesWhatCalibrationsAreOffBy) {
  Seen seen = Fly("agile", 0.2, 5);
  seen.camera.fx *= 1.01;
  seen.camera.fy *= 1.01;
  seen.camera.cx += 2;
  EXPECT_EQ(FaultOf(seen), "");
}

TEST(SetUpFault, NamesAWrongFocalLength) {
  Seen seen = Fly("agile", 0.3, 5);
  seen.camera.fx *= 2;
  seen.camera.fy *= 2;
  EXPECT_THAT(FaultOf(seen), HasSubstr("0.50 times the calibration's 622 px"));
}

TEST(SetUpFault, SlowNamesAnotherResolution) {
  for (const char* flight : {"figure8", "agile", "circle"}) {
    Seen seen = Fly(flight, 0.2, 5);
    for (double* value : {&seen.camera.fx, &seen.camera.fy, &seen.camera.cx, &seen.camera.cy}) {
      *value *= 2;
    }
    EXPECT_THAT(FaultOf(seen), HasSubstr("calibration scaled by 0.50")) << flight;
  }
}

TEST(SetUpFault, NamesAShiftedImage) {
  Seen seen = Fly("agile", 0.2, 5);
  seen.camera.cx -= 40;
  seen.camera.cy -= 20;
  EXPECT_THAT(FaultOf(seen), HasSubstr("cropped or shifted"));
}

// As 4:3 shown as 16:9, by either side.
TEST(SetUpFault, SlowNamesAStretchedImage) {
  Seen wide = Fly("figure8", 0.2, 5);
  wide.camera.fx *= 0.75;
  wide.camera.cx *= 0.75;
  EXPECT_THAT(FaultOf(wide), HasSubstr("its x scaled by 1.33 and its y by 1.00"));
  Seen high = Fly("agile", 0.2, 5);
  high.camera.fy *= 1.2;
  high.camera.cy *= 1.2;
  EXPECT_THAT(FaultOf(high), HasSubstr("its x scaled by 1.00 and its y by 0.83"));
}

TEST(SetUpFault, SlowNamesADistortionThatIsMissing) {
  Seen seen = Fly("figure8", 0.2, 5, Bent());
  seen.camera = Camera();
  EXPECT_THAT(FaultOf(seen), HasSubstr("where the calibration has no distortion"));
}

TEST(SetUpFault, SlowNamesSizesWithTheirBorder) {
  for (const char* flight : {"figure8", "hover"}) {
    Seen seen = Fly(flight, 0.2, 5);
    std::vector<Tag> tags = seen.map.tags();
    for (Tag& tag : tags) tag.size_m *= 1.25;
    seen.map = TagMap(seen.map.family(), tags);
    EXPECT_THAT(FaultOf(seen), HasSubstr("The tags are 0.800 times as large")) << flight;
  }
}

TEST(SetUpFault, NamesRowsForColumns) {
  Seen seen = Fly("figure8", 0.2, 5);
  TagGrid grid;
  std::swap(grid.rows, grid.columns);
  std::swap(grid.row_gaps_m, grid.column_gaps_m);
  seen.map = MakeTagMap(grid);
  EXPECT_THAT(FaultOf(seen), HasSubstr("rows and columns exchanged"));
}

TEST(SetUpFault, NamesARollingShutter) {
  Seen seen = Fly("agile", 0.2, 5, {}, 6e-5);
  seen.line_time_s = 0;
  EXPECT_THAT(FaultOf(seen), HasSubstr("rolling shutter that reads an image in 14 ms"));
}

// Both ways of it: one gap for both sides, and distances from centre to centre for gaps.
TEST(SetUpFault, SlowNamesGaps) {
  TagGrid grid;
  Seen seen = Fly("figure8", 0.2, 5);
  for (double& gap_m : grid.column_gaps_m) gap_m *= 1.4;
  seen.map = MakeTagMap(grid);
  EXPECT_THAT(FaultOf(seen), HasSubstr("The gaps between the tags are not the map's"));
}

TEST(SetUpFault, SlowSaysThatTheMapIsAnother) {
  Seen seen = Fly("figure8", 0.2, 5);
  std::vector<Tag> tags = seen.map.tags();
  for (size_t i = 0; i < tags.size(); ++i)
    tags[i].id = static_cast<int>((i * 37 + 11) % tags.size());
  seen.map = TagMap(seen.map.family(), tags);
  EXPECT_THAT(FaultOf(seen), HasSubstr("do not lie as the map has them"));
}

}  // namespace
}  // namespace tagtwist::internal::set_up_fault_test

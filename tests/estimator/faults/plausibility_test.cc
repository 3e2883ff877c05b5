#include "estimator/evaluation/plausibility.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

namespace tagtwist::internal::plausibility_test {
namespace {

using ::testing::HasSubstr;

std::string Facts(const std::vector<Fault>& faults) {
  std::string out;
  for (const Fault& fault : faults) out += fault.fact + "\n";
  return out;
}

std::vector<TimedPose> Circle(double interval_s, double step_rad, double jitter_m = 0) {
  std::vector<TimedPose> out;
  for (int i = 0; i < 50; ++i) {
    const double a = step_rad * i, off = i % 2 == 0 ? jitter_m : -jitter_m;
    out.push_back(
        {std::llround(1e9 * interval_s * i),
         MakePose(Eigen::Quaterniond::Identity(), {std::cos(a) + off, std::sin(a) - off, 1})});
  }
  return out;
}

TEST(Plausibility, RightSetUpsAreLeftAlone) {
  EXPECT_EQ(Facts(ImplausibleSetUp({}, MakeTagMap(TagGrid()))), "");
  Camera wide;
  wide.fx = wide.fy = 60;
  EXPECT_EQ(Facts(ImplausibleSetUp(wide, MakeTagMap(TagGrid()))), "");
  EXPECT_EQ(Facts(ImplausibleMotion(Circle(0.03, 0.03))), "");
  EXPECT_EQ(Facts(ImplausibleMotion(Circle(30, 2.2))), "");  // stills from all around
  EXPECT_EQ(Facts(ImplausibleMotion(Circle(30, 1e-5, 1e-3))),
            "");  // at rest, looked at now and then
}

TEST(Plausibility, TellsMillimetres) {
  TagGrid grid;
  grid.tag_size_m = 152;
  for (double& gap : grid.row_gaps_m) gap *= 1e3;
  for (double& gap : grid.column_gaps_m) gap *= 1e3;
  EXPECT_THAT(Facts(ImplausibleSetUp({}, MakeTagMap(grid))), HasSubstr("tags of 152 m"));
}

TEST(Plausibility, TellsACentreOffTheImage) {
  Camera camera;
  std::swap(camera.width, camera.height);
  camera.cx = 300;
  EXPECT_THAT(Facts(ImplausibleSetUp(camera, MakeTagMap(TagGrid()))), HasSubstr("principal point"));
  camera = {};
  camera.fx = camera.fy = 3;
  EXPECT_THAT(Facts(ImplausibleSetUp(camera, MakeTagMap(TagGrid()))), HasSubstr("field of view"));
}

TEST(Plausibility, TellsStampsInAnotherUnit) {
  EXPECT_THAT(Facts(ImplausibleMotion(Circle(30, 0.03))), HasSubstr("one in 30 s"));
  EXPECT_THAT(Facts(ImplausibleMotion(Circle(3e-5, 0.03))), HasSubstr("m/s"));
}

}  // namespace
}  // namespace tagtwist::internal::plausibility_test

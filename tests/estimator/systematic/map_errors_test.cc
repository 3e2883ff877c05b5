// Errors of a map that neighbouring tags share: what the field over it does to tags, and that the
// covariances of the poses have it, over a mat that is drawn flat and evenly and is not so.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <array>
#include <cmath>
#include <random>

#include "estimator/batch/batch.h"
#include "estimator/systematic/map_field.h"
#include "estimator/window/sliding_window.h"
#include "frontend/simulation/named_flights.h"
#include "frontend/simulation/simulator.h"
#include "tests/support/draws.h"
#include "tests/support/flights/exact_model.h"
#include "tests/support/flights/simulated_flight.h"

namespace tagtwist::internal::map_errors_test {
namespace {

using testing::AllOf;
using testing::Gt;
using testing::Lt;

std::vector<Eigen::Vector3d> PlacesOf(const TagMap& map) {
  std::vector<Eigen::Vector3d> out;
  for (const Tag& tag : map.tags()) out.push_back(tag.world_from_tag.translation());
  return out;
}

TEST(MapField, SlopesAreTheDerivativesOfWhatItMovesATagBy) {
  const MapField field(PlacesOf(CourseSetUp().map), 1.5);
  constexpr double kStep = 1e-4;
  Tag tag = CourseSetUp().map.tags()[40];
  const Eigen::Quaterniond turned(0.9, 0.2, -0.3, 0.1);
  const Eigen::Vector3d place(1.1, 0.8, 0.05);
  tag.world_from_tag = MakePose(turned, place);
  const Eigen::MatrixXd here = field.OfTag(tag);
  const Eigen::Matrix3d axes = tag.world_from_tag.rotation().toRotationMatrix();
  for (int a = 0; a < 2; ++a) {
    Tag after = tag, before = tag;
    after.world_from_tag = MakePose(turned, place + kStep * axes.col(a));
    before.world_from_tag = MakePose(turned, place - kStep * axes.col(a));
    const Eigen::RowVectorXd slope = axes.col(2).transpose() *
                                     (field.OfTag(after) - field.OfTag(before)).topRows(3) /
                                     (2 * kStep);
    EXPECT_LT((slope - here.row(3 + a)).norm(), 1e-5 * here.row(3 + a).norm());
  }
}

// What bends a map leaves it where it is: a shift, a turn and a stretch have modes of their own.
TEST(MapField, ABendHasNoShiftAndNoStretchInIt) {
  const TagMap map = CourseSetUp().map;
  const MapField field(PlacesOf(map), 2);
  EXPECT_EQ(field.stretch_modes(), 6);  // a flat map has three, and a shift
  const Eigen::Index bends = field.bend_modes() - 6;
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(3, bends), moment = sum;
  double square = 0;
  for (const Tag& tag : map.tags()) {
    const Eigen::MatrixXd moved = field.OfTag(tag).topLeftCorner(3, bends);
    sum += moved;
    moment += tag.world_from_tag.translation().x() * moved;
    square += moved.squaredNorm() / static_cast<double>(3 * map.tags().size());
  }
  EXPECT_LT(sum.norm(), 1e-9);
  EXPECT_LT(moment.norm(), 1e-9);
  EXPECT_NEAR(square, 1, 0.05);  // of each coordinate
}

TEST(MapField, SlopesLiftCornersOffTheTagsPlane) {
  const Tag tag = CourseSetUp().map.tags()[0];
  const Eigen::Matrix<double, 12, 2> moved = CornersBySlopes(tag);
  const auto corners = TagCornersInWorld(tag);
  const Eigen::Matrix3d axes = tag.world_from_tag.rotation().toRotationMatrix();
  for (int c = 0; c < 4; ++c) {
    const Eigen::Vector3d arm = corners[static_cast<size_t>(c)] - tag.world_from_tag.translation();
    for (int a = 0; a < 2; ++a) {
      const Eigen::Vector3d expected = arm.dot(axes.col(a)) * axes.col(2);
      EXPECT_LT((moved.block<3, 1>(3 * c, a) - expected).norm(), 1e-12);
    }
  }
}

enum class Kind { kNone, kGaps, kWaves, kSheets };

// The course's mat as it lies there.
SetUp AsItIs(Kind kind, std::mt19937* random) {
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform(0, 1);
  SetUp out = CourseSetUp();
  std::vector<Tag> tags = out.map.tags();
  std::array<double, 9> columns_m{};
  for (size_t i = 1; i < columns_m.size(); ++i) {
    const double sign = uniform(*random) < 0.5 ? -1 : 1;
    columns_m[i] = columns_m[i - 1] + sign * (1 + uniform(*random)) * 1e-3;
  }
  std::array<Eigen::Vector3d, 9> sheets_m;
  for (auto& sheet : sheets_m) sheet << 3e-3 * DrawVector<2>(normal, *random), 0;
  const double angle = 2 * M_PI * uniform(*random), phase = 2 * M_PI * uniform(*random);
  const Eigen::Vector3d along =
      2 * M_PI / (1 + uniform(*random)) * Eigen::Vector3d(std::cos(angle), std::sin(angle), 0);
  for (Tag& tag : tags) {
    const int row = tag.id % 12, column = tag.id / 12;
    Eigen::Vector3d place = tag.world_from_tag.translation();
    Eigen::Quaterniond turn = tag.world_from_tag.rotation();
    if (kind == Kind::kGaps) place.y() += columns_m[static_cast<size_t>(column)];
    if (kind == Kind::kSheets) place += sheets_m[static_cast<size_t>(column / 3 * 3 + row / 4)];
    if (kind == Kind::kWaves) {
      constexpr double kHigh = 8e-3;
      const double at = along.dot(place) + phase;
      const Eigen::Vector3d slope = kHigh * std::cos(at) * along;
      place.z() += kHigh * std::sin(at);
      turn = Eigen::Quaterniond(1, slope.y() / 2, -slope.x() / 2, 0).normalized() * turn;
    }
    tag.world_from_tag = MakePose(turn, place);
  }
  out.map = TagMap(out.map.family(), tags);
  return out;
}

SimulatedFlight FlyOver(const SetUp& as_it_is, const std::string& name, unsigned seed) {
  const auto path = *FlightPath(name, CourseSetUp().map, {6, 1.2});
  SimulatorOptions options;
  options.images = false;
  options.corner_noise_px = 0.15;
  options.random_seed = seed;
  return RecordFrames(*Simulator::Make(as_it_is, path, options), 30);
}

// Of the poses, a degree of freedom, from a second on.
double PoseNees(const std::vector<FrameEstimate>& frames, const std::vector<BodyState>& truth) {
  double sum = 0;
  for (size_t i = 30; i < truth.size(); ++i) {
    const Eigen::Matrix<double, 6, 1> error =
        Difference(truth[i].world_from_body, frames.at(i).state.world_from_body);
    const PoseCovariance covariance = frames[i].covariance.topLeftCorner<6, 6>();
    sum += error.dot(covariance.inverse() * error) / 6;
  }
  return sum / static_cast<double>(truth.size() - 30);
}

struct Nees {
  double batch = 0, arrival = 0, lag = 0;
};

Nees NeesOver(Kind kind) {
  Nees out;
  // A hover sees few tags, from where a lens looks as they do: there a search may take the lens.
  const std::array<const char*, 3> names = {"figure8", "agile", "circle"};
  constexpr unsigned kRuns = 6;
  for (unsigned i = 0; i < kRuns; ++i) {
    std::mt19937 random(30 + i);
    const SetUp believed = CourseSetUp();
    const SimulatedFlight flight = FlyOver(AsItIs(kind, &random), names[i % names.size()], 30 + i);
    const auto batch = RunBatch(believed, {}, flight.measurements);
    EXPECT_TRUE(batch);
    out.batch += PoseNees(batch->frames, flight.truth) / kRuns;
    if (kind == Kind::kNone) {
      EXPECT_EQ(batch->systematic.tag_sigma_m, 0) << i;
    } else {
      EXPECT_GT(batch->systematic.tag_sigma_m, 3e-4) << i;
    }
    SlidingWindow window(believed, {});
    std::vector<FrameEstimate> arrival, lag;
    for (const FrameMeasurements& measurement : flight.measurements) {
      const auto said = window.Add(measurement);
      EXPECT_TRUE(said);
      arrival.push_back(said->current);
      lag.insert(lag.end(), said->lagged.begin(), said->lagged.end());
    }
    for (const FrameEstimate& frame : window.Finish()) lag.push_back(frame);
    out.arrival += PoseNees(arrival, flight.truth) / kRuns;
    out.lag += PoseNees(lag, flight.truth) / kRuns;
  }
  return out;
}

void ExpectCovered(Kind kind) {
  const Nees nees = NeesOver(kind);
  EXPECT_THAT(nees.batch, AllOf(Gt(0.05), Lt(2)));  // 1/6 where all errors are along one direction
  EXPECT_THAT(nees.arrival, AllOf(Gt(0.2), Lt(3)));
  EXPECT_THAT(nees.lag, AllOf(Gt(0.2), Lt(3)));
  testing::Test::RecordProperty("batch", std::to_string(nees.batch));
  testing::Test::RecordProperty("arrival", std::to_string(nees.arrival));
  testing::Test::RecordProperty("lag", std::to_string(nees.lag));
}

TEST(MapErrors, SlowOfGapsBetweenColumnsAreCovered) { ExpectCovered(Kind::kGaps); }

TEST(MapErrors, SlowOfAMatInWavesAreCovered) { ExpectCovered(Kind::kWaves); }

TEST(MapErrors, SlowOfSheetsThatAreLaidSideBySideAreCovered) { ExpectCovered(Kind::kSheets); }

TEST(MapErrors, SlowAreNotFoundWhereThereAreNone) {
  const Nees nees = NeesOver(Kind::kNone);
  EXPECT_THAT(nees.batch, AllOf(Gt(0.8), Lt(1.2)));
  EXPECT_THAT(nees.lag, AllOf(Gt(0.8), Lt(1.2)));
}

}  // namespace
}  // namespace tagtwist::internal::map_errors_test

// tagtwist_estimate as it is run, on rendered flights.
#include "tests/support/estimate_program.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <sstream>

#include "estimator/online/config.h"
#include "frontend/io/tables/csv.h"
#include "frontend/types/tag_map.h"

namespace tagtwist::internal::estimate_program_test {
namespace {

const std::string kSource = TAGTWIST_SOURCE_DIR;

using SlowEstimateProgram = EstimateProgram;

// Everything but what time and memory change.
std::string StableSummary(const fs::path& folder) {
  auto summary = nlohmann::json::parse(ReadText(folder / "summary.json"));
  for (const char* key : {"timing_ms", "wall_s", "peak_rss_mib", "dataset"}) summary.erase(key);
  return summary.dump();
}

void ExpectSameBytes(const fs::path& a, const fs::path& b) {
  int n = 0;
  for (const auto& entry : fs::directory_iterator(a)) {
    const std::string name = entry.path().filename();
    if (name == "report.html" || name == "summary.json") continue;
    EXPECT_EQ(ReadText(a / name), ReadText(b / name)) << name;
    ++n;
  }
  EXPECT_GE(n, 4);
  EXPECT_EQ(StableSummary(a), StableSummary(b));
}

TEST_F(EstimateProgram, SlowSameCommandSameBytesAtAnyThreadCount) {
  Simulate("flight", {"--duration", "1", "--rate", "15"});
  for (const std::string mode : {"--nosliding_window", "--sliding_window"}) {
    const Arguments common = {"--dataset", "flight", "--write_covariance", mode};
    for (const std::string threads : {"1", "2"}) {
      Arguments arguments = common;
      arguments.insert(arguments.end(), {"--threads", threads});
      Estimate("threads" + threads, arguments);
    }
    Estimate("again", common);
    ExpectSameBytes(Path("threads1"), Path("threads2"));
    ExpectSameBytes(Path("threads1"), Path("again"));
  }
}

TEST_F(EstimateProgram, WritesOneRowAFrameAtLagZeroAndAtTheLag) {
  Simulate("flight", {"--images=false", "--duration", "1"});
  const auto summary =
      Estimate("out", {"--dataset", "flight", "--use_detections", "--sliding_window"});
  const auto frames = summary["frames"].get<size_t>();
  EXPECT_EQ(summary["frames_estimated"].get<size_t>(), frames);
  const auto current = CsvTable::Read(Path("out") / "states.csv");
  const auto lagged = CsvTable::Read(Path("out") / "states_lagged.csv");
  ASSERT_TRUE(current);
  ASSERT_TRUE(lagged);
  EXPECT_EQ(current->rows(), frames);
  EXPECT_EQ(lagged->rows(), frames);
}

TEST_F(SlowEstimateProgram, AGapInTheTagsIsBridgedOnTracks) {
  Simulate("flight", {"--trajectory", "circle", "--duration", "2", "--rate", "30",
                      "--hide_tags_from", "0.8", "--hide_tags_to", "1.3"});
  const auto summary = Estimate("out", {"--dataset", "flight"});
  EXPECT_EQ(summary["frames_estimated"], summary["frames"]);
  const std::string states = ReadText(Path("out") / "states.csv");
  EXPECT_NE(states.find("predicted"), std::string::npos);
  // What the command line says goes over the configuration.
  std::string config = ReadText(kSource + "/configs/course.yaml");
  const size_t at = config.find("use_tracks: true");
  ASSERT_NE(at, std::string::npos);
  std::ofstream(Path("no_tracks.yaml")) << config.replace(at, 16, "use_tracks: false");
  Estimate("without", {"--dataset", "flight", "--config", "no_tracks.yaml"});
  Estimate("again", {"--dataset", "flight", "--config", "no_tracks.yaml", "--tracks"});
  EXPECT_NE(ReadText(Path("without") / "states.csv"), states);
  EXPECT_EQ(ReadText(Path("again") / "states.csv"), states);
  EXPECT_LT(summary["accuracy"]["optimised"]["position_rmse_m"].get<double>(), 5e-3);
}

TEST_F(EstimateProgram, SlowWrongIdsAreSurvived) {
  Simulate("flight", {"--images=false", "--duration", "3", "--wrong_id_fraction", "0.05"});
  const auto faulty = Estimate("faulty", {"--dataset", "flight", "--use_detections"});
  Simulate("clean", {"--images=false", "--duration", "3"});
  const auto clean = Estimate("clean_out", {"--dataset", "clean", "--use_detections"});
  const auto rmse = [](const nlohmann::json& s) {
    return s["accuracy"]["optimised"]["position_rmse_m"].get<double>();
  };
  EXPECT_LT(rmse(faulty), 1.3 * rmse(clean));
}

// The course's configuration with its tags listed one by one and tag `id` moved by x, y [m].
std::string CourseWithMovedTag(int id, double x, double y) {
  const std::string course = ReadText(kSource + "/configs/course.yaml");
  std::ostringstream out;
  out << course.substr(0, course.find("tag_map:")) << "tag_map:\n  tags:\n";
  const TagMap map = MakeTagMap({});
  for (const Tag& tag : map.tags()) {
    const Eigen::Vector3d p = tag.world_from_tag.translation() +
                              (tag.id == id ? Eigen::Vector3d(x, y, 0) : Eigen::Vector3d(0, 0, 0));
    out << "    - {id: " << tag.id << ", size_m: " << tag.size_m << ", position_m: [" << p.x()
        << ", " << p.y() << ", 0], rotation: [0, -1, 0, 1, 0, 0, 0, 0, 1]}\n";
  }
  return out.str();
}

TEST_F(EstimateProgram, SlowADisplacedTagIsNamedAndSurvived) {
  std::ofstream(Path("moved.yaml")) << CourseWithMovedTag(41, 0.032, 0.024);
  Simulate("moved", {"--images=false", "--trajectory", "hover", "--duration", "3", "--config",
                     "moved.yaml", "--wrong_id_fraction", "0.05"});
  Simulate("clean", {"--images=false", "--trajectory", "hover", "--duration", "3"});
  for (const std::string mode : {"--nosliding_window", "--sliding_window"}) {
    const auto clean = Estimate("clean_out", {"--dataset", "clean", "--use_detections", mode});
    const ProgramRun run =
        RunProgram(folder_.path(), "tagtwist_estimate",
                   {"--dataset", "moved", "--use_detections", "--output", "moved_out", mode});
    const std::string line = "tag 41 disagrees with the map by 40 mm in ";
    EXPECT_NE(run.err.find(line), std::string::npos) << run.err;
    EXPECT_NE(ReadText(Path("moved_out") / "report.html").find("T" + line.substr(1)),
              std::string::npos);
    const auto moved = nlohmann::json::parse(ReadText(Path("moved_out") / "summary.json"));
    EXPECT_EQ(moved["warnings"][0].get<std::string>().find(line), 0u);
    for (const char* key : {"position_rmse_m", "velocity_rmse_mps"}) {
      EXPECT_LT(moved["accuracy"]["optimised"][key].get<double>(),
                1.2 * clean["accuracy"]["optimised"][key].get<double>())
          << mode << " " << key;
    }
  }
}

// The course's map without tag 41, and one of its own that moves.
TEST_F(EstimateProgram, TagsThatTheMapLacksAreAddedAndMovableOnesPassedOver) {
  std::ofstream(Path("moved.yaml")) << CourseWithMovedTag(41, 0.032, 0.024);
  Simulate("flight", {"--images=false", "--trajectory", "hover", "--duration", "2", "--config",
                      "moved.yaml"});
  const auto all = Estimate("all", {"--dataset", "flight", "--use_detections", "--movable_tags",
                                    "41", "--map_unknown_tags"});
  EXPECT_EQ(all["movable_tags"], nlohmann::json::array({41}));
  EXPECT_EQ(all["mapping"]["added"], nlohmann::json::array());
  EXPECT_TRUE(all["warnings"].empty());
  auto known = LoadConfig(Path("all") / "map.yaml");
  ASSERT_TRUE(known) << known.error().message;
  EXPECT_EQ(known->set_up.map.Find(41), nullptr);
  fs::copy_file(Path("all") / "map.yaml", Path("known.yaml"));
  const auto added = Estimate("added", {"--dataset", "flight", "--use_detections", "--config",
                                        "known.yaml", "--map_unknown_tags"});
  ASSERT_EQ(added["mapping"]["added"].size(), 1u);
  EXPECT_EQ(added["mapping"]["added"][0]["id"], 41);
  EXPECT_LT(added["mapping"]["added"][0]["position_sigma_m"].get<double>(), 0.005);
  EXPECT_TRUE(added["warnings"].empty());
  const auto map = LoadConfig(Path("added") / "map.yaml");
  ASSERT_TRUE(map) << map.error().message;
  ASSERT_NE(map->set_up.map.Find(41), nullptr);
  const Pose& made = map->set_up.map.Find(41)->world_from_tag;
  const TagMap mat = MakeTagMap(TagGrid());
  const Pose& nominal = mat.Find(41)->world_from_tag;
  EXPECT_NEAR((made.translation() - nominal.translation()).norm(), 0.04, 0.006);
}

// The tilt over one tag seen face-on is felt only weakly: a window whose motion prior grows too
// stiff, or whose solver only overshoots, loses the attitude within seconds.
TEST_F(EstimateProgram, SlowWindowHoldsTheAttitudeOverASingleTag) {
  const std::string course = ReadText(kSource + "/configs/course.yaml");
  std::ofstream(Path("one.yaml")) << course.substr(0, course.find("tag_map:"))
                                  << "tag_map:\n  tags:\n    - {id: 54, size_m: 0.152, "
                                     "position_m: [1.9, 1.318, 0], "
                                     "rotation: [0, -1, 0, 1, 0, 0, 0, 0, 1]}\n";
  for (const std::string height : {"0.8", "1.2"}) {
    Simulate("flight" + height, {"--images=false", "--trajectory", "hover", "--height", height,
                                 "--duration", "12", "--seed", "7", "--config", "one.yaml"});
    const auto summary =
        Estimate("out" + height, {"--dataset", "flight" + height, "--config", "one.yaml",
                                  "--use_detections", "--sliding_window"});
    const auto& accuracy = summary["accuracy"]["optimised"];
    EXPECT_LT(accuracy["rotation_rmse_rad"].get<double>(), 0.03) << height;
    EXPECT_LT(accuracy["nees_mean"].get<double>(), 1.5 * 12) << height;
  }
}

TEST_F(SlowEstimateProgram, RenderedFlightIsRefinedWellBelowTheClosedForm) {
  Simulate("flight", {"--duration", "2"});
  const auto batch = Estimate("batch", {"--dataset", "flight"});
  // Corners good to hundredths of a pixel leave little for the graph to average out of positions.
  EXPECT_LT(Ratio(batch, "position_rmse_m"), 0.8);
  EXPECT_LT(batch["accuracy"]["optimised"]["position_rmse_m"].get<double>(), 1e-4);
  EXPECT_LT(Ratio(batch, "velocity_rmse_mps"), 0.25);
}

}  // namespace
}  // namespace tagtwist::internal::estimate_program_test

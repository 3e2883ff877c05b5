#include <gmock/gmock.h>

#include <cmath>
#include <map>
#include <sstream>
#include <string>

#include "frontend/io/tables/csv.h"
#include "tests/support/estimate_program.h"

namespace tagtwist::internal::bodies_program_test {
namespace {

using testing::HasSubstr;

// Two cameras that stand over the place where the boards move, one clock.
constexpr const char* kCameras = R"(
cameras:
  - name: left
    camera: {width: 640, height: 480, fx: 400, fy: 400, cx: 320, cy: 240}
    mounted_on: world
    cam_from_world: {rotation: [1, 0, 0, 0, -1, 0, 0, 0, -1], translation_m: [0.4, 0, 2.2]}
  - name: right
    camera: {width: 640, height: 480, fx: 420, fy: 420, cx: 320, cy: 240}
    mounted_on: world
    cam_from_world: {rotation: [1, 0, 0, 0, -1, 0, 0, 0, -1], translation_m: [-0.4, 0, 2.3]}
)";

std::string BoardText(const std::string& indent, int first_id) {
  std::string out = indent + "tags:\n";
  for (int i = 0; i < 4; ++i) {
    out += indent + "  - {id: " + std::to_string(first_id + i) + ", size_m: 0.12, position_m: [" +
           (i % 2 == 0 ? "-0.08" : "0.08") + ", " + (i < 2 ? "0.08" : "-0.08") + ", 0]}\n";
  }
  return out;
}

// A body that goes round and turns as it does, as TUM lines.
std::string PathText(double turns_per_s, double radius_m) {
  std::string out;
  for (int i = 0; i <= 400; ++i) {
    const double t_s = 0.01 * i, angle = 2 * M_PI * turns_per_s * t_s, round = 1.1 * t_s;
    out += std::to_string(1 + t_s) + " " + std::to_string(radius_m * std::cos(round)) + " " +
           std::to_string(radius_m * std::sin(round)) + " " +
           std::to_string(0.1 * std::sin(0.7 * t_s)) + " 0 0 " +
           std::to_string(std::sin(angle / 2)) + " " + std::to_string(std::cos(angle / 2)) + "\n";
  }
  return out;
}

// Rows of both, in the order of their stamps.
std::string Merged(const std::string& first, const std::string& second) {
  std::multimap<double, std::string> rows;
  std::string header;
  for (const std::string& text : {first, second}) {
    std::istringstream lines(text);
    std::getline(lines, header);
    for (std::string line; std::getline(lines, line);) rows.emplace(std::stod(line), line);
  }
  std::string out = header + "\n";
  for (const auto& [t_s, line] : rows) out += line + "\n";
  return out;
}

// Of a body that stands at the origin, by the sigmas of its own rows that tell of tags.
struct States {
  int n = 0;
  double position_rms_m = 0, position_nees = 0, speed_nees = 0;  // NEES a coordinate
};

States ReadStates(const fs::path& path) {
  const auto table = CsvTable::Read(path.string());
  EXPECT_TRUE(table);
  States out;
  if (!table) return out;
  const auto columns =
      table->RequireColumns({"x", "y", "z", "sigma_x", "sigma_y", "sigma_z", "vx_world", "vy_world",
                             "vz_world", "sigma_vx", "sigma_vy", "sigma_vz", "n_tags"});
  EXPECT_TRUE(columns);
  if (!columns) return out;
  for (size_t row = 0; row < table->rows(); ++row) {
    const auto value = [&](size_t i) { return table->Number(row, (*columns)[i]); };
    if (!value(0) || !(*value(12) >= 3)) continue;
    ++out.n;
    for (size_t i = 0; i < 3; ++i) {
      out.position_rms_m += *value(i) * *value(i);
      out.position_nees += std::pow(*value(i) / *value(3 + i), 2);
      out.speed_nees += std::pow(*value(6 + i) / *value(9 + i), 2);
    }
  }
  out.position_rms_m = std::sqrt(out.position_rms_m / out.n);
  out.position_nees /= 3 * out.n;
  out.speed_nees /= 3 * out.n;
  return out;
}

class BodiesProgram : public EstimateProgram {
 protected:
  // Two boards, the second at two turns a second, seen at once.
  void SetUp() override {
    const std::string bodies = std::string(kCameras) + "tag_map:\n  bodies:\n    - name: slow\n" +
                               BoardText("      ", 0) + "    - name: spinning\n" +
                               BoardText("      ", 10);
    WriteText(Path("bodies.yaml"), bodies);
    for (const bool spins : {false, true}) {
      const std::string name = spins ? "spinning" : "slow";
      WriteText(Path(name + ".yaml"),
                std::string(kCameras) + "tag_map:\n" + BoardText("  ", spins ? 10 : 0));
      WriteText(Path(name + ".tum"), PathText(spins ? 2 : 0.2, spins ? 0.3 : 0.5));
      Simulate(name, {"--config", name + ".yaml", "--trajectory", name + ".tum", "--images=false",
                      "--duration", "3", "--rate", "60", "--corner_noise_px", "0.2"});
    }
    for (const char* camera : {"left", "right"}) {
      const fs::path to = Path("both") / camera;
      fs::create_directories(to);
      for (const char* file : {"timestamps.csv", "ground_truth.csv"}) {
        if (fs::exists(Path("slow") / camera / file))
          fs::copy(Path("slow") / camera / file, to / file);
      }
      WriteText(to / "detections.csv",
                Merged(ReadText(Path("slow") / camera / "detections.csv"),
                       ReadText(Path("spinning") / camera / "detections.csv")));
    }
  }
};

TEST_F(BodiesProgram, EachBoardHasAnEstimateOfItsOwn) {
  for (const bool window : {false, true}) {
    Arguments arguments = {
        "--dataset", "both", "--config", "bodies.yaml", "--use_detections", "--write_covariance"};
    if (window) arguments.emplace_back("--sliding_window");
    const nlohmann::json summary = Estimate("results", arguments);
    ASSERT_EQ(summary["bodies"].size(), 2U);
    EXPECT_EQ(summary["bodies"][1]["name"], "spinning");
    EXPECT_EQ(summary["bodies"][1]["frames_with_state"], summary["frames"]);
    const char* rows = window ? "optimised_lagged" : "optimised";
    const double nees = summary["accuracy"][rows]["nees"]["per_dof"];
    EXPECT_GT(nees, 0.3) << rows;  // of 3 s, in which errors go together for long
    EXPECT_LT(nees, 2) << rows;
    EXPECT_LT(summary["accuracy"][rows]["position_rmse_m"], 0.003) << rows;
    EXPECT_EQ(ReadText(Path("results/states_slow.csv")), ReadText(Path("results/states.csv")));
    EXPECT_EQ(fs::exists(Path("results/states_spinning_lagged.csv")), window);
  }
}

// Of a table whose last column is a body's name, the rows of one without it, under the header.
std::string RowsOf(const std::string& body, const std::string& text) {
  std::istringstream lines(text);
  std::string out;
  for (std::string line; std::getline(lines, line);) {
    const size_t comma = line.rfind(',');
    const std::string name = line.substr(comma + 1);
    if (out.empty() ? name == "body" : name == body) out += line.substr(0, comma) + "\n";
  }
  return out;
}

TEST_F(BodiesProgram, StreamsNameEachBoard) {
  Estimate("results",
           {"--dataset", "both", "--config", "bodies.yaml", "--use_detections", "--sliding_window",
            "--publish", "csv:rows.csv", "--publish", "mcap:a.mcap"});
  const std::string rows = ReadText(Path("rows.csv")), messages = ReadText(Path("a.mcap"));
  for (const std::string name : {"slow", "spinning"}) {
    EXPECT_EQ(RowsOf(name, rows), ReadText(Path("results/states_" + name + ".csv")));
    EXPECT_THAT(messages, HasSubstr("/tagtwist/" + name + "/twist"));
    EXPECT_THAT(messages, HasSubstr("\"child_frame_id\":\"" + name + "\""));
  }
  EXPECT_THAT(messages, HasSubstr("/tagtwist/right/image"));

  std::string config = ReadText(Path("bodies.yaml"));
  config.replace(config.find("name: spinning"), 14, "name: right");
  WriteText(Path("alike.yaml"), config);
  const ProgramRun refused =
      RunProgram(folder_.path(), "tagtwist_estimate",
                 {"--dataset", "both", "--config", "alike.yaml", "--use_detections",
                  "--sliding_window", "--publish", "mcap:b.mcap"});
  EXPECT_EQ(refused.status, 1);
  EXPECT_THAT(refused.err, HasSubstr("bodies: right is what another body, a camera"));
  EXPECT_FALSE(fs::exists(Path("b.mcap")));
}

TEST_F(BodiesProgram, SlowOneBoardOfSeveralIsWhatItIsAlone) {
  Estimate("results", {"--dataset", "both", "--config", "bodies.yaml", "--use_detections"});
  Estimate("alone", {"--dataset", "spinning", "--config", "spinning.yaml", "--use_detections"});
  EXPECT_EQ(ReadText(Path("results/states_spinning.csv")), ReadText(Path("alone/states.csv")));
}

TEST_F(BodiesProgram, ABoardThatAMovingCameraSeesIsPutIntoTheWorld) {
  // Of the mat's tags four are taken to be a board of their own, which therefore stands still.
  std::string tags, board;
  for (int id = 0; id < 108; ++id) {
    const std::string line = "{id: " + std::to_string(id) + ", size_m: 0.15, position_m: [" +
                             std::to_string(0.3 * (id % 12)) + ", " +
                             std::to_string(0.3 * (id / 12)) + ", 0]}\n";
    const bool is_of_board = id % 12 >= 4 && id % 12 <= 5 && id / 12 >= 3 && id / 12 <= 4;
    (is_of_board ? board : tags) += (is_of_board ? "        - " : "    - ") + line;
  }
  std::string all = board;
  for (size_t at = 0; (at = all.find("        - ", at)) != std::string::npos;) all.erase(at, 4);
  WriteText(Path("mat.yaml"), "tag_map:\n  tags:\n" + tags + all);
  WriteText(Path("carried.yaml"),
            "tag_map:\n  tags:\n" + tags + "  bodies:\n    - name: board\n      tags:\n" + board);
  Simulate("flight", {"--config", "mat.yaml", "--images=false", "--duration", "6", "--rate", "30",
                      "--corner_noise_px", "0.2"});
  for (const bool window : {false, true}) {
    Arguments arguments = {"--dataset", "flight", "--config", "carried.yaml", "--use_detections"};
    if (window) {
      arguments.insert(arguments.end(), {"--sliding_window", "--publish", "csv:rows.csv"});
    }
    const nlohmann::json summary = Estimate("results", arguments);
    ASSERT_EQ(summary["bodies"].size(), 1U);
    const States states =
        ReadStates(Path("results") / (window ? "states_board_lagged.csv" : "states_board.csv"));
    ASSERT_GT(states.n, 30);
    EXPECT_LT(states.position_rms_m, 0.02);
    EXPECT_GT(states.position_nees, 0.4);
    EXPECT_LT(states.position_nees, 1.8);
    EXPECT_LT(states.speed_nees, 1.8);
  }
  EXPECT_EQ(RowsOf("board", ReadText(Path("rows.csv"))),
            ReadText(Path("results/states_board.csv")));
}

TEST_F(BodiesProgram, SlowFilesOfBodiesThatAnOlderRunHadGo) {
  Estimate("results", {"--dataset", "both", "--config", "bodies.yaml", "--use_detections"});
  WriteText(Path("results/states_mine.csv"), "a person's\n");
  Estimate("results", {"--dataset", "slow", "--config", "slow.yaml", "--use_detections"});
  EXPECT_FALSE(fs::exists(Path("results/states_spinning.csv")));
  EXPECT_FALSE(fs::exists(Path("results/optimised_slow.tum")));
  EXPECT_TRUE(fs::exists(Path("results/states_mine.csv")));
  EXPECT_TRUE(fs::exists(Path("results/states.csv")));
}

TEST_F(BodiesProgram, WhatNeedsACameraThatMovesIsRefused) {
  for (const char* flag : {"--calibrate", "--map_unknown_tags", "--write_detections"}) {
    const ProgramRun run =
        RunProgram(folder_.path(), "tagtwist_estimate",
                   {"--dataset", "both", "--config", "bodies.yaml", "--use_detections", flag});
    EXPECT_EQ(run.status, 1) << flag;
    EXPECT_THAT(run.err, HasSubstr(std::string(flag) + " is of ")) << flag;
    EXPECT_TRUE(IsOneLine(run.err)) << run.err;
  }
}

}  // namespace
}  // namespace tagtwist::internal::bodies_program_test

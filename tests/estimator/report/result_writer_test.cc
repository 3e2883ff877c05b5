#include "estimator/report/result_writer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <set>

#include "estimator/report/files/result_reader.h"
#include "estimator/report/files/states_csv.h"
#include "estimator/report/files/summary_json.h"
#include "estimator/report/result_rows.h"
#include "frontend/io/tables/csv.h"
#include "frontend/io/trajectories/trajectory_file.h"
#include "tests/support/flights/synthetic_estimate.h"
#include "tests/support/test_files.h"

namespace tagtwist::internal::result_writer_test {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::UnorderedElementsAre;

constexpr size_t kFrames = 90;

ResultContext Context(const Estimate& estimate, bool truth = true) {
  ResultContext c;
  c.facts = SyntheticFacts("flights/<figure8>", estimate.frames.size());
  c.map = MakeTagMap(TagGrid());
  if (truth) c.truth = SmoothTruth(5, 100);
  c.rows = CompareMethods(estimate, c.truth, {});
  return c;
}

std::set<std::string> Names(const fs::path& folder) {
  std::set<std::string> out;
  for (const auto& entry : fs::directory_iterator(folder)) out.insert(entry.path().filename());
  return out;
}

TEST(ResultWriter, BatchWritesTheDesignedFiles) {
  const TempFolder temp;
  const Estimate estimate = SyntheticEstimate(kFrames, false);
  ResultContext context = Context(estimate);
  context.write_covariance = true;
  ASSERT_TRUE(WriteResults(temp / "out", estimate, context));
  EXPECT_THAT(Names(temp / "out"),
              UnorderedElementsAre("closed_form.tum", "optimised.tum", "states.csv",
                                   "ground_truth.tum", "ground_truth_states.csv", "summary.json",
                                   "report.html", "covariance.csv"));
  EXPECT_THAT(Names(temp.path()), UnorderedElementsAre("out"));
  auto summary = nlohmann::ordered_json::parse(ReadText(temp / "out/summary.json"));
  EXPECT_THAT(summary["verdict"].get<std::string>(), testing::HasSubstr("too short to judge"));
  summary.erase("verdict");
  ASSERT_FALSE(summary["findings"].empty());
  EXPECT_FALSE(summary["findings"][0]["fact"].get<std::string>().empty());
  summary.erase("findings");
  EXPECT_EQ(FormatJson(summary), FormatJson(SummaryJson(estimate, context.rows, context.facts)));
}

TEST(ResultWriter, FilesOfAnEarlierRunThatThisOneLacksAreRemoved) {
  const TempFolder temp;
  const Estimate window = SyntheticEstimate(kFrames, true),
                 batch = SyntheticEstimate(kFrames, false);
  ResultContext context = Context(window);
  context.write_covariance = true;
  WriteText(temp / "notes.txt", "mine");
  WriteText(temp / "ground_truth.csv", "of a data set");
  ASSERT_TRUE(WriteResults(temp.path(), window, context));
  EXPECT_TRUE(fs::exists(temp / "states_lagged.csv"));
  EXPECT_TRUE(fs::exists(temp / "covariance_lagged.csv"));
  ASSERT_TRUE(WriteResults(temp.path(), batch, Context(batch, false)));
  EXPECT_THAT(Names(temp.path()),
              UnorderedElementsAre("closed_form.tum", "optimised.tum", "states.csv", "summary.json",
                                   "report.html", "notes.txt", "ground_truth.csv"));
  EXPECT_EQ(ReadText(temp / "ground_truth.csv"), "of a data set");
}

TEST(ResultWriter, AFileThatCannotBeWrittenLeavesTheFolderAsItWas) {
  const TempFolder temp;
  const Estimate estimate = SyntheticEstimate(kFrames, false);
  WriteText(temp / "states.csv", "old");
  fs::create_directory(temp / "report.html");
  const auto written = WriteResults(temp.path(), estimate, Context(estimate));
  ASSERT_FALSE(written);
  EXPECT_EQ(written.error().message,
            temp / "report.html" + ": cannot write: is a folder, expected a file");
  EXPECT_EQ(ReadText(temp / "states.csv"), "old");
  EXPECT_THAT(Names(temp.path()), UnorderedElementsAre("states.csv", "report.html"));
}

TEST(ResultWriter, SameEstimateSameBytes) {
  const TempFolder temp;
  const Estimate estimate = SyntheticEstimate(kFrames, true);
  ASSERT_TRUE(WriteResults(temp / "a", estimate, Context(estimate)));
  ASSERT_TRUE(WriteResults(temp / "b", estimate, Context(estimate)));
  for (const std::string& name : Names(temp / "a")) {
    EXPECT_EQ(ReadText(temp / "a/" + name), ReadText(temp / "b/" + name)) << name;
  }
}

TEST(ResultRows, WrittenAsTheyComeAreTheSameBytes) {
  const TempFolder temp;
  const Estimate estimate = SyntheticEstimate(kFrames, true);
  ResultContext context = Context(estimate);
  context.write_covariance = true;
  ASSERT_TRUE(WriteResults(temp / "whole", estimate, context));
  auto rows = ResultRows::Begin(temp / "rows", {true, false, {""}});
  ASSERT_TRUE(rows);
  for (size_t i = 0; i < kFrames; ++i) {  // the lag is some frames
    ASSERT_TRUE((*rows)->Add(0, estimate.frames[i]));
    if (i >= 5) {
      ASSERT_TRUE((*rows)->AddLagged(0, estimate.lagged[i - 5]));
    }
  }
  for (size_t i = kFrames - 5; i < kFrames; ++i) {
    ASSERT_TRUE((*rows)->AddLagged(0, estimate.lagged[i]));
  }
  EXPECT_FALSE(fs::exists(temp / "rows"));
  ASSERT_TRUE(WriteResults(temp / "rows", std::move(*rows), estimate, context));
  EXPECT_EQ(Names(temp / "rows"), Names(temp / "whole"));
  for (const std::string& name : Names(temp / "whole")) {
    EXPECT_EQ(ReadText(temp / "whole/" + name), ReadText(temp / "rows/" + name)) << name;
  }
}

TEST(ResultRows, OfARunThatEndsBeforeLeaveWhatWasThere) {
  const TempFolder temp;
  fs::create_directory(temp / "out");
  WriteText(temp / "out/states.csv", "older");
  {
    auto rows = ResultRows::Begin(temp / "out", {false, true, {"", "drone"}});
    ASSERT_TRUE(rows);
    ASSERT_TRUE((*rows)->Add(1, FrameEstimate()));
  }
  EXPECT_THAT(Names(temp / "out"), UnorderedElementsAre("states.csv"));
  EXPECT_EQ(ReadText(temp / "out/states.csv"), "older");
}

TEST(ResultRows, ThatCannotBeWrittenAreTold) {
  const TempFolder temp;
  auto rows = ResultRows::Begin(temp / "out", {false, false, {""}});
  ASSERT_TRUE(rows);
  ASSERT_TRUE((*rows)->set().Add("states_lagged.csv", "in the way"));
  const Status told = (*rows)->AddLagged(0, FrameEstimate());
  ASSERT_FALSE(told);
  EXPECT_EQ(told.error().message, temp / "out/states_lagged.csv" + ": cannot write: File exists");
  EXPECT_FALSE((*rows)->Add(0, FrameEstimate()));
}

TEST(ResultWriter, TumFilesReadBack) {
  const TempFolder temp;
  const Estimate estimate = SyntheticEstimate(kFrames, true);
  ASSERT_TRUE(WriteResults(temp / "out", estimate, Context(estimate)));
  const auto optimised = ReadGroundTruth(temp / "out/optimised.tum");
  ASSERT_TRUE(optimised);
  ASSERT_EQ(optimised->size(), kFrames - 2) << "frames without a state are left out";
  const FrameEstimate& last = estimate.frames.back();
  EXPECT_EQ(optimised->back().t_ns, last.t_ns);
  EXPECT_LT(
      (optimised->back().world_from_body.translation() - last.state.world_from_body.translation())
          .norm(),
      1e-12);
  for (const TruthSample& s : *optimised) EXPECT_GE(s.world_from_body.params(3), 0);
  const auto closed_form = ReadGroundTruth(temp / "out/closed_form.tum");
  ASSERT_TRUE(closed_form);
  EXPECT_EQ(closed_form->size(),
            ClosedFormSeries(estimate.frames, ClosedFormVariant::kPlain).size());
  const auto truth = ReadGroundTruth(temp / "out/ground_truth_states.csv");
  ASSERT_TRUE(truth);
  EXPECT_EQ(truth->size(), 501u);
  EXPECT_TRUE(truth->front().twist);
  const auto poses = ReadGroundTruth(temp / "out/ground_truth.tum");
  ASSERT_TRUE(poses);
  EXPECT_EQ(poses->size(), 501u);
}

TEST(StatesCsv, HasTheDesignedColumns) {
  const auto table = CsvTable::Parse(FormatStatesCsv(SyntheticEstimate(3, false).frames), "x");
  ASSERT_TRUE(table);
  EXPECT_THAT(
      table->columns(),
      ElementsAre("t", "x", "y", "z", "qx", "qy", "qz", "qw", "vx_world", "vy_world", "vz_world",
                  "wx_body", "wy_body", "wz_body", "cf_x", "cf_y", "cf_z", "cf_qx", "cf_qy",
                  "cf_qz", "cf_qw", "cf_vx_world", "cf_vy_world", "cf_vz_world", "cf_wx_body",
                  "cf_wy_body", "cf_wz_body", "sigma_rx", "sigma_ry", "sigma_rz", "sigma_x",
                  "sigma_y", "sigma_z", "sigma_vx", "sigma_vy", "sigma_vz", "sigma_wx", "sigma_wy",
                  "sigma_wz", "n_tags", "n_tracks", "status"));
}

TEST(StatesCsv, FrameWithoutAStateHasEmptyCells) {
  FrameEstimate frame;
  frame.t_ns = 1'499'735'676'510'662'000;
  frame.n_tracks = 4;
  const std::string text = FormatStatesCsv({frame});
  const std::string row = text.substr(text.find('\n') + 1);
  EXPECT_EQ(row, "1499735676.510662000" + std::string(39, ',') + "0,4,no_fix\n");
}

TEST(StatesCsv, StatesClosedFormAndSigmasReadBack) {
  const TempFolder temp;
  const Estimate estimate = SyntheticEstimate(kFrames, true);
  WriteText(temp / "states.csv", FormatStatesCsv(estimate.frames));
  const auto read = ReadStatesCsv(temp / "states.csv");
  ASSERT_TRUE(read) << read.error().message;
  const PoseSeries states = EstimatedSeries(estimate.frames);
  const PoseSeries closed = ClosedFormSeries(estimate.frames, ClosedFormVariant::kLowPass);
  ASSERT_EQ(read->states.size(), states.size());
  ASSERT_EQ(read->closed_form.size(), closed.size());
  ASSERT_EQ(read->sigmas.size(), states.size());
  const auto near = [](const PoseSample& a, const PoseSample& b) {
    EXPECT_EQ(a.t_ns, b.t_ns);
    ASSERT_EQ(a.twist.has_value(), b.twist.has_value());
    const StateVector d = Difference(BodyState{a.world_from_body, a.twist.value_or(Twist())},
                                     {b.world_from_body, b.twist.value_or(Twist())});
    EXPECT_LT(d.norm(), 1e-8);
  };
  for (size_t i = 0; i < states.size(); ++i) {
    near(read->states[i], states[i]);
    const StateVector sigma = states[i].covariance->diagonal().cwiseSqrt();
    EXPECT_LT((read->sigmas[i] - sigma).norm(), 1e-6 * sigma.norm());
  }
  for (size_t i = 0; i < closed.size(); ++i) near(read->closed_form[i], closed[i]);
}

TEST(StatesCsv, BadFilesAreRefusedNamingLineAndColumn) {
  const TempFolder temp;
  const std::string good = FormatStatesCsv(SyntheticEstimate(4, false).frames);
  const auto message = [&](const std::string& text) {
    WriteText(temp / "states.csv", text);
    const auto read = ReadStatesCsv(temp / "states.csv");
    return read ? std::string("read") : read.error().message.substr((temp / "").size());
  };
  EXPECT_EQ(message(good), "read");
  std::string bad = good;
  bad.replace(bad.find("vx_world"), 8, "vx_wrld_");
  EXPECT_EQ(message(bad), "states.csv:1: missing column 'vx_world'");
  bad = good;
  const size_t second = bad.find('\n', bad.find('\n') + 1) + 1;
  bad.replace(second, bad.find(',', second) - second, "0.1");
  EXPECT_EQ(message(bad), "states.csv:3: t: expected stamps that grow, got one that does not");
  bad = good;
  bad.insert(bad.find(',', bad.find('\n')) + 1, "nan");
  EXPECT_THAT(message(bad), ::testing::StartsWith("states.csv:2: x: expected a finite number"));
}

TEST(CovarianceCsv, ReadsBackAndGivesTheSameNees) {
  const TempFolder temp;
  const Estimate estimate = SyntheticEstimate(kFrames, true);
  ResultContext context = Context(estimate);
  context.write_covariance = true;
  ASSERT_TRUE(WriteResults(temp / "out", estimate, context));
  const auto table = CsvTable::Read(temp / "out/covariance.csv");
  ASSERT_TRUE(table);
  EXPECT_EQ(table->columns().size(), 79u);
  EXPECT_EQ(table->columns()[2], "rx_ry");
  EXPECT_EQ(table->rows(), kFrames - 2);
  const auto read = ReadResultsAt(temp / "out");
  ASSERT_TRUE(read) << read.error().message;
  ASSERT_EQ(read->series.size(), 3u);
  EXPECT_EQ(read->series[1].name, temp / "out" + ": optimised, lag 0");
  const auto accuracy = Evaluate(read->series[1].series, read->truth, {});
  ASSERT_TRUE(accuracy && accuracy->nees);
  const Accuracy& written = *context.rows[3].accuracy;
  EXPECT_NEAR(accuracy->nees->mean, written.nees->mean, 1e-5);
  EXPECT_NEAR(accuracy->velocity_mps->rmse, written.velocity_mps->rmse, 1e-9);
  EXPECT_NEAR(accuracy->position_m.rmse, written.position_m.rmse, 1e-9);
}

TEST(CovarianceCsv, WithoutItThereIsNoNees) {
  const TempFolder temp;
  const Estimate estimate = SyntheticEstimate(kFrames, false);
  ASSERT_TRUE(WriteResults(temp / "out", estimate, Context(estimate)));
  const auto read = ReadResultsAt(temp / "out/states.csv");
  ASSERT_TRUE(read);
  const auto accuracy = Evaluate(read->series[0].series, read->truth, {});
  ASSERT_TRUE(accuracy);
  EXPECT_FALSE(accuracy->nees || accuracy->nees_pose || accuracy->nees_twist);
}

}  // namespace
}  // namespace tagtwist::internal::result_writer_test

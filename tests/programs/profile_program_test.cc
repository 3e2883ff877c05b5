// tagtwist_estimate --profile, as it is run, and the recorder behind it.
#include <gtest/gtest.h>

#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <thread>

#include "apps/support/trace_recorder.h"
#include "tests/support/program_test_util.h"
#include "tests/support/temp_folder.h"
#include "tests/support/test_files.h"

namespace tagtwist::internal::profile_program_test {
namespace {

using nlohmann::json;
using Arguments = std::vector<std::string>;

std::vector<json> SpansOf(const json& trace) {
  std::vector<json> out;
  for (const json& event : trace.at("traceEvents")) {
    if (event.at("ph") == "X") out.push_back(event);
  }
  return out;
}

std::set<std::string> NamesOf(const std::vector<json>& spans) {
  std::set<std::string> out;
  for (const json& span : spans) out.insert(span.at("name").get<std::string>());
  return out;
}

// Those of a thread are beside or within one another.
void ExpectNested(const std::vector<json>& spans) {
  constexpr double kRoundingUs = 1e-6;
  std::map<int, std::vector<double>> ends;  // of what is open on each thread
  for (const json& span : spans) {
    const double begin = span.at("ts"), end = begin + span.at("dur").get<double>();
    EXPECT_GE(begin, 0);
    auto& open = ends[span.at("tid")];
    while (!open.empty() && open.back() <= begin + kRoundingUs) open.pop_back();
    if (!open.empty()) {
      EXPECT_LE(end, open.back() + kRoundingUs) << span;
    }
    open.push_back(end);
  }
}

TEST(TraceRecorder, SpansHaveTheirBeginningsLengthsAndThreads) {
  int64_t now_ns = 1'000'000;
  TraceRecorder recorder([&] { return now_ns; });
  {
    const Span outer(&recorder, "outer");
    now_ns += 1500;
    std::thread([&] {
      const Span other(&recorder, "other");
      now_ns += 2000;
    }).join();
    const Span inner(&recorder, "inner");
    now_ns += 250;
  }
  const auto spans = SpansOf(json::parse(recorder.Json()));
  ASSERT_EQ(spans.size(), 3u);
  EXPECT_EQ(spans[0].dump(), R"({"dur":3.75,"name":"outer","ph":"X","pid":1,"tid":1,"ts":0.0})");
  EXPECT_EQ(spans[1].dump(), R"({"dur":2.0,"name":"other","ph":"X","pid":1,"tid":2,"ts":1.5})");
  EXPECT_EQ(spans[2].dump(), R"({"dur":0.25,"name":"inner","ph":"X","pid":1,"tid":1,"ts":3.5})");
}

TEST(TraceRecorder, AThreadTakesTheLaneOfOneThatIsDone) {
  TraceRecorder recorder([] { return int64_t{0}; });
  const Span run(&recorder, "run");
  for (int i = 0; i < 3; ++i) {
    std::thread([&] { const Span work(&recorder, "work"); }).join();
  }
  const auto spans = SpansOf(json::parse(recorder.Json()));
  ASSERT_EQ(spans.size(), 3u);  // the one that is open has no length yet
  for (const json& span : spans) EXPECT_EQ(span.at("tid"), 2);
}

class ProfileProgram : public testing::Test {
 protected:
  void SetUp() override { MakeRecording(folder_.path(), "rec", DatasetFormat::kFolder, true); }
  ProgramRun Estimate(const Arguments& more) const {
    Arguments arguments = {"--dataset", "rec", "--output", "out"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return RunProgram(folder_.path(), "tagtwist_estimate", arguments);
  }
  TempFolder folder_;
};

TEST_F(ProfileProgram, HasTheStagesOfBatchAndWindow) {
  const std::set<std::string> both = {"run",   "estimate",    "frame", "read",         "detect",
                                      "track", "closed form", "solve", "write results"};
  for (const bool window : {false, true}) {
    Arguments arguments = {"--profile", "trace.json", "--threads", "2"};
    if (window) arguments.emplace_back("--sliding_window");
    const ProgramRun run = Estimate(arguments);
    ASSERT_EQ(run.status, 0) << run.err;
    const auto spans = SpansOf(json::parse(ReadText(folder_ / "trace.json")));
    std::set<std::string> expected = both;
    if (!window) expected.insert({"start", "covariance", "rows"});
    EXPECT_EQ(NamesOf(spans), expected);
    ExpectNested(spans);
  }
}

TEST_F(ProfileProgram, ChangesNothingElse) {
  ASSERT_EQ(Estimate({}).status, 0);
  const std::string plain = ReadText(folder_ / "out/states.csv");
  ASSERT_EQ(Estimate({"--profile", "trace.json"}).status, 0);
  EXPECT_EQ(ReadText(folder_ / "out/states.csv"), plain);
}

TEST_F(ProfileProgram, WrongPlacesAreRefusedAtOnce) {
  for (const char* place : {"missing/trace.json", "rec/ground_truth.csv"}) {
    const ProgramRun run = Estimate({"--profile", place});
    EXPECT_EQ(run.status, 1) << place;
    EXPECT_TRUE(IsOneLine(run.err)) << run.err;
    EXPECT_NE(run.err.find(place), std::string::npos) << run.err;
    EXPECT_TRUE(HasNoResults(folder_ / "out"));
  }
}

}  // namespace
}  // namespace tagtwist::internal::profile_program_test

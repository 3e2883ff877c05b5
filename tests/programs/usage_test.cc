#include "apps/support/usage.h"

#include <gflags/gflags.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "apps/support/man_page.h"
#include "estimator/jobs/progress.h"

DEFINE_double(ut_rate, 49, "Frames a second.");
DEFINE_int32(ut_threads, 1, "Threads.");
DEFINE_bool(ut_images, true, "Render images.");
DEFINE_bool(ut_window, false, "Sliding window.");
DEFINE_string(ut_output, "", "Folder to write.");
DEFINE_validator(ut_threads, [](const char*, int value) { return value >= 1; });

namespace tagtwist::internal::usage_test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

Usage TestUsage(int max_arguments = 0) {
  return {
      "prog", "--ut_output PATH", "Does it.", {{"Input", {"ut_rate", "ut_images"}}}, max_arguments};
}

ParsedCommandLine Parse(std::vector<const char*> arguments, int max_arguments = 0) {
  arguments.insert(arguments.begin(), "prog");
  return ParseCommandLine(static_cast<int>(arguments.size()), arguments.data(),
                          TestUsage(max_arguments));
}

class UsageTest : public ::testing::Test {
  gflags::FlagSaver saver_;
};

TEST_F(UsageTest, ReadsEveryFormOfFlag) {
  const auto parsed = Parse({"--ut_rate=20", "-ut_output", "a b", "--nout_images", "--ut_window"});
  EXPECT_FALSE(parsed.exit_status) << parsed.text;
  EXPECT_EQ(FLAGS_ut_rate, 20);
  EXPECT_EQ(FLAGS_ut_output, "a b");
  EXPECT_FALSE(FLAGS_ut_images);
  EXPECT_TRUE(FLAGS_ut_window);
}

TEST_F(UsageTest, BooleanDoesNotSwallowTheNextArgument) {
  const auto parsed = Parse({"--ut_window", "DIR", "--", "--ut_window=false"}, 2);
  EXPECT_THAT(parsed.arguments, ElementsAre("DIR", "--ut_window=false"));
  EXPECT_TRUE(FLAGS_ut_window);
}

TEST_F(UsageTest, WrongUsageIsStatus2InOneLine) {
  const std::vector<std::pair<std::vector<const char*>, const char*>> cases = {
      {{"--nonsense"}, "unknown flag --nonsense"},
      {{"--nout_rate"}, "unknown flag --nout_rate"},
      {{"--flagfile=x"}, "unknown flag --flagfile"},
      {{"--ut_rate=fast"}, "--ut_rate: bad value 'fast'"},
      {{"--ut_threads=0"}, "--ut_threads: bad value '0'"},
      {{"--ut_images=maybe"}, "--ut_images: bad value 'maybe'"},
      {{"--ut_output"}, "--ut_output: expected a value"},
      {{"stray"}, "unexpected argument 'stray'"},
  };
  for (const auto& [arguments, message] : cases) {
    const auto parsed = Parse(arguments);
    EXPECT_EQ(parsed.exit_status, 2) << message;
    EXPECT_THAT(parsed.text, HasSubstr("prog: " + std::string(message)));
    EXPECT_EQ(std::count(parsed.text.begin(), parsed.text.end(), '\n'), 1) << parsed.text;
  }
}

TEST_F(UsageTest, HelpAndVersionEndWithStatus0) {
  const auto help = Parse({"--ut_rate=1", "--help"});
  EXPECT_EQ(help.exit_status, 0);
  EXPECT_THAT(help.text, HasSubstr("--ut_rate NUMBER"));
  EXPECT_THAT(help.text, HasSubstr("Frames a second. [49]"));
  EXPECT_THAT(help.text, HasSubstr("--ut_images=false"));
  const auto version = Parse({"--version"});
  EXPECT_EQ(version.exit_status, 0);
  EXPECT_THAT(version.text, ::testing::MatchesRegex("prog [0-9.]+\n"));
}

TEST_F(UsageTest, ManPageSaysWhatHelpSays) {
  Usage usage = TestUsage();
  usage.examples = {{"Slowly", "prog --ut_rate 1"}, {"A line that begins as a request", ".x"}};
  const std::string page = ManPage(usage, "1.2");
  EXPECT_THAT(page, HasSubstr(".TH PROG 1 \"\" \"tagtwist 1.2\""));
  EXPECT_THAT(page, HasSubstr(".SH NAME\nprog \\- does it\n"));
  EXPECT_THAT(page, HasSubstr(".SS Input\n.TP\n.B \\-\\-ut_rate NUMBER\nFrames a second. [49]\n"));
  EXPECT_THAT(page, HasSubstr("Slowly:\n.PP\n.RS\n.nf\nprog \\-\\-ut_rate 1\n"));
  EXPECT_THAT(page, HasSubstr("\n\\&.x\n"));
  EXPECT_THAT(HelpText(usage), HasSubstr("  Slowly:\n    prog --ut_rate 1\n"));
  const auto asked = Parse({"--man"});
  EXPECT_EQ(asked.exit_status, 0);
  EXPECT_THAT(asked.text, HasSubstr(".TH PROG 1"));
}

TEST(Progress, LineTellsShareAndTimeLeft) {
  EXPECT_EQ(ProgressLine("render", 10, 40, 2.0),
            "render [#######.......................]  25%  10/40  6 s left");
  EXPECT_EQ(ProgressLine("render", 40, 40, 2.0),
            "render [##############################] 100%  40/40");
  EXPECT_EQ(ProgressLine("read", 7, 0, 2.0), "read  7");
}

}  // namespace
}  // namespace tagtwist::internal::usage_test

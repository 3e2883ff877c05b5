#include "frontend/base/files/input_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <chrono>
#include <csignal>
#include <thread>

#include "tests/support/test_files.h"

namespace tagtwist::internal::input_file_test {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

std::string Fault(const std::string& path, const Limits& limits = {}) {
  const auto text = ReadWholeFile(path, limits);
  return text ? "read: " + text->substr(0, 20) : text.error().message;
}

TEST(InputFile, ReadsWhatIsThere) {
  const TempFolder temp;
  const std::string bytes("a\0\nb", 4);
  WriteText(temp / "file", bytes);
  EXPECT_EQ(*ReadWholeFile(temp / "file"), bytes);
  EXPECT_THAT(Fault("/proc/self/status"), StartsWith("read: ")) << "a file that says it is empty";
}

TEST(InputFile, APipeIsReadToItsEnd) {
  const TempFolder temp;
  const std::string pipe = temp / "pipe", text(300'000, 'x');
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  std::thread writer([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    WriteText(pipe, text);
  });
  const auto read = ReadWholeFile(pipe);
  writer.join();
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(*read, text);
}

TEST(InputFile, NothingIsWaitedForWithoutEnd) {
  const TempFolder temp;
  const std::string pipe = temp / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  const auto began = std::chrono::steady_clock::now();
  EXPECT_EQ(Fault(pipe), "read: ") << "no writer: an empty pipe";
  Limits hasty;
  hasty.pipe_idle_s = 0.3;
  std::thread writer([&] {
    std::ofstream out(pipe);
    std::this_thread::sleep_for(std::chrono::milliseconds(900));
  });
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  EXPECT_EQ(Fault(pipe, hasty), pipe + ": is a pipe, and nothing comes out of it");
  writer.join();
  EXPECT_LT(std::chrono::steady_clock::now() - began, std::chrono::seconds(4));
}

TEST(InputFile, LimitsAreKept) {
  const TempFolder temp;
  WriteText(temp / "file", std::string(3'000'001, 'x'));
  Limits limits;
  limits.file_bytes = 3'000'000;
  EXPECT_EQ(Fault(temp / "file", limits),
            (temp / "file") + ": is larger than 3 MB (--limits file_bytes=N raises that)");
  limits.file_bytes *= 2;
  EXPECT_THAT(Fault(temp / "file", limits), StartsWith("read: "));
  const std::string pipe = temp / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  limits = {};
  limits.pipe_bytes = 2'000'000;
  std::signal(SIGPIPE, SIG_IGN);  // the reader goes away
  std::thread writer([&] { WriteText(pipe, std::string(2'100'000, 'x')); });
  EXPECT_EQ(Fault(pipe, limits),
            pipe + ": is larger than 2 MB (--limits pipe_bytes=N raises that)");
  writer.join();
}

TEST(InputFile, DevicesAndFoldersAreNoFiles) {
  const TempFolder temp;
  EXPECT_EQ(Fault("/dev/zero"), "/dev/zero: expected a file, got a device");
  EXPECT_EQ(Fault(temp.path()), temp.path() + ": expected a file, got a folder");
  EXPECT_FALSE(CheckRegularFile("/dev/null"));
  EXPECT_TRUE(CheckRegularFile(temp / "absent"));
}

TEST(InputFile, FirstBytesTakeNothingFromAPipe) {
  const TempFolder temp;
  WriteText(temp / "file", "abc");
  EXPECT_EQ(FirstBytes(temp / "file", 2), "ab");
  EXPECT_EQ(FirstBytes(temp / "file", 20), "abc");
  ASSERT_EQ(::mkfifo((temp / "pipe").c_str(), 0600), 0);
  EXPECT_EQ(FirstBytes(temp / "pipe", 2), "");
}

}  // namespace
}  // namespace tagtwist::internal::input_file_test

#include "frontend/base/files/atomic_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>

#include "frontend/base/files/input_file.h"
#include "tests/support/temp_folder.h"

namespace tagtwist::internal::atomic_file_test {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

TEST(AtomicFile, WritesAndReplaces) {
  const TempFolder folder;
  const std::string path = folder / "a.csv";
  const std::string zeros(200000, '\0');
  ASSERT_TRUE(WriteFileAtomically(path, "old\n"));
  ASSERT_TRUE(WriteFileAtomically(path, zeros + "new\n"));
  const auto content = ReadWholeFile(path);
  ASSERT_TRUE(content);
  EXPECT_EQ(*content, zeros + "new\n");
  EXPECT_EQ(folder.CountEntries(), 1u) << "a temporary file is left";
}

TEST(AtomicFile, ObeysUmask) {
  const TempFolder folder;
  const std::string path = folder / "a.csv";
  const mode_t before = ::umask(027);
  EXPECT_TRUE(WriteFileAtomically(path, "x"));
  ::umask(before);
  struct stat info = {};
  ASSERT_EQ(::stat(path.c_str(), &info), 0);
  EXPECT_EQ(info.st_mode & 0777u, 0640u);
}

TEST(AtomicFile, NamesPathAndFault) {
  const TempFolder folder;
  const auto no_folder = WriteFileAtomically(folder / "none/a.csv", "x");
  ASSERT_FALSE(no_folder);
  EXPECT_EQ(no_folder.error().message,
            folder / "none/a.csv: cannot write: No such file or directory");
  const auto onto_folder = WriteFileAtomically(folder.path(), "x");
  ASSERT_FALSE(onto_folder);
  EXPECT_THAT(onto_folder.error().message, StartsWith(folder.path() + ": cannot write: "));
  EXPECT_TRUE(std::filesystem::is_directory(folder.path()));
}

TEST(AtomicFile, FullDeviceIsAnErrorAndNeverReplaced) {
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "no /dev/full here";
  const auto full = WriteFileAtomically("/dev/full", "x");
  ASSERT_FALSE(full);
  EXPECT_THAT(full.error().message, HasSubstr("/dev/full: cannot write: No space left"));
  EXPECT_TRUE(std::filesystem::is_character_file("/dev/full"));
}

TEST(AtomicFile, ReadNamesMissingFileAndFolder) {
  const TempFolder folder;
  const auto missing = ReadWholeFile(folder / "none");
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().message, folder / "none: cannot open: No such file or directory");
  const auto onto_folder = ReadWholeFile(folder.path());
  ASSERT_FALSE(onto_folder);
  EXPECT_EQ(onto_folder.error().message, folder.path() + ": expected a file, got a folder");
}

}  // namespace
}  // namespace tagtwist::internal::atomic_file_test

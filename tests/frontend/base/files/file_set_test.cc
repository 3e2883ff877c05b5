#include "frontend/base/files/file_set.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>

#include "frontend/base/files/made_folders.h"
#include "tests/support/test_files.h"

namespace tagtwist::internal::file_set_test {
namespace {

namespace fs = std::filesystem;

size_t CountEntries(const fs::path& folder) {
  return static_cast<size_t>(std::distance(fs::directory_iterator(folder), {}));
}

TEST(FileSet, AppearsAsAWholeWithItsParents) {
  const TempFolder temp;
  const std::string folder = temp / "a/b/out";
  auto set = FileSet::Begin(folder);
  ASSERT_TRUE(set) << set.error().message;
  ASSERT_TRUE((*set)->Add("one.csv", "1"));
  ASSERT_TRUE((*set)->Add("two.csv", "2"));
  EXPECT_FALSE(fs::exists(folder));
  ASSERT_TRUE((*set)->Commit());
  set->reset();
  EXPECT_EQ(ReadText(folder + "/one.csv"), "1");
  EXPECT_EQ(ReadText(folder + "/two.csv"), "2");
  EXPECT_EQ(CountEntries(folder), 2u);
  EXPECT_EQ(CountEntries(temp / "a/b"), 1u);
}

TEST(FileSet, WithoutCommitLeavesNoTrace) {
  const TempFolder temp;
  {
    auto set = FileSet::Begin(temp / "a/b/out/");
    ASSERT_TRUE(set);
    ASSERT_TRUE((*set)->Add("one.csv", "1"));
  }
  EXPECT_EQ(CountEntries(temp.path()), 0u);
}

TEST(FileSet, ANameThatCannotBeLookedAtIsAnErrorAndNoException) {
  const TempFolder temp;
  WriteText(temp / "one.csv", "old");
  auto set = FileSet::Begin(temp.path());
  ASSERT_TRUE(set);
  ASSERT_TRUE((*set)->Add("one.csv", "new"));
  const auto committed = (*set)->Commit({std::string(300, 'x')});
  ASSERT_FALSE(committed);
  EXPECT_NE(committed.error().message.find("xxx: cannot write: File name too long"),
            std::string::npos)
      << committed.error().message;
  EXPECT_EQ(ReadText(temp / "one.csv"), "old");
}

TEST(FileSet, ReplacesItsOwnFilesAndLeavesOthersAlone) {
  const TempFolder temp;
  WriteText(temp / "mine.txt", "mine");
  WriteText(temp / "one.csv", "old");
  WriteText(temp / "stale.csv", "old");
  auto set = FileSet::Begin(temp.path());
  ASSERT_TRUE(set);
  ASSERT_TRUE((*set)->Add("one.csv", "new"));
  EXPECT_EQ(ReadText(temp / "one.csv"), "old") << "not before Commit";
  ASSERT_TRUE((*set)->Commit({"one.csv", "stale.csv", "absent.csv"}));
  set->reset();
  EXPECT_EQ(ReadText(temp / "one.csv"), "new");
  EXPECT_EQ(ReadText(temp / "mine.txt"), "mine");
  EXPECT_FALSE(fs::exists(temp / "stale.csv"));
  EXPECT_EQ(CountEntries(temp.path()), 2u);
}

// A folder stands where the last file should go.
TEST(FileSet, WhatCannotBePutInPlaceChangesNothing) {
  const TempFolder temp;
  WriteText(temp / "one.csv", "old");
  fs::create_directory(temp / "two.csv");
  WriteText(temp / "two.csv/inside", "kept");
  {
    auto set = FileSet::Begin(temp.path());
    ASSERT_TRUE(set);
    ASSERT_TRUE((*set)->Add("one.csv", "new"));
    ASSERT_TRUE((*set)->Add("two.csv", "new"));
    const auto done = (*set)->Commit();
    ASSERT_FALSE(done);
    EXPECT_EQ(done.error().message,
              temp / "two.csv" + ": cannot write: is a folder, expected a file");
  }
  EXPECT_EQ(ReadText(temp / "one.csv"), "old");
  EXPECT_EQ(ReadText(temp / "two.csv/inside"), "kept");
  EXPECT_EQ(CountEntries(temp.path()), 2u);
}

// The second file's text vanishes before its rename; the first is taken back.
TEST(FileSet, RenamesThatFailAreUndone) {
  const TempFolder temp;
  WriteText(temp / "one.csv", "old");
  {
    auto set = FileSet::Begin(temp.path());
    ASSERT_TRUE(set);
    ASSERT_TRUE((*set)->Add("one.csv", "new"));
    ASSERT_TRUE((*set)->Add("two.csv", "new"));
    for (const auto& entry : fs::recursive_directory_iterator(temp.path())) {
      if (entry.path().filename() == "two.csv") fs::remove(entry.path());
    }
    const auto done = (*set)->Commit();
    ASSERT_FALSE(done);
    EXPECT_EQ(done.error().message, temp / "two.csv" + ": cannot write: No such file or directory");
  }
  EXPECT_EQ(ReadText(temp / "one.csv"), "old");
  EXPECT_EQ(CountEntries(temp.path()), 1u);
}

TEST(FileSet, FileInTheWayOfTheFolderIsRefusedBeforehand) {
  const TempFolder temp;
  WriteText(temp / "file", "x");
  for (const char* name : {"file", "file/below"}) {
    const auto possible = CheckOutputFolder(temp / name);
    ASSERT_FALSE(possible) << name;
    EXPECT_EQ(possible.error().message.rfind(temp / "file", 0), 0u) << possible.error().message;
    EXPECT_FALSE(FileSet::Begin(temp / name));
  }
  EXPECT_EQ(CountEntries(temp.path()), 1u);
}

// A run that begins beside this one may take away again the folder that both have seen.
TEST(MadeFolders, AnAttemptIsMadeAgainWhileFoldersComeAndGo) {
  const TempFolder temp;
  int attempts = 0;
  const auto fails_until = [&](int last) {
    attempts = 0;
    return [&attempts, last] { return ++attempts < last ? Status(Error{"gone"}) : Ok(); };
  };
  EXPECT_TRUE(WhileFoldersComeAndGo(temp / "new", fails_until(4)));
  EXPECT_EQ(attempts, 4);
  EXPECT_FALSE(WhileFoldersComeAndGo(temp / "new", fails_until(1000)));
  EXPECT_FALSE(WhileFoldersComeAndGo(temp.path(), fails_until(2))) << "that is another fault";
  EXPECT_EQ(attempts, 1);
}

TEST(FileSet, CheckLeavesNothingBehind) {
  const TempFolder temp;
  EXPECT_TRUE(CheckOutputFolder(temp / "a/b/c"));
  EXPECT_TRUE(CheckOutputFolder(temp.path()));
  EXPECT_EQ(CountEntries(temp.path()), 0u);
}

TEST(FileSet, FolderWithoutRightsIsRefused) {
  if (::geteuid() == 0) GTEST_SKIP() << "root may write everywhere";
  const TempFolder temp;
  fs::create_directory(temp / "locked");
  ::chmod((temp / "locked").c_str(), 0555);
  for (const char* name : {"locked", "locked/below"}) {
    const auto possible = CheckOutputFolder(temp / name);
    ASSERT_FALSE(possible) << name;
    EXPECT_NE(possible.error().message.find("Permission denied"), std::string::npos);
  }
  ::chmod((temp / "locked").c_str(), 0755);
}

// Root, too, is refused by a file system that takes no files.
TEST(FileSet, FolderThatTakesNoFilesIsRefused) {
  if (!fs::exists("/proc/self")) GTEST_SKIP() << "no /proc";
  EXPECT_FALSE(CheckOutputFolder("/proc/self/task"));
  EXPECT_FALSE(CheckOutputFolder("/proc/tagtwist/out"));
}

// As a process leaves it that is killed after `renames` of the renames of a Commit.
void LeaveCommitCutShort(const TempFolder& temp, int renames) {
  const fs::path commit = temp / ".results.commit";
  fs::create_directories(commit / ".replaced");
  WriteText(commit / ".plan", "put one.csv\nput two.csv\nremove stale.csv\nput ../out.csv\n");
  for (const char* name : {"one.csv", "two.csv"}) WriteText(commit / name, "new");
  for (const char* name : {"one.csv", "two.csv", "stale.csv"}) WriteText(temp / name, "old");
  const std::vector<std::pair<fs::path, fs::path>> moves = {
      {temp / "one.csv", commit / ".replaced/one.csv"},
      {commit / "one.csv", temp / "one.csv"},
      {temp / "two.csv", commit / ".replaced/two.csv"},
      {commit / "two.csv", temp / "two.csv"},
      {temp / "stale.csv", commit / ".replaced/stale.csv"}};
  for (int i = 0; i < renames; ++i) fs::rename(moves[size_t(i)].first, moves[size_t(i)].second);
}

TEST(FileSet, ACommitThatWasCutShortIsFinishedByTheNext) {
  for (int renames = 0; renames <= 5; ++renames) {
    for (const bool by_a_run : {false, true}) {
      const TempFolder temp;
      LeaveCommitCutShort(temp, renames);
      EXPECT_FALSE(IsFileSetWhole(temp.path()));
      if (by_a_run) {
        auto set = FileSet::Begin(temp.path());
        ASSERT_TRUE(set && (*set)->Add("three.csv", "newest") && (*set)->Commit());
        EXPECT_EQ(ReadText(temp / "three.csv"), "newest");
        fs::remove(temp / "three.csv");
      } else {
        const auto told = RecoverFileSet(temp.path());
        ASSERT_TRUE(told) << told.error().message;
        EXPECT_EQ(told->size(), 1u);
      }
      EXPECT_TRUE(IsFileSetWhole(temp.path()));
      EXPECT_EQ(ReadText(temp / "one.csv"), "new") << renames;
      EXPECT_EQ(ReadText(temp / "two.csv"), "new") << renames;
      EXPECT_EQ(CountEntries(temp.path()), 2u) << renames;
    }
  }
}

TEST(FileSet, ASetThatWasNotWholeGoesWithTheNext) {
  const TempFolder temp;
  WriteText(temp / "one.csv", "old");
  const pid_t child = ::fork();
  if (child == 0) {
    auto set = FileSet::Begin(temp.path());
    const auto added = (*set)->Add("one.csv", "new");
    ::kill(::getpid(), SIGKILL);
  }
  ::waitpid(child, nullptr, 0);
  EXPECT_EQ(CountEntries(temp.path()), 2u);
  const auto told = RecoverFileSet(temp.path());
  ASSERT_TRUE(told);
  ASSERT_EQ(told->size(), 1u);
  EXPECT_NE(told->front().find("left by a run that was ended: removed"), std::string::npos);
  EXPECT_EQ(CountEntries(temp.path()), 1u);
  EXPECT_EQ(ReadText(temp / "one.csv"), "old");
}

}  // namespace
}  // namespace tagtwist::internal::file_set_test

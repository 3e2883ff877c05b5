#include "frontend/base/files/partial.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/support/test_files.h"

namespace tagtwist::internal::partial_test {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

// A process that makes one and is killed; or lives until `use` has been called.
template <typename Use>
void WithProcess(const std::string& path, bool killed, const Use& use) {
  int ready[2];
  ASSERT_EQ(::pipe(ready), 0);
  const pid_t child = ::fork();
  if (child == 0) {
    const auto partial = Partial::Make(path, Partial::Kind::kFolder);
    WriteText(partial->path() + "/file", "x");
    if (::write(ready[1], "x", 1) != 1) ::_exit(1);
    ::pause();
  }
  char byte = 0;
  ASSERT_EQ(::read(ready[0], &byte, 1), 1);
  if (killed) {
    ::kill(child, SIGKILL);
    ::waitpid(child, nullptr, 0);
  }
  use(PartialName(path, child));
  ::kill(child, SIGKILL);
  ::waitpid(child, nullptr, 0);
  ::close(ready[0]);
  ::close(ready[1]);
}

TEST(Partial, GoesWithItsObjectUnlessItIsPutInItsPlace) {
  const TempFolder temp;
  {
    auto partial = Partial::Make(temp / "a", Partial::Kind::kFile);
    ASSERT_TRUE(partial) << partial.error().message;
    EXPECT_EQ(fs::path(partial->path()).filename().string()[0], '.');
    EXPECT_EQ(::write(partial->descriptor(), "x", 1), 1);
    ASSERT_EQ(partial->PutAt(temp / "a"), 0);
    const auto folder = Partial::Make(temp / "b/", Partial::Kind::kFolder);
    ASSERT_TRUE(folder);
    WriteText(folder->path() + "/file", "x");
    const auto second = Partial::Make(temp / "b/", Partial::Kind::kFolder);
    ASSERT_TRUE(second) << "several at once";
    EXPECT_NE(second->path(), folder->path());
  }
  EXPECT_EQ(ReadText(temp / "a"), "x");
  EXPECT_EQ(temp.CountEntries(), 1u);
}

TEST(Partial, IsNeverMadeThroughALink) {
  const TempFolder temp;
  WriteText(temp / "mine", "mine");
  fs::create_symlink("mine", PartialName(temp / "a.mp4", ::getpid()) + ".mp4");
  const auto partial = Partial::Make(temp / "a.mp4", Partial::Kind::kFile, ".mp4");
  ASSERT_TRUE(partial);
  WriteText(partial->path(), "other");
  EXPECT_EQ(ReadText(temp / "mine"), "mine");
}

TEST(Partial, OfAKilledProcessIsRemovedAndTold) {
  const TempFolder temp;
  WithProcess(temp / "a", /*killed=*/true, [&](const std::string& left) {
    EXPECT_TRUE(fs::exists(left));
    EXPECT_THAT(RemoveLeftovers(temp / "a"), ElementsAre(left));
    EXPECT_FALSE(fs::exists(left));
  });
  EXPECT_EQ(temp.CountEntries(), 0u);
}

TEST(Partial, OfALivingProcessStays) {
  const TempFolder temp;
  WithProcess(temp / "a", /*killed=*/false, [&](const std::string& other) {
    EXPECT_THAT(RemoveLeftovers(temp / "a"), IsEmpty());
    RemoveOwnPartials(temp / "a");
    EXPECT_TRUE(fs::exists(other + "/file"));
  });
}

TEST(Partial, OwnOnesGoWhenTheProcessIsToEnd) {
  const TempFolder temp;
  const auto file = Partial::Make(temp / "a.mp4", Partial::Kind::kFile, ".mp4");
  const auto folder = Partial::Make(temp / "a.mp4", Partial::Kind::kFolder);
  ASSERT_TRUE(file && folder);
  RemoveOwnPartials(temp / "a.mp4");
  EXPECT_EQ(temp.CountEntries(), 0u);
}

}  // namespace
}  // namespace tagtwist::internal::partial_test

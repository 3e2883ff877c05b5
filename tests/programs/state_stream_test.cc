#include "apps/estimate/state_stream.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <csignal>
#include <string>
#include <thread>

#include "tests/support/temp_folder.h"

namespace tagtwist::internal::state_stream_test {
namespace {

std::atomic<int> g_sigpipes{0};

// A stream into a FIFO whose reader takes the header and goes.
std::unique_ptr<StateStream> StreamWhoseReaderIsGone(const std::string& fifo) {
  std::thread reader([&] {
    const int descriptor = ::open(fifo.c_str(), O_RDONLY);
    char first = 0;
    EXPECT_EQ(::read(descriptor, &first, 1), 1);
    ::close(descriptor);
  });
  auto stream = StateStream::Open(fifo);
  reader.join();
  EXPECT_TRUE(stream);
  return std::move(*stream);
}

TEST(StateStream, AReaderThatIsGoneIsNoSignalAndTheProcessKeepsItsOwnHandler) {
  const TempFolder temp;
  const std::string fifo = temp / "rows";
  ASSERT_EQ(::mkfifo(fifo.c_str(), 0600), 0);
  const auto before = std::signal(SIGPIPE, [](int) { ++g_sigpipes; });
  auto stream = StreamWhoseReaderIsGone(fifo);
  stream->Write(FrameEstimate());
  EXPECT_EQ(g_sigpipes, 0) << "the stream's own";
  EXPECT_NE(stream->problem().find("ended after 0 rows: its reader is gone"), std::string::npos)
      << stream->problem();
  ASSERT_EQ(std::raise(SIGPIPE), 0);
  EXPECT_EQ(g_sigpipes, 1) << "the process's own";
  std::signal(SIGPIPE, before);
}

}  // namespace
}  // namespace tagtwist::internal::state_stream_test

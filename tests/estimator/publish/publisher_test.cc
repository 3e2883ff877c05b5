// A publisher whose readers are slow, dead or gone.
#include "estimator/publish/publisher.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <opencv2/core.hpp>
#include <thread>
#include <utility>

#include "tests/support/temp_folder.h"
#include "tests/support/test_files.h"

namespace tagtwist::internal::publisher_test {
namespace {

PublishedRun AnyRun() {
  PublishedRun run;
  run.set_up = MakeSetUp(Camera(), Pose(), MakeTagMap(TagGrid()));
  return run;
}

FramePtr Frame(int64_t t_ns, const cv::Mat& image = cv::Mat()) {
  PublishedFrame frame;
  FrameEstimate& state = frame.bodies.front().state;
  state.t_ns = t_ns;
  state.status = FrameStatus::kOk;
  state.state.world_from_body = MakePose(Eigen::Quaterniond(0, -1, 0, 0), {1.7, 1.3, 1.2});
  state.covariance.setIdentity();
  frame.images = {{0, image}};
  return std::make_shared<const PublishedFrame>(std::move(frame));
}

// A connection to the port at the end of a link; what it sends goes there at once.
class Client {
 public:
  Client(const std::string& link, const std::string& protocol) {
    const int port = std::stoi(link.substr(link.rfind(':') + 1));
    socket_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in place{};
    place.sin_family = AF_INET;
    place.sin_port = htons(static_cast<uint16_t>(port));
    place.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    EXPECT_EQ(::connect(socket_, reinterpret_cast<sockaddr*>(&place), sizeof(place)), 0);
    const std::string request =
        "GET / HTTP/1.1\r\nHost: localhost:" + std::to_string(port) +
        "\r\nConnection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
        "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Protocol: " +
        protocol + "\r\n\r\n";
    EXPECT_EQ(::send(socket_, request.data(), request.size(), 0),
              static_cast<ssize_t>(request.size()));
  }
  ~Client() { ::close(socket_); }
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;

  std::string Read() const {
    std::string out(1 << 16, '\0');
    const ssize_t got = ::recv(socket_, out.data(), out.size(), 0);
    out.resize(static_cast<size_t>(std::max<ssize_t>(got, 0)));
    return out;
  }

 private:
  int socket_ = -1;
};

double RssMib() {
  std::ifstream in("/proc/self/statm");
  double pages = 0;
  in >> pages >> pages;
  return pages * static_cast<double>(::sysconf(_SC_PAGESIZE)) / (1 << 20);
}

std::unique_ptr<Publisher> Started(const PublishOptions& options) {
  auto out = Publisher::Start(options, AnyRun());
  EXPECT_TRUE(out) << out.error().message;
  return std::move(*out);
}

PublishOptions Web() {
  PublishOptions options;
  options.page = options.foxglove = true;
  return options;
}

TEST(Publisher, PagesGetWhatIsPublished) {
  const auto publisher = Started(Web());
  const Client page(publisher->Links()[0], "tagtwist.live.v1");
  std::string got;
  for (int i = 0; i < 200 && got.find("\"type\":\"state\"") == std::string::npos; ++i) {
    publisher->Publish(Frame(1'000'000 * i));
    got += page.Read();
  }
  EXPECT_NE(got.find("Sec-WebSocket-Protocol: tagtwist.live.v1"), std::string::npos);
  EXPECT_NE(got.find("\"type\":\"setup\""), std::string::npos);
  EXPECT_NE(got.find("\"type\":\"state\""), std::string::npos);
  const auto losses = publisher->Finish();
  EXPECT_TRUE(losses.failure.empty()) << losses.failure;
}

// 100,000 frames, faster than any camera, to ten pages and a Foxglove client that read
// nothing and one after the other that vanishes: neither time nor memory. Slow: sanitizers keep
// memory that was freed.
TEST(SlowPublisher, ClientsThatDoNotReadCostNothing) {
  const auto publisher = Started(Web());
  const auto links = publisher->Links();
  std::vector<std::unique_ptr<Client>> still;
  for (int i = 0; i < 10; ++i) {
    still.push_back(std::make_unique<Client>(links[0], "tagtwist.live.v1"));
  }
  still.push_back(std::make_unique<Client>(links[0], "foxglove.websocket.v1"));
  cv::Mat image(240, 376, CV_8UC1);
  cv::randu(image, 0, 256);
  double before_mib = 0, longest_ms = 0;
  for (int64_t i = 0; i < 100'000; ++i) {
    if (i % 5000 == 0) const Client gone(links[0], "tagtwist.live.v1");
    if (i == 30'000) before_mib = RssMib();
    const FramePtr frame = Frame(1'000'000 * i, image);
    if (i % 5 == 0) std::this_thread::sleep_for(std::chrono::microseconds(50));
    const auto start = std::chrono::steady_clock::now();
    publisher->Publish(frame);
    const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - start;
    longest_ms = std::max(longest_ms, took.count());
  }
  EXPECT_LT(RssMib() - before_mib, 16);
  EXPECT_LT(longest_ms, 500);  // of a machine that does other things, too
  publisher->Finish();
}

TEST(Publisher, FilesOfARunThatIsNotLiveLackNothing) {
  const TempFolder folder;
  PublishOptions options;
  options.mcap = folder / "a.mcap";
  options.record = folder / "rec";
  options.waits = true;
  const auto publisher = Started(options);
  EXPECT_TRUE(publisher->Links().empty());
  const cv::Mat image(24, 32, CV_8UC1, cv::Scalar(7));
  for (int i = 0; i < 300; ++i) publisher->Publish(Frame(1'000'000 * i, image));
  const auto losses = publisher->Finish();
  EXPECT_TRUE(losses.failure.empty() && losses.warnings.empty()) << losses.failure;
  const std::string table = ReadText(folder / "rec/timestamps.csv");
  EXPECT_EQ(std::count(table.begin(), table.end(), '\n'), 301);
}

TEST(Publisher, AFileThatCannotBeWrittenIsAFailure) {
  const TempFolder folder;
  PublishOptions options;
  options.record = folder / "rec";
  options.waits = true;
  const auto publisher = Started(options);
  std::filesystem::remove_all(folder / "rec/images");
  publisher->Publish(Frame(1, cv::Mat(24, 32, CV_8UC1, cv::Scalar(7))));
  publisher->Publish(Frame(2, cv::Mat(24, 32, CV_8UC1, cv::Scalar(7))));
  EXPECT_EQ(publisher->Finish().failure,
            folder / "rec/images/000000.png" + ": cannot write: No such file or directory");
}

TEST(Publisher, WhatCannotBeHadIsNamed) {
  PublishOptions options = Web();
  const auto first = Started(options);
  const std::string link = first->Links()[0];
  options.port = static_cast<uint16_t>(std::stoi(link.substr(link.rfind(':') + 1)));
  const auto second = Publisher::Start(options, AnyRun());
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().message,
            "127.0.0.1:" + std::to_string(options.port) + ": Address already in use");
  options.listen = "localhost";
  const auto third = Publisher::Start(options, AnyRun());
  ASSERT_FALSE(third);
  EXPECT_EQ(third.error().message, "localhost: expected an IP address");
  PublishOptions udp;
  udp.udp = {"no-such-host.invalid:9000"};
  EXPECT_FALSE(Publisher::Start(udp, AnyRun()));
}

}  // namespace
}  // namespace tagtwist::internal::publisher_test

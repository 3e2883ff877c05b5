#include "estimator/publish/udp_sender.h"

#include <boost/asio/buffer.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/udp.hpp>
#include <utility>

namespace tagtwist::internal {
namespace {

namespace asio = boost::asio;
using asio::ip::udp;

class AsioUdpSender : public UdpSender {
 public:
  boost::system::error_code Connect(const std::string& host, const std::string& port) {
    boost::system::error_code failure;
    const auto found = udp::resolver(io_).resolve(host, port, failure);
    for (const auto& place : found) {
      socket_ = udp::socket(io_);
      socket_.open(place.endpoint().protocol(), failure);
      if (!failure) socket_.set_option(asio::socket_base::broadcast(true), failure);
      if (!failure) socket_.connect(place.endpoint(), failure);
      if (!failure) socket_.non_blocking(true, failure);
      if (!failure) break;
    }
    return failure;
  }
  void Send(const std::string& text) override {
    boost::system::error_code failure;
    socket_.send(asio::buffer(text), 0, failure);
    // Nobody listened the last time, which this call is told: it sent nothing itself.
    if (failure == asio::error::connection_refused) {
      socket_.send(asio::buffer(text), 0, failure);
    }
    if (failure && failure != asio::error::connection_refused) ++lost_;
  }
  size_t lost() const override { return lost_; }

 private:
  asio::io_context io_;
  udp::socket socket_{io_};
  size_t lost_ = 0;
};

}  // namespace

Result<std::unique_ptr<UdpSender>> UdpSender::Open(const std::string& place) {
  const size_t colon = place.rfind(':');
  std::string host = place.substr(0, colon);
  if (host.size() > 2 && host.front() == '[' && host.back() == ']') {
    host = host.substr(1, host.size() - 2);
  }
  auto out = std::make_unique<AsioUdpSender>();
  if (const auto failure = out->Connect(host, place.substr(colon + 1))) {
    return Error{"udp://" + place + ": " + failure.message()};
  }
  return std::unique_ptr<UdpSender>(std::move(out));
}

}  // namespace tagtwist::internal

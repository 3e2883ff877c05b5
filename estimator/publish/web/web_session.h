#pragma once
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/message.hpp>
#include <boost/beast/websocket/stream.hpp>
#include <chrono>
#include <cstddef>
#include <deque>
#include <functional>
#include <memory>
#include <string>

namespace tagtwist::internal {

/// A message to a client: `head` and then `body`, which several clients share.
struct WebMessage {
  int kind = 0;  // messages of a kind make way for newer ones of it
  std::string head;
  std::shared_ptr<const std::string> body;
  bool is_binary = false;
};

/// One WebSocket client. Whatever it does, no more than a few messages of each kind wait for it:
/// one that reads slowly gets the newest. It ends when the client goes, answers no ping for half a
/// minute, or says too much. All of it runs in the thread of its stream.
class WebSession : public std::enable_shared_from_this<WebSession> {
 public:
  using Request = boost::beast::http::request<boost::beast::http::empty_body>;
  struct Events {
    std::function<void()> on_open;
    std::function<void(const std::string& text)> on_text;
    std::function<void()> on_close;  // once; also where it never opened
  };
  explicit WebSession(boost::beast::tcp_stream stream) : stream_(std::move(stream)) {}

  /// Answers the upgrade; `protocol`: the subprotocol that is spoken.
  void Accept(const Request& request, const std::string& protocol, Events events);
  /// At most `most` of the message's kind wait, the newest.
  void Send(WebMessage message, size_t most);
  /// When what waits is sent.
  void CloseAfterwards();

 private:
  void Read();
  void WriteNext();
  void End();
  bool SaysTooMuch();

  boost::beast::websocket::stream<boost::beast::tcp_stream> stream_;
  Events events_;
  boost::beast::flat_buffer incoming_;
  std::deque<WebMessage> waiting_;
  WebMessage in_flight_;
  bool is_open_ = false, is_writing_ = false, is_ending_ = false;
  std::chrono::steady_clock::time_point second_began_;
  int said_in_second_ = 0;
};

}  // namespace tagtwist::internal

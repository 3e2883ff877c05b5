#include "estimator/publish/web/web_session.h"

#include <algorithm>
#include <array>
#include <boost/asio/buffer.hpp>
#include <boost/beast/core/buffers_to_string.hpp>
#include <utility>

namespace tagtwist::internal {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace websocket = beast::websocket;

constexpr size_t kLongestText = 64 * 1024;  // that a client may send
constexpr int kMostTextsInASecond = 100;

}  // namespace

void WebSession::Accept(const Request& request, const std::string& protocol, Events events) {
  events_ = std::move(events);
  beast::get_lowest_layer(stream_).expires_never();  // the WebSocket's own limits hold from here
  beast::error_code failure;
  beast::get_lowest_layer(stream_).socket().set_option(asio::ip::tcp::no_delay(true), failure);
  // What lies in the system's buffer is old when a slow client reads it.
  beast::get_lowest_layer(stream_).socket().set_option(
      asio::socket_base::send_buffer_size(256 * 1024), failure);
  stream_.set_option(
      websocket::stream_base::timeout{std::chrono::seconds(10), std::chrono::seconds(30), true});
  stream_.set_option(
      websocket::stream_base::decorator([protocol](websocket::response_type& answer) {
        answer.set(beast::http::field::sec_websocket_protocol, protocol);
        answer.set(beast::http::field::server, "tagtwist");
      }));
  stream_.read_message_max(kLongestText);
  stream_.auto_fragment(false);
  stream_.async_accept(request, [self = shared_from_this()](const beast::error_code& fault) {
    if (fault) return self->End();
    self->is_open_ = true;
    self->events_.on_open();
    self->Read();
    self->WriteNext();
  });
}

bool WebSession::SaysTooMuch() {
  const auto now = std::chrono::steady_clock::now();
  if (now - second_began_ > std::chrono::seconds(1)) {
    second_began_ = now;
    said_in_second_ = 0;
  }
  return ++said_in_second_ > kMostTextsInASecond;
}

void WebSession::Read() {
  stream_.async_read(incoming_,
                     [self = shared_from_this()](const beast::error_code& fault, size_t) {
                       if (fault || self->SaysTooMuch()) return self->End();
                       if (self->stream_.got_text()) {
                         self->events_.on_text(beast::buffers_to_string(self->incoming_.data()));
                       }
                       self->incoming_.consume(self->incoming_.size());
                       self->Read();
                     });
}

void WebSession::Send(WebMessage message, size_t most) {
  if (is_ending_) return;
  const auto is_same = [&](const WebMessage& other) { return other.kind == message.kind; };
  auto n = static_cast<size_t>(std::count_if(waiting_.begin(), waiting_.end(), is_same));
  for (; n >= most && n > 0; --n) {
    waiting_.erase(std::find_if(waiting_.begin(), waiting_.end(), is_same));
  }
  waiting_.push_back(std::move(message));
  WriteNext();
}

void WebSession::WriteNext() {
  if (!is_open_ || is_writing_) return;
  if (waiting_.empty()) {
    if (is_ending_) {
      is_writing_ = true;
      stream_.async_close(websocket::close_code::going_away,
                          [self = shared_from_this()](const beast::error_code&) { self->End(); });
    }
    return;
  }
  in_flight_ = std::move(waiting_.front());
  waiting_.pop_front();
  is_writing_ = true;
  stream_.binary(in_flight_.is_binary);
  const std::array<asio::const_buffer, 2> bytes = {asio::buffer(in_flight_.head),
                                                   asio::buffer(*in_flight_.body)};
  stream_.async_write(bytes, [self = shared_from_this()](const beast::error_code& fault, size_t) {
    self->is_writing_ = false;
    if (fault) return self->End();
    self->WriteNext();
  });
}

void WebSession::CloseAfterwards() {
  is_ending_ = true;
  WriteNext();
}

void WebSession::End() {
  is_open_ = false;
  is_ending_ = true;
  waiting_.clear();
  beast::get_lowest_layer(stream_).close();  // pending operations end with an error
  const auto on_close = std::exchange(events_.on_close, nullptr);
  if (on_close) on_close();
}

}  // namespace tagtwist::internal

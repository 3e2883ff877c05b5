#pragma once
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/message.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/status.hpp>
#include <boost/beast/http/string_body.hpp>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "estimator/publish/web/web_rules.h"
#include "estimator/publish/web/web_session.h"

namespace tagtwist::internal {

/// Subprotocols of the WebSocket.
inline const char* const kPageProtocol = "tagtwist.live.v1";
inline const char* const kFoxgloveProtocol = "foxglove.websocket.v1";

/// A connection until its first request is answered, with the page, a refusal, or a WebSocket.
class HttpConnection : public std::enable_shared_from_this<HttpConnection> {
 public:
  /// What there is to be had. It outlives the connection.
  struct Site {
    const WebRules* rules;
    const std::string& page;  // empty: none
    bool foxglove;
  };
  using Upgraded =
      std::function<void(std::shared_ptr<WebSession>, const WebSession::Request&, bool foxglove)>;
  /// Either is called, once: when it becomes a WebSocket, or when it is over.
  HttpConnection(boost::asio::ip::tcp::socket socket, Site site, Upgraded upgraded,
                 std::function<void()> over)
      : stream_(std::move(socket)),
        site_(site),
        upgraded_(std::move(upgraded)),
        over_(std::move(over)) {}

  void Start();

 private:
  using Status = boost::beast::http::status;
  void Take();
  void TakeUpgrade(const WebSession::Request& request);
  void Answer(Status status, const std::string& text, const std::string& type = "text/plain");
  WebRequest Asked() const;

  boost::beast::tcp_stream stream_;
  Site site_;
  Upgraded upgraded_;
  std::function<void()> over_;
  boost::beast::flat_buffer buffer_;
  std::optional<boost::beast::http::request_parser<boost::beast::http::empty_body>> parser_;
  boost::beast::http::response<boost::beast::http::string_body> answer_;
};

}  // namespace tagtwist::internal

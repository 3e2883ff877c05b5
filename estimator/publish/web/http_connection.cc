#include "estimator/publish/web/http_connection.h"

#include <boost/beast/http/read.hpp>
#include <boost/beast/http/write.hpp>
#include <boost/beast/websocket/rfc6455.hpp>
#include <chrono>
#include <string_view>
#include <utility>

namespace tagtwist::internal {
namespace {

namespace beast = boost::beast;
namespace http = beast::http;

constexpr auto kPatience = std::chrono::seconds(10);  // for a request, and for its answer
constexpr uint32_t kLongestHead = 8 * 1024;

std::string Text(beast::string_view view) { return {view.data(), view.size()}; }

// Whether a list "a, b" has the word.
bool Lists(std::string_view list, std::string_view word) {
  while (!list.empty()) {
    std::string_view part = list.substr(0, list.find(','));
    list.remove_prefix(part.size() == list.size() ? list.size() : part.size() + 1);
    while (!part.empty() && part.front() == ' ') part.remove_prefix(1);
    while (!part.empty() && part.back() == ' ') part.remove_suffix(1);
    if (part == word) return true;
  }
  return false;
}

// The page is one file: it may talk to nobody but where it came from.
const char* const kPagePolicy =
    "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src blob: "
    "data:; connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

}  // namespace

void HttpConnection::Start() {
  parser_.emplace();
  parser_->header_limit(kLongestHead);
  parser_->body_limit(0);
  stream_.expires_after(kPatience);
  http::async_read(stream_, buffer_, *parser_,
                   [self = shared_from_this()](const beast::error_code& failure, size_t) {
                     if (!failure) return self->Take();
                     const bool is_http = failure.category() ==
                                          http::make_error_code(http::error::bad_method).category();
                     if (!is_http || failure == http::error::end_of_stream) return self->over_();
                     self->Answer(failure == http::error::header_limit
                                      ? Status::request_header_fields_too_large
                                  : failure == http::error::body_limit ? Status::payload_too_large
                                                                       : Status::bad_request,
                                  "not a request that is understood\n");
                   });
}

WebRequest HttpConnection::Asked() const {
  const auto& request = parser_->get();
  WebRequest out;
  out.target = Text(request.target());
  if (request.count(http::field::host) == 1) out.host = Text(request[http::field::host]);
  if (request.count(http::field::origin) > 0) out.origin = Text(request[http::field::origin]);
  out.is_foxglove = Lists(Text(request[http::field::sec_websocket_protocol]), kFoxgloveProtocol);
  return out;
}

void HttpConnection::Take() {
  const WebSession::Request& request = parser_->get();
  const WebRequest asked = Asked();
  if (const auto refused = site_.rules->Refusal(asked)) {
    return Answer(Status::forbidden, "refused: " + *refused + "\n");
  }
  if (beast::websocket::is_upgrade(request)) return TakeUpgrade(request);
  if (request.method() != http::verb::get && request.method() != http::verb::head) {
    return Answer(Status::method_not_allowed, "only GET\n");
  }
  if (PathOf(asked.target) != "/" || site_.page.empty()) {
    return Answer(Status::not_found, "there is nothing here\n");
  }
  Answer(Status::ok, site_.page, "text/html; charset=utf-8");
}

void HttpConnection::TakeUpgrade(const WebSession::Request& request) {
  const WebRequest asked = Asked();
  const bool is_page = Lists(Text(request[http::field::sec_websocket_protocol]), kPageProtocol);
  const bool fits = (is_page && !site_.page.empty()) || (asked.is_foxglove && site_.foxglove);
  if (PathOf(asked.target) != "/" || !fits) {
    return Answer(Status::bad_request, "no such WebSocket protocol here\n");
  }
  upgraded_(std::make_shared<WebSession>(std::move(stream_)), request, !is_page);
}

void HttpConnection::Answer(Status status, const std::string& text, const std::string& type) {
  const bool is_head = parser_->get().method() == http::verb::head;
  answer_ = {status, 11};
  answer_.set(http::field::server, "tagtwist");
  answer_.set(http::field::content_type, type);
  answer_.set("Content-Security-Policy", kPagePolicy);
  answer_.set("X-Content-Type-Options", "nosniff");
  answer_.set("Referrer-Policy", "no-referrer");
  answer_.set("Cross-Origin-Resource-Policy", "same-origin");
  answer_.set(http::field::cache_control, "no-store");
  if (status == Status::method_not_allowed) answer_.set(http::field::allow, "GET, HEAD");
  answer_.keep_alive(false);
  answer_.content_length(text.size());
  if (!is_head) answer_.body() = text;
  stream_.expires_after(kPatience);
  http::async_write(
      stream_, answer_, [self = shared_from_this()](const beast::error_code&, size_t) {
        beast::error_code ignored;
        self->stream_.socket().shutdown(boost::asio::ip::tcp::socket::shutdown_send, ignored);
        self->over_();
      });
}

}  // namespace tagtwist::internal

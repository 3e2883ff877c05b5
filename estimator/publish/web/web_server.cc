#include "estimator/publish/web/web_server.h"

#include <atomic>
#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <deque>
#include <map>
#include <optional>
#include <thread>
#include <utility>

#include "estimator/publish/web/foxglove_client.h"
#include "estimator/publish/web/http_connection.h"
#include "estimator/publish/web/web_rules.h"
#include "estimator/publish/web/web_session.h"

namespace tagtwist::internal {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
using asio::ip::tcp;

constexpr size_t kMostClients = 64;
constexpr size_t kStatesKept = 600;    // for pages that come later
constexpr size_t kStatesWaiting = 60;  // for a page or client that is slow
constexpr size_t kMostPosted = 500;    // to the server's thread
// Kinds of messages to pages; those to Foxglove's clients are their channels.
enum PageKind { kPageGreeting, kPageState, kPageFacts, kPagePicture };  // and one a camera on

std::shared_ptr<const std::string> Shared(std::string text) {
  return std::make_shared<const std::string>(std::move(text));
}

class AsioWebServer : public WebServer {
 public:
  explicit AsioWebServer(Options options)
      : options_(std::move(options)), subscribers_(options_.channels.size() + 1) {
    rules_.token = options_.token;
    for (auto& count : subscribers_) count = 0;
  }
  ~AsioWebServer() override { Stop(); }

  Status Listen() {
    beast::error_code failure;
    const auto address = asio::ip::make_address(options_.address, failure);
    if (failure) return Error{options_.address + ": expected an IP address"};
    const tcp::endpoint place(address, options_.port);
    acceptor_.open(place.protocol(), failure);
    if (!failure) acceptor_.set_option(asio::socket_base::reuse_address(true), failure);
    if (!failure) acceptor_.bind(place, failure);
    if (!failure) acceptor_.listen(asio::socket_base::max_listen_connections, failure);
    if (failure) {
      return Error{options_.address + ":" + std::to_string(options_.port) + ": " +
                   failure.message()};
    }
    rules_.port = acceptor_.local_endpoint().port();
    Accept();
    thread_ = std::thread([this] { io_.run(); });
    return Ok();
  }

  uint16_t port() const override { return rules_.port; }
  bool HasPages() const override { return n_pages_ > 0; }
  bool HasSubscriber(uint32_t channel) const override {
    return channel < subscribers_.size() && subscribers_[channel] > 0;
  }

  void SendState(std::string json) override {
    Post([this, text = Shared(std::move(json))] {
      states_.push_back(text);
      if (states_.size() > kStatesKept) states_.pop_front();
      ToPages({kPageState, "", text, false}, kStatesWaiting);
    });
  }
  void SendPicture(size_t camera, const std::string& json, std::string jpeg) override {
    std::string head;
    for (int i = 0; i < 4; ++i) head += static_cast<char>((json.size() >> (8 * i)) & 0xff);
    const int kind = kPagePicture + static_cast<int>(camera);
    Post([this, kind, head = head + json, image = Shared(std::move(jpeg))] {
      ToPages({kind, head, image, true}, 1);
    });
  }
  void SendFacts(std::string json) override {
    Post([this, text = Shared(std::move(json))] {
      facts_ = text;
      ToPages({kPageFacts, "", text, false}, 1);
    });
  }
  void SendFoxglove(FoxgloveMessage message) override {
    Post([this, channel = message.channel, t_ns = message.t_ns,
          json = Shared(std::move(message.json))] {
      for (auto& [session, client] : foxglove_) SendTo(session.get(), client, channel, t_ns, json);
    });
  }

 private:
  using SessionPtr = std::shared_ptr<WebSession>;

  template <typename Work>
  void Post(Work work) {
    if (++posted_ > kMostPosted) {
      --posted_;
      return;
    }
    asio::post(io_, [this, work = std::move(work)] {
      --posted_;
      work();
    });
  }

  void ToPages(const WebMessage& message, size_t most) {
    for (const SessionPtr& page : pages_) page->Send(message, most);
  }

  void SendTo(WebSession* session, const FoxgloveClient& client, uint32_t channel, int64_t t_ns,
              const std::shared_ptr<const std::string>& json) const {
    const size_t most = options_.channels[channel - 1].newest_only ? 1 : kStatesWaiting;
    for (std::string& head : client.Heads(channel, t_ns)) {
      session->Send({static_cast<int>(channel), std::move(head), json, true}, most);
    }
  }

  void Accept() {
    acceptor_.async_accept([this](const beast::error_code& failure, tcp::socket socket) {
      if (failure == asio::error::operation_aborted) return;
      if (!failure && n_connections_ < kMostClients) {
        ++n_connections_;
        std::make_shared<HttpConnection>(
            std::move(socket), HttpConnection::Site{&rules_, options_.page, options_.foxglove},
            [this](const SessionPtr& session, const WebSession::Request& request,
                   bool is_foxglove) { Upgrade(session, request, is_foxglove); },
            [this] { --n_connections_; })
            ->Start();
      }
      if (failure) return AcceptLater();
      Accept();
    });
  }

  // The system has no descriptor left, or the like: that passes.
  void AcceptLater() {
    later_.expires_after(std::chrono::milliseconds(100));
    later_.async_wait([this](const beast::error_code& failure) {
      if (!failure) Accept();
    });
  }

  void Upgrade(const SessionPtr& session, const WebSession::Request& request, bool is_foxglove) {
    const auto raw = session.get();
    const std::weak_ptr<WebSession> weak = session;
    WebSession::Events events;
    events.on_open = [this, weak, is_foxglove] {
      if (auto open = weak.lock()) is_foxglove ? GreetFoxglove(open) : GreetPage(open);
    };
    events.on_text = [this, raw, is_foxglove](const std::string& text) {
      is_foxglove ? TakeFromFoxglove(raw, text) : options_.on_page_text(text);
    };
    events.on_close = [this, raw] { Forget(raw); };
    session->Accept(request, is_foxglove ? kFoxgloveProtocol : kPageProtocol, std::move(events));
  }

  void GreetPage(const SessionPtr& page) {
    std::string history = R"({"type":"history","states":[)";
    for (const auto& state : states_) history += (state == states_.front() ? "" : ",") + *state;
    page->Send({kPageGreeting, "", Shared(options_.greeting), false}, 10);
    page->Send({kPageGreeting, "", Shared(history + "]}"), false}, 10);
    if (facts_) page->Send({kPageFacts, "", facts_, false}, 1);
    pages_.push_back(page);
    n_pages_ = pages_.size();
  }

  void GreetFoxglove(const SessionPtr& session) {
    session->Send({0, "", Shared(FoxgloveServerInfo()), false}, 10);
    session->Send({0, "", Shared(FoxgloveAdvertise(options_.channels)), false}, 10);
    foxglove_.emplace(session, FoxgloveClient(options_.channels.size()));
  }

  void TakeFromFoxglove(WebSession* raw, const std::string& text) {
    for (auto& [session, client] : foxglove_) {
      if (session.get() != raw) continue;
      for (const uint32_t channel : client.Take(text)) {
        if (channel != options_.map.channel) continue;
        SendTo(raw, client, channel, options_.map.t_ns, Shared(options_.map.json));
      }
    }
    CountSubscribers();
  }

  void CountSubscribers() {
    for (uint32_t channel = 1; channel < subscribers_.size(); ++channel) {
      size_t n = 0;
      for (const auto& entry : foxglove_) n += entry.second.IsSubscribedTo(channel) ? 1 : 0;
      subscribers_[channel] = n;
    }
  }

  void Forget(WebSession* raw) {
    --n_connections_;
    for (size_t i = 0; i < pages_.size(); ++i) {
      if (pages_[i].get() != raw) continue;
      pages_.erase(pages_.begin() + static_cast<std::ptrdiff_t>(i));
      break;
    }
    for (auto it = foxglove_.begin(); it != foxglove_.end(); ++it) {
      if (it->first.get() != raw) continue;
      foxglove_.erase(it);
      break;
    }
    n_pages_ = pages_.size();
    CountSubscribers();
  }

  // Clients have a moment to take what waits for them.
  void Stop() {
    if (!thread_.joinable()) return;
    asio::post(io_, [this] {
      beast::error_code ignored;
      acceptor_.close(ignored);
      for (const SessionPtr& page : std::vector<SessionPtr>(pages_)) page->CloseAfterwards();
      for (auto& [session, client] : std::map<SessionPtr, FoxgloveClient>(foxglove_)) {
        session->CloseAfterwards();
      }
      later_.expires_after(std::chrono::milliseconds(300));
      later_.async_wait([this](const beast::error_code&) { io_.stop(); });
    });
    thread_.join();
  }

  Options options_;
  WebRules rules_;
  asio::io_context io_{1};
  tcp::acceptor acceptor_{io_};
  asio::steady_timer later_{io_};
  std::atomic<size_t> posted_{0}, n_pages_{0};
  std::vector<std::atomic<size_t>> subscribers_;  // by channel
  // Of the server's thread alone:
  size_t n_connections_ = 0;
  std::vector<SessionPtr> pages_;
  std::map<SessionPtr, FoxgloveClient> foxglove_;
  std::deque<std::shared_ptr<const std::string>> states_;
  std::shared_ptr<const std::string> facts_;
  std::thread thread_;
};

}  // namespace

Result<std::unique_ptr<WebServer>> WebServer::Start(Options options) {
  auto out = std::make_unique<AsioWebServer>(std::move(options));
  if (const Status listens = out->Listen(); !listens) return listens.error();
  return std::unique_ptr<WebServer>(std::move(out));
}

}  // namespace tagtwist::internal

#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "estimator/publish/foxglove_messages.h"
#include "frontend/base/result.h"

namespace tagtwist::internal {

/// The page, its WebSocket, and Foxglove's protocol (foxglove.websocket.v1) on one port, in a
/// thread of its own. Nothing but the page is served; nothing of the disk is read. Sending never
/// waits: a client that is slow or dead gets the newest, or nothing.
class WebServer {
 public:
  struct Options {
    std::string address = "127.0.0.1";  // an IP address
    uint16_t port = 0;                  // 0: any that is free
    std::string token;                  // empty: none is needed
    std::string page;                   // HTML; empty: there is no page
    std::string greeting;               // what a page is told first
    bool foxglove = false;
    std::vector<FoxgloveChannel> channels;
    FoxgloveMessage map;  // sent to whoever subscribes to it
    /// What a page says; called in the server's thread.
    std::function<void(const std::string& text)> on_page_text = [](const std::string&) {};
  };
  /// "127.0.0.1:8765: Address already in use".
  static Result<std::unique_ptr<WebServer>> Start(Options options);
  virtual ~WebServer() = default;

  virtual uint16_t port() const = 0;
  /// A state to all pages; those of the last seconds are kept for pages that come later.
  virtual void SendState(std::string json) = 0;
  /// A picture of one of the cameras to all pages: a JSON object and a JPEG.
  virtual void SendPicture(size_t camera, const std::string& json, std::string jpeg) = 0;
  /// What all pages are told from time to time; the latest is told to pages that come later.
  virtual void SendFacts(std::string json) = 0;
  /// To those who subscribe to its channel.
  virtual void SendFoxglove(FoxgloveMessage message) = 0;

  /// Whether any page is there, and whether anyone subscribes to a channel.
  virtual bool HasPages() const = 0;
  virtual bool HasSubscriber(uint32_t channel) const = 0;
};

}  // namespace tagtwist::internal

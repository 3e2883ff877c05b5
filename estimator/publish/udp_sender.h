#pragma once
#include <memory>
#include <string>

#include "frontend/base/result.h"

namespace tagtwist::internal {

/// Datagrams to one place. Nobody need be there: what cannot be sent at once is lost and counted.
class UdpSender {
 public:
  /// `place`: "host:port", "[::1]:port". "udp://nowhere:1: Host not found".
  static Result<std::unique_ptr<UdpSender>> Open(const std::string& place);
  virtual ~UdpSender() = default;
  /// Never waits.
  virtual void Send(const std::string& text) = 0;
  /// How many could not be sent, because the system's buffer was full or no way led there.
  virtual size_t lost() const = 0;
};

}  // namespace tagtwist::internal

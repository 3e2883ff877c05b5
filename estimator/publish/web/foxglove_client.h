#pragma once
#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "estimator/publish/foxglove_messages.h"

namespace tagtwist::internal {

/// What a client of the Foxglove WebSocket protocol (foxglove.websocket.v1) has subscribed to.
class FoxgloveClient {
 public:
  explicit FoxgloveClient(size_t n_channels) : n_channels_(n_channels) {}

  /// Takes what the client says; what is not understood is passed over. Returns the channels that
  /// it has subscribed to with this text, once for each subscription.
  std::vector<uint32_t> Take(const std::string& text);
  bool IsSubscribedTo(uint32_t channel) const;
  /// The heads of binary messages of a channel, one for each of its subscriptions.
  std::vector<std::string> Heads(uint32_t channel, int64_t t_ns) const;

 private:
  size_t n_channels_;
  std::map<uint32_t, uint32_t> subscriptions_;  // channel by subscription
};

/// The texts that a client gets first.
std::string FoxgloveServerInfo();
std::string FoxgloveAdvertise(const std::vector<FoxgloveChannel>& channels);

}  // namespace tagtwist::internal

#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "estimator/publish/published_frame.h"

namespace tagtwist::internal {

/// A topic as Foxglove and MCAP know it: messages are JSON, described by a JSON schema. Schemas
/// that begin with "foxglove." are those that its panels know (https://docs.foxglove.dev).
struct FoxgloveChannel {
  uint32_t id = 0;  // from 1 on, without gaps
  std::string topic, schema_name, schema;
  bool newest_only = false;  // its messages are large: of those that wait for a reader one is kept
};

/// Ids of channels: those of all, then three a body, then one a camera.
inline constexpr uint32_t kTransforms = 1, kMap = 2;
enum class OfBody : uint32_t { kState, kPose, kTwist };
uint32_t ChannelOf(size_t body, OfBody what);
uint32_t ImageChannel(const PublishedRun& run, size_t camera);
std::vector<FoxgloveChannel> FoxgloveChannels(const PublishedRun& run);

struct FoxgloveMessage {
  uint32_t channel = 0;
  int64_t t_ns = 0;
  std::string json;
};

/// State, pose and twist of each body, of one without a state its state message alone; and the
/// transforms of all, where one has a state. `state_jsons`: as StateJson gives them.
std::vector<FoxgloveMessage> NumberMessages(const PublishedRun& run, const PublishedFrame& frame,
                                            const std::vector<std::string>& state_jsons);
/// The image of a camera, a JPEG.
FoxgloveMessage ImageMessage(const PublishedRun& run, size_t camera, int64_t t_ns,
                             std::string_view jpeg);
/// The map as a scene: outlines and ids of its tags, of each body in the frame that they move with.
FoxgloveMessage MapMessage(const PublishedRun& run, int64_t t_ns);

/// Base 64 (RFC 4648) with padding.
std::string Base64(std::string_view bytes);

}  // namespace tagtwist::internal

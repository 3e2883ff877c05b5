#pragma once
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
};

/// Channels of a run, by what they carry; ids are their numbers.
enum FoxgloveTopic : uint32_t { kState = 1, kPose, kTransforms, kTwist, kImage, kMap };
std::vector<FoxgloveChannel> FoxgloveChannels(const PublishedRun& run);

struct FoxgloveMessage {
  uint32_t channel = 0;
  int64_t t_ns = 0;
  std::string json;
};

/// State, pose, transforms and twist of a frame; those of a frame without a state are its state
/// message alone. `state_json`: as StateJson gives it.
std::vector<FoxgloveMessage> NumberMessages(const PublishedRun& run, const PublishedFrame& frame,
                                            const std::string& state_json);
/// A frame's image, a JPEG.
FoxgloveMessage ImageMessage(const PublishedRun& run, int64_t t_ns, std::string_view jpeg);
/// The map as a scene: outlines and ids of its tags.
FoxgloveMessage MapMessage(const PublishedRun& run, int64_t t_ns);

/// Base 64 (RFC 4648) with padding.
std::string Base64(std::string_view bytes);

}  // namespace tagtwist::internal

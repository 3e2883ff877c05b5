#include "estimator/publish/web/foxglove_client.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>

#include "estimator/publish/json_text.h"

namespace tagtwist::internal {
namespace {

using Json = nlohmann::json;

constexpr size_t kLeastRoom = 64;

// A number that is an id, of an object's key.
std::optional<uint32_t> IdOf(const Json& json) {
  if (!json.is_number_unsigned() || json.get<uint64_t>() > UINT32_MAX) return std::nullopt;
  return json.get<uint32_t>();
}

const Json& Member(const Json& object, const char* key) {
  static const Json none;
  const auto found = object.is_object() ? object.find(key) : object.end();
  return object.is_object() && found != object.end() ? *found : none;
}

template <typename Number>
void Append(Number value, std::string* out) {
  for (size_t i = 0; i < sizeof(Number); ++i) {
    *out += static_cast<char>((static_cast<uint64_t>(value) >> (8 * i)) & 0xff);
  }
}

}  // namespace

std::vector<uint32_t> FoxgloveClient::Take(const std::string& text) {
  std::vector<uint32_t> out;
  const Json said = Json::parse(text, nullptr, /*allow_exceptions=*/false);
  const Json& op = Member(said, "op");
  if (op == "subscribe") {
    for (const Json& wish : Member(said, "subscriptions")) {
      const auto id = IdOf(Member(wish, "id")), channel = IdOf(Member(wish, "channelId"));
      if (!id || !channel || *channel == 0 || *channel > n_channels_) continue;
      if (subscriptions_.size() >= std::max(kLeastRoom, 2 * n_channels_)) break;
      if (subscriptions_.emplace(*id, *channel).second) out.push_back(*channel);
    }
  } else if (op == "unsubscribe") {
    for (const Json& wish : Member(said, "subscriptionIds")) {
      if (const auto id = IdOf(wish)) subscriptions_.erase(*id);
    }
  }
  return out;
}

bool FoxgloveClient::IsSubscribedTo(uint32_t channel) const {
  return std::any_of(subscriptions_.begin(), subscriptions_.end(),
                     [channel](const auto& entry) { return entry.second == channel; });
}

std::vector<std::string> FoxgloveClient::Heads(uint32_t channel, int64_t t_ns) const {
  constexpr uint8_t kMessageData = 1;
  std::vector<std::string> out;
  for (const auto& [id, of_channel] : subscriptions_) {
    if (of_channel != channel) continue;
    std::string head;
    Append(kMessageData, &head);
    Append(id, &head);
    Append(static_cast<uint64_t>(std::max<int64_t>(t_ns, 0)), &head);
    out.push_back(std::move(head));
  }
  return out;
}

std::string FoxgloveServerInfo() {
  return R"({"op":"serverInfo","name":"tagtwist","capabilities":[],"supportedEncodings":["json"]})";
}

std::string FoxgloveAdvertise(const std::vector<FoxgloveChannel>& channels) {
  JsonText json;
  json.Open('{').Key("op").String("advertise").Key("channels").Open('[');
  for (const FoxgloveChannel& channel : channels) {
    json.Open('{').Key("id").Integer(channel.id).Key("topic").String(channel.topic);
    json.Key("encoding").String("json").Key("schemaName").String(channel.schema_name);
    json.Key("schema").String(channel.schema).Key("schemaEncoding").String("jsonschema");
    json.Close('}');
  }
  return json.Close(']').Close('}').text();
}

}  // namespace tagtwist::internal

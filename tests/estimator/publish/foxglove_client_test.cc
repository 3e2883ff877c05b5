#include "estimator/publish/web/foxglove_client.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace tagtwist::internal::foxglove_client_test {
namespace {

TEST(FoxgloveClient, SubscribesAndUnsubscribes) {
  FoxgloveClient client(6);
  const auto taken = client.Take(
      R"({"op":"subscribe","subscriptions":[{"id":7,"channelId":2},{"id":8,"channelId":6}]})");
  EXPECT_EQ(taken, (std::vector<uint32_t>{2, 6}));
  EXPECT_TRUE(client.IsSubscribedTo(2));
  EXPECT_FALSE(client.IsSubscribedTo(1));
  EXPECT_TRUE(client.Take(R"({"op":"unsubscribe","subscriptionIds":[7]})").empty());
  EXPECT_FALSE(client.IsSubscribedTo(2));
  EXPECT_TRUE(client.IsSubscribedTo(6));
}

// Opcode 1, the subscription and the stamp, little-endian.
TEST(FoxgloveClient, MessagesBeginWithTheirHead) {
  FoxgloveClient client(6);
  client.Take(R"({"op":"subscribe","subscriptions":[{"id":258,"channelId":2}]})");
  const auto heads = client.Heads(2, 0x0102030405060708);
  ASSERT_EQ(heads.size(), 1u);
  EXPECT_EQ(heads[0], std::string("\x01\x02\x01\x00\x00\x08\x07\x06\x05\x04\x03\x02\x01", 13));
  EXPECT_TRUE(client.Heads(3, 0).empty());
}

TEST(FoxgloveClient, WhatIsNotUnderstoodIsPassedOver) {
  FoxgloveClient client(6);
  for (const char* text :
       {"", "{", "[]", "null", "7", R"({"op":7})", R"({"op":"subscribe"})",
        R"({"op":"subscribe","subscriptions":7})", R"({"op":"subscribe","subscriptions":[7,null]})",
        R"({"op":"subscribe","subscriptions":[{"id":-1,"channelId":2}]})",
        R"({"op":"subscribe","subscriptions":[{"id":1,"channelId":0}]})",
        R"({"op":"subscribe","subscriptions":[{"id":1,"channelId":7}]})",
        R"({"op":"subscribe","subscriptions":[{"id":1,"channelId":4294967298}]})",
        R"({"op":"subscribe","subscriptions":[{"id":1.5,"channelId":"2"}]})",
        R"({"op":"unsubscribe","subscriptionIds":{"a":1}})", R"({"op":"unsubscribe"})"}) {
    EXPECT_TRUE(client.Take(text).empty()) << text;
  }
  for (uint32_t channel = 0; channel < 9; ++channel) EXPECT_FALSE(client.IsSubscribedTo(channel));
}

TEST(FoxgloveClient, SubscriptionsAreBounded) {
  FoxgloveClient client(6);
  for (int i = 0; i < 1000; ++i) {
    client.Take(R"({"op":"subscribe","subscriptions":[{"id":)" + std::to_string(i) +
                R"(,"channelId":1}]})");
  }
  EXPECT_LE(client.Heads(1, 0).size(), 64u);
}

TEST(FoxgloveClient, ChannelsAreAdvertisedAsJson) {
  const auto said = nlohmann::json::parse(FoxgloveAdvertise(FoxgloveChannels(PublishedRun())));
  EXPECT_EQ(said["op"], "advertise");
  ASSERT_EQ(said["channels"].size(), 6u);
  for (const auto& channel : said["channels"]) {
    EXPECT_EQ(channel["encoding"], "json");
    const auto schema = nlohmann::json::parse(channel["schema"].get<std::string>());
    EXPECT_EQ(schema["type"], "object") << channel["topic"];
    EXPECT_EQ(schema["title"], channel["schemaName"]);
  }
  EXPECT_EQ(nlohmann::json::parse(FoxgloveServerInfo())["op"], "serverInfo");
}

}  // namespace
}  // namespace tagtwist::internal::foxglove_client_test

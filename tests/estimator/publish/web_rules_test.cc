#include "estimator/publish/web/web_rules.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace tagtwist::internal::web_rules_test {
namespace {

WebRequest Of(const std::string& host, const std::string& target = "/") {
  WebRequest out;
  out.host = host;
  out.target = target;
  return out;
}

WebRequest From(const std::string& origin, WebRequest request, bool is_foxglove = false) {
  request.origin = origin;
  request.is_foxglove = is_foxglove;
  return request;
}

TEST(WebRules, WithoutATokenOnlyTheMachinesOwnAddressIsServed) {
  const WebRules rules{"", 8765};
  for (const char* host : {"127.0.0.1:8765", "localhost:8765", "[::1]:8765"}) {
    EXPECT_FALSE(rules.Refusal(Of(host))) << host;
  }
  for (const char* host :
       {"", "127.0.0.1", "127.0.0.1:80", "evil.example:8765", "localhost:87650",
        "127.0.0.1.evil.example:8765", "evil.example", "127.0.0.1:8765:8765", "localhost.:8765"}) {
    EXPECT_TRUE(rules.Refusal(Of(host))) << host;
  }
}

TEST(WebRules, OtherPagesAreRefused) {
  const WebRules rules{"", 8765};
  const WebRequest own = Of("localhost:8765");
  EXPECT_FALSE(rules.Refusal(From("http://localhost:8765", own)));
  for (const char* origin :
       {"http://evil.example", "https://localhost:8765", "http://localhost",
        "http://127.0.0.1:8765", "null", "", "http://localhost:8765.evil.example"}) {
    EXPECT_TRUE(rules.Refusal(From(origin, own))) << origin;
    EXPECT_TRUE(rules.Refusal(From(origin, own, true))) << origin;
  }
}

TEST(WebRules, WithATokenNothingGoesWithoutIt) {
  const WebRules rules{"00112233445566778899aabbccddeeff", 8765};
  const std::string with = "/?token=" + rules.token;
  EXPECT_FALSE(rules.Refusal(Of("192.168.1.7:8765", with)));
  EXPECT_FALSE(rules.Refusal(Of("robot.local:8765", "/?a=b&token=" + rules.token)));
  const std::vector<std::string> bad = {std::string("/"),
                                        std::string("/?token="),
                                        with + "0",
                                        with.substr(0, with.size() - 1),
                                        "/?atoken=" + rules.token,
                                        "/?token=00112233445566778899aabbccddeefe",
                                        "/?token=x&token=" + rules.token,
                                        "/#token=" + rules.token};
  for (const std::string& target : bad) {
    EXPECT_TRUE(rules.Refusal(Of("192.168.1.7:8765", target))) << target;
    EXPECT_TRUE(rules.Refusal(Of("127.0.0.1:8765", target))) << target;
  }
  const WebRequest own = Of("192.168.1.7:8765", with);
  EXPECT_FALSE(rules.Refusal(From("http://192.168.1.7:8765", own)));
  EXPECT_TRUE(rules.Refusal(From("https://app.example", own)));
  EXPECT_FALSE(rules.Refusal(From("https://app.example", own, true)));  // Foxglove's page
}

TEST(WebRules, TargetsAreTakenApart) {
  EXPECT_EQ(PathOf("/a?b=c"), "/a");
  EXPECT_EQ(PathOf("/"), "/");
  EXPECT_EQ(QueryValue("/?a=1&b=2", "b"), "2");
  EXPECT_EQ(QueryValue("/?a=1&b=2", "c"), "");
  EXPECT_EQ(QueryValue("/?&&a", "a"), "");
  EXPECT_EQ(QueryValue("/", "a"), "");
}

TEST(WebRules, TokensAreLongAndDiffer) {
  const std::string one = RandomToken(), other = RandomToken();
  EXPECT_EQ(one.size(), 32u);
  EXPECT_EQ(one.find_first_not_of("0123456789abcdef"), std::string::npos);
  EXPECT_NE(one, other);
}

}  // namespace
}  // namespace tagtwist::internal::web_rules_test

#include "frontend/io/setup/yaml_tree.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <ctime>

namespace tagtwist::internal::yaml_tree_test {
namespace {

using ::testing::HasSubstr;

std::string Fault(const std::string& text) {
  const auto tree = ParseYaml(text, "x.yaml");
  return tree ? "accepted" : tree.error().message;
}

std::string Repeated(const std::string& text, int times) {
  std::string out;
  for (int i = 0; i < times; ++i) out += text;
  return out;
}

TEST(YamlTree, PlacesAreThoseOfTheText) {
  const auto tree = ParseYaml("a:\n  - 1\n  - {b: \"2\"}\nc: ~\n", "x.yaml");
  ASSERT_TRUE(tree) << tree.error().message;
  ASSERT_EQ(tree->members.size(), 2u);
  const YamlValue& list = tree->members[0].second;
  ASSERT_EQ(list.items.size(), 2u);
  EXPECT_EQ(list.line, 1);
  EXPECT_EQ(list.items[0].line, 2);
  EXPECT_FALSE(list.items[0].quoted);
  const YamlValue& b = list.items[1].members[0].second;
  EXPECT_EQ(b.key, "a[1].b");
  EXPECT_EQ(b.scalar, "2");
  EXPECT_TRUE(b.quoted);
  EXPECT_EQ(tree->members[1].second.kind, YamlValue::Kind::kNothing);
}

TEST(YamlTree, AnAliasIsItsValueAtAnotherPlace) {
  const auto tree = ParseYaml("a: &x {b: [1, 2]}\nc: *x\n&k d: *k\n", "x.yaml");
  ASSERT_TRUE(tree) << tree.error().message;
  const YamlValue& c = tree->members[1].second;
  EXPECT_EQ(c.members[0].second.items[1].key, "c.b[1]");
  EXPECT_EQ(c.members[0].second.items[1].scalar, "2");
  EXPECT_EQ(c.line, 2);
  EXPECT_EQ(tree->members[2].second.scalar, "d");
}

TEST(YamlTree, TextThatConsumesNothingEnds) {
  for (const char* text : {",", "[1],", "\xEF\xBB\xBF,x", "]", "a: 1\n,"}) {
    EXPECT_NE(Fault(text), "accepted") << text;
  }
}

TEST(YamlTree, CirclesAreRefused) {
  const char* fault = "an alias of what it is in";
  for (const char* text : {"&a [*a]", "a: &a {b: *a}", "&a {b: [1, {c: *a}]}"}) {
    EXPECT_THAT(Fault(text), HasSubstr(fault)) << text;
  }
  const std::string name(60, 'k');
  EXPECT_THAT(Fault(name + ": &a {" + name + ": *a}"), HasSubstr(fault));
}

TEST(YamlTree, BoundsAreMetBeforeMemoryIsSpent) {
  EXPECT_THAT(Fault(Repeated("[", 100)), HasSubstr("at most 64 levels"));
  EXPECT_THAT(Fault(Repeated("- ", 100) + "1"), HasSubstr("at most 64 levels"));
  EXPECT_THAT(Fault(Repeated("{a: ", 100)), HasSubstr("at most 64 levels"));
  EXPECT_THAT(Fault("[" + Repeated("1,", 300'000) + "1]"), HasSubstr("a smaller file"));
  std::string doubling = "a0: &a0 [1, 1]\n", chain = "b0: &b0 [1]\n";
  for (int i = 1; i < 40; ++i) {
    const std::string n = std::to_string(i), before = std::to_string(i - 1);
    doubling += "a" + n + ": &a" + n + " [*a" + before + ", *a" + before + "]\n";
  }
  for (int i = 1; i < 450; ++i) {
    chain += "b" + std::to_string(i) + ": &b" + std::to_string(i) + " [*b" + std::to_string(i - 1) +
             "]\n";
  }
  EXPECT_THAT(Fault(doubling), HasSubstr("a smaller file"));
  EXPECT_THAT(Fault(chain), HasSubstr("at most 64 levels"));
  // Names as long as they may be printed, in each other, beside many values.
  std::string nested;
  for (int i = 0; i < 60; ++i) nested += "{" + std::string(60, 'k') + ": ";
  EXPECT_THAT(Fault(nested + "[" + Repeated("1,", 150'000)), HasSubstr("a smaller file"));
}

// Ten times the names take ten times the time, not a hundred.
TEST(YamlTree, ManyNamesAreLookedUpQuickly) {
  const auto cpu_time = [](int names) {
    std::string flat;
    for (int i = 0; i < names; ++i) flat += "k" + std::to_string(i) + ": 1\n";
    const std::clock_t began = std::clock();
    EXPECT_EQ(Fault(flat), "accepted");
    return static_cast<double>(std::clock() - began);
  };
  EXPECT_LT(cpu_time(90'000), 40 * cpu_time(9'000));
}

}  // namespace
}  // namespace tagtwist::internal::yaml_tree_test

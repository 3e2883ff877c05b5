#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "frontend/io/setup/yaml_tree.h"

namespace tagtwist::internal::yaml_documents_test {
namespace {

// As rostopic echo prints a message.
TEST(YamlDocuments, AClosingSeparatorIsNoOtherDocument) {
  for (const char* text : {"a: 1\n---\n", "a: 1\n---", "a: 1\n...\n", "---\na: 1\n---\n"}) {
    const auto root = ParseYaml(text, "x");
    ASSERT_TRUE(root) << root.error().message;
    ASSERT_EQ(root->members.size(), 1U) << text;
    EXPECT_EQ(root->members[0].second.scalar, "1");
  }
}

TEST(YamlDocuments, TwoAreRefused) {
  for (const char* text : {"a: 1\n---\nb: 2\n", "a: 1\n---\n---\n[3]\n", "a: 1\n---\n5\n"}) {
    const auto root = ParseYaml(text, "x");
    ASSERT_FALSE(root) << text;
    EXPECT_THAT(root.error().message, ::testing::HasSubstr("expected one YAML document"));
  }
}

}  // namespace
}  // namespace tagtwist::internal::yaml_documents_test

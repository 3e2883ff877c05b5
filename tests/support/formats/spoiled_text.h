#pragma once
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <ostream>
#include <string>

namespace tagtwist::internal {

/// A file's text with one thing wrong in it.
struct BadText {
  const char* name;  // of the test
  const char* text;
  const char* from;  // stands in the text; its first place becomes `to`
  const char* to;
  const char* fault;  // the refusal holds it
};
inline void PrintTo(const BadText& bad, std::ostream* out) { *out << bad.name; }

inline std::string Replaced(std::string text, const std::string& from, const std::string& to) {
  const size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

inline std::string Spoiled(const BadText& bad) { return Replaced(bad.text, bad.from, bad.to); }

/// One line that holds the fault.
inline ::testing::Matcher<const std::string&> NamesTheFault(const BadText& bad) {
  return ::testing::AllOf(::testing::HasSubstr(bad.fault),
                          ::testing::Not(::testing::HasSubstr("\n")));
}

}  // namespace tagtwist::internal

#include "frontend/base/printable.h"

#include <gtest/gtest.h>

namespace tagtwist::internal::printable_test {
namespace {

TEST(Printable, HasNoControlCharacterAndAllElse) {
  EXPECT_EQ(Printable(""), "");
  EXPECT_EQ(Printable("a\nb\tc\x1b[2J\x7f~"), "a?b?c?[2J?~");
  EXPECT_EQ(Printable(std::string("a\0b", 3)), "a?b");
  EXPECT_EQ(Printable("M\xc3\xbcnchen \xe2\x82\xac"), "M\xc3\xbcnchen \xe2\x82\xac");
  EXPECT_EQ(Printable("\xc2\x9b[2J\xc2\xb0"),
            "?[2J\xc2\xb0");  // CSI as one character; a degree sign
  EXPECT_EQ(Printable("cut \xc2"), "cut \xc2");
}

}  // namespace
}  // namespace tagtwist::internal::printable_test

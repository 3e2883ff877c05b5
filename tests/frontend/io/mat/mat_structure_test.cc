#include <gtest/gtest.h>

#include "frontend/io/mat/mat_elements.h"
#include "tests/support/formats/mat_builder.h"
#include "tests/support/temp_folder.h"
#include "tests/support/test_files.h"

namespace tagtwist::internal::mat_structure_test {
namespace {

// A file without compression, of one struct with numbers and text in it.
class MatStructure : public testing::Test {
 protected:
  MatStructure() {
    MatBuilder builder;
    builder.AddPackets(
        {{{"t", MatBuilder::Numbers(1, 3, {1, 2, 3})}, {"name", MatBuilder::Text("abc")}}});
    builder.Write(path_, false);
    whole_ = ReadText(path_);
  }
  std::string Fault(const std::string& bytes) {
    WriteText(path_, bytes);
    const auto checked = CheckMatStructure(path_, "x.mat");
    return checked ? "" : checked.error().message;
  }

  TempFolder folder_;
  std::string path_ = folder_ / "plain.mat";
  std::string whole_;
};

TEST_F(MatStructure, WhatMatioWroteAddsUp) { EXPECT_EQ(Fault(whole_), ""); }

// The 24 bytes of three doubles are the only element of that length.
TEST_F(MatStructure, DataThatAreNotOfTheirDimensionsAreRefused) {
  const std::string tag("\x09\x00\x00\x00\x18\x00\x00\x00", 8);
  const size_t at = whole_.find(tag);
  ASSERT_NE(at, std::string::npos);
  for (const char length : {'\x10', '\x17', '\x19', '\x20'}) {
    std::string bytes = whole_;
    bytes[at + 4] = length;
    EXPECT_EQ(Fault(bytes), "x.mat: damaged: variable 1 does not add up") << int{length};
  }
  std::string bytes = whole_;
  bytes[at + 4] = '\xff', bytes[at + 6] = '\x7f';  // beyond the file
  EXPECT_EQ(Fault(bytes), "x.mat: damaged: variable 1 does not add up");
}

// Refused or not, any byte may be anything: nothing outside the file is read, nothing is endless.
TEST_F(MatStructure, AnySpoiledByteIsRefusedOrPassesInOneLine) {
  int refused = 0;
  for (size_t at = 128; at < whole_.size(); ++at) {
    for (const int flip : {0x01, 0x40, 0xff}) {
      std::string bytes = whole_;
      bytes[at] = static_cast<char>(static_cast<unsigned char>(bytes[at]) ^ flip);
      const std::string fault = Fault(bytes);
      EXPECT_EQ(fault.find('\n'), std::string::npos);
      refused += fault.empty() ? 0 : 1;
    }
  }
  EXPECT_GT(refused, 100);
}

}  // namespace
}  // namespace tagtwist::internal::mat_structure_test

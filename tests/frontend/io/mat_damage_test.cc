// Truncated, damaged and foreign .mat files are refused in one line.
#include "tests/support/formats/mat_fixture.h"

namespace tagtwist::internal::mat_damage_test {
namespace {

using ::testing::StartsWith;

class MatDamage : public MatSource {};

TEST_F(MatDamage, RefusesWhatIsNoMatFile) {
  WriteText(path_, "");
  EXPECT_EQ(Fault(), "empty file");
  WriteText(path_, std::string(1000, 'x'));
  EXPECT_EQ(Fault(), "expected a course .mat, a video or a folder, got neither, or a damaged file");
}

TEST_F(MatDamage, EveryTruncationIsRefused) {
  for (const bool compressed : {true, false}) {
    builder_.AddPackets({Packet(0.5), Packet(0.75)});
    builder_.Add(M::Numbers(1, 1, {0}, "time"));
    builder_.Add(M::Numbers(12, 1, {}, "vicon"));
    builder_.Write(path_, compressed);
    const std::string whole = ReadText(path_);
    size_t variable_ends = 0;
    for (size_t size = 0; size < whole.size(); size += size < 200 ? 1 : 9) {
      WriteText(path_, whole.substr(0, size));
      const std::string fault = Fault();
      if (fault == "read") ++variable_ends;  // before vicon nothing tells that something follows
      if (size > 128 && fault != "read") {
        EXPECT_THAT(fault, ::testing::AnyOf(StartsWith("truncated: "), StartsWith("vicon without")))
            << size;
      }
    }
    EXPECT_LE(variable_ends, 2u);
  }
}

TEST_F(MatDamage, Hdf5FaultsAreToldInOneLine) {
  builder_.AddPackets({Without(Packet(0.5), "t")});
  builder_.Write(path_, true, MAT_FT_MAT73);
  EXPECT_EQ(Fault(), "data: missing field 't'");
  builder_.AddPackets({Packet(0.5), With(Packet(1), "img", M::Text("ab"))});
  builder_.Write(path_, true, MAT_FT_MAT73);
  EXPECT_EQ(Frames().at(1).image_problem, "img: expected an image of bytes, got not a real array");
  const std::string whole = ReadText(path_);
  ::testing::internal::CaptureStderr();
  for (size_t size = 600; size < whole.size(); size += whole.size() / 20) {
    WriteText(path_, whole.substr(0, size));
    EXPECT_EQ(Fault(), "truncated or damaged: no whole HDF5 file") << size;
  }
  WriteText(path_, whole.substr(0, 512) + std::string(5000, 'x'));
  EXPECT_EQ(Fault(), "truncated or damaged: no whole HDF5 file");
  builder_.Add(M::Numbers(1, 1, {0}, "data"));
  builder_.Write(path_, true, MAT_FT_MAT73);
  EXPECT_EQ(Fault(), "no struct variable 'data'");
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "") << "HDF5 prints unless told not to";
}

TEST_F(MatDamage, FlippedBytesNeverCrash) {
  for (const bool compressed : {true, false}) {
    builder_.AddPackets({Packet(0.5, 1), Packet(0.75, 0)});
    builder_.Write(path_, compressed);
    const std::string whole = ReadText(path_);
    for (size_t at = 128; at < whole.size(); at += compressed ? 7 : 1) {
      std::string damaged = whole;
      damaged[at] = static_cast<char>(damaged[at] ^ "\x01\x80\xff"[at % 3]);
      WriteText(path_, damaged);
      const std::string fault = Fault();
      EXPECT_TRUE(!compressed || fault != "read") << "the checksum covers byte " << at;
    }
  }
}

}  // namespace
}  // namespace tagtwist::internal::mat_damage_test

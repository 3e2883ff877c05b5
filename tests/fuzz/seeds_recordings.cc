#include "tests/fuzz/fuzz_file.h"
#include "tests/fuzz/fuzz_target.h"
#include "tests/fuzz/ros1_writer.h"
#include "tests/support/dataset_fixture.h"
#include "tests/support/formats/mat_fixture.h"
#include "tests/support/formats/ros2_writers.h"

namespace tagtwist::internal {
namespace {

std::string TreeOf(DatasetFormat format, bool images) {
  const TempFolder folder;
  WriteRecording(MakeRecording(3, images), folder / "rec", format);
  return PackTree(ReadTree(folder / "rec"));
}

std::vector<FuzzSeed> Mats(mat_ft version) {
  std::vector<FuzzSeed> out;
  for (const bool compressed : {false, true}) {
    const TempFolder folder;
    MatBuilder builder;
    builder.AddPackets({Packet(0.1), Packet(0.2, 0), Packet(0.3, 1)});
    builder.Add(MatBuilder::Numbers(1, 3, {0.1, 0.2, 0.3}, "time"));
    builder.Add(MatBuilder::Numbers(12, 3, std::vector<double>(36, 0.25), "vicon"));
    builder.Write(folder / "x.mat", compressed, version);
    out.push_back({compressed ? "compressed" : "plain", ReadText(std::string(folder / "x.mat"))});
  }
  return out;
}

}  // namespace

std::vector<FuzzSeed> FolderSeeds() {
  return {{"images", TreeOf(DatasetFormat::kFolder, true)},
          {"detections", TreeOf(DatasetFormat::kFolder, false)}};
}

std::vector<FuzzSeed> EurocSeeds() {
  return {{"images", TreeOf(DatasetFormat::kEuroc, true)},
          {"detections", TreeOf(DatasetFormat::kEuroc, false)}};
}

std::vector<FuzzSeed> Mat5Seeds() {
  std::vector<FuzzSeed> out = Mats(MAT_FT_MAT5);
  const TempFolder folder;
  WriteRecording(MakeRecording(3), folder / "own.mat", DatasetFormat::kMat);
  out.push_back({"own", ReadText(std::string(folder / "own.mat"))});
  return out;
}

std::vector<FuzzSeed> Mat73Seeds() { return Mats(MAT_FT_MAT73); }

std::vector<FuzzSeed> McapSeeds() {
  std::vector<FuzzSeed> out;
  for (const char* compression : {"none", "plain", "lz4", "zstd"}) {
    out.push_back({compression, Mcap(compression, Ros2Recording())});
  }
  return out;
}

std::vector<FuzzSeed> SqliteSeeds() {
  const TempFolder folder;
  WriteSqlite(folder / "x.db3", Ros2Recording());
  return {{"sqlite", ReadText(std::string(folder / "x.db3"))}};
}

std::vector<FuzzSeed> BagSeeds() { return {{"plain", Ros1Bag()}}; }

}  // namespace tagtwist::internal

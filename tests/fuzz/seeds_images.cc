#include <opencv2/imgcodecs.hpp>

#include "frontend/io/images/video_file.h"
#include "tests/fuzz/fuzz_file.h"
#include "tests/fuzz/fuzz_target.h"
#include "tests/support/dataset_fixture.h"
#include "tests/support/formats/ros2_writers.h"

namespace tagtwist::internal {

std::vector<FuzzSeed> ImageSeeds() {
  const cv::Mat image = MakeImage(1, 16, 12);
  std::vector<FuzzSeed> out;
  for (const char* ending : {".png", ".jpg", ".bmp", ".tiff", ".webp", ".pgm"}) {
    std::vector<unsigned char> bytes;
    if (!cv::imencode(ending, image, bytes)) continue;
    out.push_back({std::string("image") + ending, {bytes.begin(), bytes.end()}});
  }
  return out;
}

std::vector<FuzzSeed> RawImageSeeds() {
  std::vector<FuzzSeed> out;
  for (char encoding = 0; encoding < 14; ++encoding) {
    // Encoding, then width, height and step with their shifts: 8 x 6 of up to four bytes.
    std::string bytes = {encoding, 8, 0, 0, 0, 0, 6, 0, 0, 0, 0, 32, 0, 0, 0, 0, 0};
    out.push_back({"raw" + std::to_string(encoding), bytes + std::string(6 * 32, '\x55')});
  }
  return out;
}

std::vector<FuzzSeed> MessageSeeds() {
  return {{"image", '\0' + Ros2Image(1, 7)},
          {"imu", '\2' + Ros2Imu(1)},
          {"pose", '\4' + Ros2Pose(1, 2)}};
}

std::vector<FuzzSeed> VideoSeeds() {
  std::vector<FuzzSeed> out;
  for (const char* name : {"video.mp4", "video.avi"}) {
    const TempFolder folder;
    auto video = VideoFile::Create(folder / name, 25, {64, 48});
    if (!video) continue;
    for (int i = 0; i < 4; ++i) {
      cv::Mat colour(48, 64, CV_8UC3, cv::Scalar::all(30 * i));
      (*video)->Add(colour);
    }
    if ((*video)->Finish()) out.push_back({name, ReadText(folder / name)});
  }
  return out;
}

}  // namespace tagtwist::internal

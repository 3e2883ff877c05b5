#include "frontend/io/recordings/rig/rig_source.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/dataset_fixture.h"
#include "tests/support/temp_folder.h"

namespace tagtwist::internal::rig_source_test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

// Frames at those milliseconds, each with one tag.
void WriteFrames(const std::string& path, const std::vector<int64_t>& ms) {
  Recording recording;
  for (const int64_t t : ms) {
    recording.frames.push_back({t * 1'000'000, {}, {MakeTag(3, 0.5)}});
    recording.truth.push_back({t * 1'000'000, Pose(), Twist{}});
  }
  WriteRecording(recording, path, DatasetFormat::kFolder);
}

DataSourceOptions Detections() { return {/*use_detections=*/true, /*read_images=*/false, {}}; }

class RigSourceTest : public testing::Test {
 protected:
  std::string Folder(const std::string& name) const { return folder_.path() + "/" + name; }
  TempFolder folder_;
};

TEST_F(RigSourceTest, FramesOfOneTimeAreOneAndClocksAreUndone) {
  WriteFrames(Folder("a"), {100, 120, 140});
  WriteFrames(Folder("b"), {93, 118, 133});
  const auto source =
      OpenRigSource({{Folder("a"), "", 0}, {Folder("b"), "", 7'000'000}}, Detections());
  ASSERT_TRUE(source) << source.error().message;
  EXPECT_THAT((*source)->stamps_ns(),
              ElementsAre(100'000'000, 120'000'000, 125'000'000, 140'000'000));
  EXPECT_EQ((*source)->ground_truth().front().t_ns, 100'000'000);
  const std::vector<Frame> frames = ReadAllFrames(source->get());
  ASSERT_EQ(frames.size(), 4U);
  EXPECT_EQ(frames[0].camera, 0);
  ASSERT_EQ(frames[0].others.size(), 1U);
  EXPECT_EQ(frames[0].others[0].camera, 1);
  EXPECT_EQ(frames[0].others[0].t_ns, 100'000'000);
  EXPECT_EQ(frames[0].others[0].detections.at(0).camera, 1);
  EXPECT_EQ(frames[1].camera, 0);
  EXPECT_TRUE(frames[1].others.empty());
  EXPECT_EQ(frames[2].camera, 1);
  EXPECT_EQ(frames[2].t_ns, 125'000'000);
  EXPECT_EQ(frames[3].others.size(), 1U);
}

TEST_F(RigSourceTest, ARecordingOfAnotherTimeIsRefused) {
  WriteFrames(Folder("a"), {100, 120, 140});
  WriteFrames(Folder("b"), {93, 118, 133});
  const auto source =
      OpenRigSource({{Folder("a"), "", 0}, {Folder("b"), "", 7'000'000'000}}, Detections());
  ASSERT_FALSE(source);
  EXPECT_THAT(source.error().message, HasSubstr(Folder("b") + ": 7.093 to 7.133 s"));
  EXPECT_THAT(source.error().message, HasSubstr("clock_offset_s"));
}

TEST_F(RigSourceTest, AMissingRecordingIsNamed) {
  WriteFrames(Folder("a"), {100, 120});
  const auto source = OpenRigSource({{Folder("a"), "", 0}, {Folder("none"), "", 0}}, Detections());
  ASSERT_FALSE(source);
  EXPECT_THAT(source.error().message, HasSubstr(Folder("none")));
}

}  // namespace
}  // namespace tagtwist::internal::rig_source_test

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>

#include "tests/support/dataset_fixture.h"
#include "tests/support/temp_folder.h"

namespace tagtwist::internal::dataset_round_trip_test {
namespace {

struct FormatCase {
  DatasetFormat format;
  std::string name;
  int64_t stamp_tolerance_ns;
};

class RoundTrip : public ::testing::TestWithParam<FormatCase> {
 protected:
  std::unique_ptr<DataSource> WriteAndOpen(const Recording& recording,
                                           const DataSourceOptions& options) {
    WriteRecording(recording, path_, GetParam().format);
    auto source = OpenDataSource(path_, options);
    EXPECT_TRUE(source) << source.error().message;
    return source ? std::move(*source) : nullptr;
  }
  TempFolder folder_;
  std::string path_ = folder_ / "recording";
};

void ExpectSameTags(const std::vector<TagDetection>& got, const std::vector<TagDetection>& want) {
  ASSERT_EQ(got.size(), want.size());
  for (size_t k = 0; k < want.size(); ++k) {
    EXPECT_EQ(got[k].id, want[k].id);
    for (size_t c = 0; c < 4; ++c) {
      EXPECT_LT((got[k].corners[c] - want[k].corners[c]).norm(), 1e-12) << k << " " << c;
    }
  }
}

TEST_P(RoundTrip, FramesImagesAndDetections) {
  const Recording recording = MakeRecording(6);
  DataSourceOptions options;
  options.use_detections = true;
  const auto source = WriteAndOpen(recording, options);
  ASSERT_NE(source, nullptr);
  const auto frames = ReadAllFrames(source.get());
  ASSERT_EQ(frames.size(), recording.frames.size());
  ASSERT_EQ(source->stamps_ns().size(), frames.size());
  for (size_t i = 0; i < frames.size(); ++i) {
    EXPECT_LE(std::abs(frames[i].t_ns - recording.frames[i].t_ns), GetParam().stamp_tolerance_ns);
    EXPECT_EQ(frames[i].t_ns, source->stamps_ns()[i]);
    EXPECT_EQ(frames[i].image_problem, "");
    ASSERT_EQ(frames[i].image.size(), recording.frames[i].image.size());
    EXPECT_EQ(frames[i].image.type(), CV_8UC1);
    EXPECT_EQ(cv::norm(frames[i].image, recording.frames[i].image, cv::NORM_INF), 0) << i;
    ExpectSameTags(frames[i].detections, recording.frames[i].detections);
  }
  const auto after_end = source->Next();
  ASSERT_TRUE(after_end);
  EXPECT_FALSE(*after_end);
}

TEST_P(RoundTrip, GroundTruthAndImu) {
  const Recording recording = MakeRecording(6);
  const auto source = WriteAndOpen(recording, {});
  ASSERT_NE(source, nullptr);
  ASSERT_EQ(source->ground_truth().size(), recording.truth.size());
  for (size_t i = 0; i < recording.truth.size(); ++i) {
    const TruthSample &got = source->ground_truth()[i], &want = recording.truth[i];
    EXPECT_LE(std::abs(got.t_ns - want.t_ns), GetParam().stamp_tolerance_ns);
    ASSERT_TRUE(got.twist);
    const StateVector difference =
        Difference({got.world_from_body, *got.twist}, {want.world_from_body, *want.twist});
    EXPECT_LT(difference.norm(), 1e-9) << i;
  }
  ASSERT_EQ(source->imu().size(), recording.imu.size());
  for (size_t i = 0; i < recording.imu.size(); ++i) {
    EXPECT_LE(std::abs(source->imu()[i].t_ns - recording.imu[i].t_ns),
              GetParam().stamp_tolerance_ns);
    EXPECT_LT((source->imu()[i].accel_mps2 - recording.imu[i].accel_mps2).norm(), 1e-12);
    EXPECT_LT((source->imu()[i].gyro_radps - recording.imu[i].gyro_radps).norm(), 1e-12);
  }
}

TEST_P(RoundTrip, OneFrame) {
  const auto source = WriteAndOpen(MakeRecording(1), {});
  ASSERT_NE(source, nullptr);
  const auto frames = ReadAllFrames(source.get());
  ASSERT_EQ(frames.size(), 1u);
  EXPECT_EQ(frames[0].image.size(), cv::Size(40, 30));
  EXPECT_TRUE(frames[0].detections.empty()) << "not asked for";
}

TEST_P(RoundTrip, DetectionsWithoutImages) {
  const Recording recording = MakeRecording(4, /*with_images=*/false);
  DataSourceOptions options;
  options.use_detections = true;
  const auto source = WriteAndOpen(recording, options);
  ASSERT_NE(source, nullptr);
  const auto frames = ReadAllFrames(source.get());
  ASSERT_EQ(frames.size(), 4u);
  for (size_t i = 0; i < frames.size(); ++i) {
    EXPECT_TRUE(frames[i].image.empty());
    EXPECT_EQ(frames[i].image_problem, "");
    ExpectSameTags(frames[i].detections, recording.frames[i].detections);
  }
}

TEST_P(RoundTrip, ImagesAreNotReadWhenNotAskedFor) {
  DataSourceOptions options;
  options.use_detections = true;
  options.read_images = false;
  const auto source = WriteAndOpen(MakeRecording(3), options);
  ASSERT_NE(source, nullptr);
  for (const Frame& frame : ReadAllFrames(source.get())) {
    EXPECT_TRUE(frame.image.empty());
    EXPECT_EQ(frame.image_problem, "");
  }
}

TEST_P(RoundTrip, NothingButFramesIsEnough) {
  Recording recording = MakeRecording(2);
  recording.truth.clear();
  recording.imu.clear();
  for (FrameToWrite& frame : recording.frames) frame.detections.clear();
  const auto source = WriteAndOpen(recording, {});
  ASSERT_NE(source, nullptr);
  EXPECT_TRUE(source->ground_truth().empty());
  EXPECT_TRUE(source->imu().empty());
  EXPECT_EQ(ReadAllFrames(source.get()).size(), 2u);
}

TEST_P(RoundTrip, AppearsWholeOrNotAtAll) {
  {
    auto writer = CreateDatasetWriter(path_, GetParam().format);
    ASSERT_TRUE(writer) << writer.error().message;
    ASSERT_TRUE((*writer)->Add(MakeRecording(1).frames[0]));
    EXPECT_FALSE(std::filesystem::exists(path_));
  }
  EXPECT_EQ(folder_.CountEntries(), 0u) << "an unfinished data set leaves nothing behind";
  WriteRecording(MakeRecording(1), path_, GetParam().format);
  EXPECT_EQ(folder_.CountEntries(), 1u);
}

TEST_P(RoundTrip, RefusesATakenOrBadPath) {
  WriteRecording(MakeRecording(1), path_, GetParam().format);
  const auto taken = CreateDatasetWriter(path_, GetParam().format);
  ASSERT_FALSE(taken);
  EXPECT_THAT(taken.error().message, ::testing::StartsWith(path_ + ": exists already"));
  const std::string nowhere = folder_ / "none/recording";
  const auto bad = CreateDatasetWriter(nowhere, GetParam().format);
  ASSERT_FALSE(bad);
  EXPECT_EQ(bad.error().message, nowhere + ": cannot write: No such file or directory");
}

TEST_P(RoundTrip, WriterRefusesBadFrames) {
  auto writer = CreateDatasetWriter(path_, GetParam().format);
  ASSERT_TRUE(writer);
  EXPECT_FALSE((*writer)->Finish({}, {})) << "no frames";
  const FrameToWrite first = MakeRecording(1).frames[0];
  ASSERT_TRUE((*writer)->Add(first));
  const auto repeated = (*writer)->Add(first);
  ASSERT_FALSE(repeated);
  EXPECT_EQ(repeated.error().message, path_ + ": frame 1: stamp 0.017230033 s repeats");
  FrameToWrite other_size{first.t_ns + 1, MakeImage(0, 41, 30), {}};
  EXPECT_FALSE((*writer)->Add(other_size));
  FrameToWrite colour{first.t_ns + 1, cv::Mat(30, 40, CV_8UC3, cv::Scalar(0)), {}};
  EXPECT_FALSE((*writer)->Add(colour));
}

TEST_P(RoundTrip, SameInputSameBytes) {
  WriteRecording(MakeRecording(3), path_, GetParam().format);
  const std::string again = folder_ / "again";
  WriteRecording(MakeRecording(3), again, GetParam().format);
  if (GetParam().format == DatasetFormat::kMat) {
    EXPECT_EQ(ReadText(path_), ReadText(again));
    return;
  }
  size_t files = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(path_)) {
    if (!entry.is_regular_file()) continue;
    const auto twin = again / std::filesystem::relative(entry.path(), path_);
    EXPECT_EQ(ReadText(entry.path().string()), ReadText(twin.string())) << entry.path();
    ++files;
  }
  EXPECT_EQ(files, 7u);
}

INSTANTIATE_TEST_SUITE_P(Formats, RoundTrip,
                         ::testing::Values(FormatCase{DatasetFormat::kFolder, "Folder", 0},
                                           FormatCase{DatasetFormat::kEuroc, "Euroc", 0},
                                           FormatCase{DatasetFormat::kMat, "Mat", 1}),
                         [](const auto& format) { return format.param.name; });

TEST(DatasetWriter, MatRefusesTruthWithoutTwist) {
  const TempFolder folder;
  Recording recording = MakeRecording(1);
  recording.truth[0].twist.reset();
  auto writer = CreateDatasetWriter(folder / "a.mat", DatasetFormat::kMat);
  ASSERT_TRUE(writer);
  ASSERT_TRUE((*writer)->Add(recording.frames[0]));
  const auto finished = (*writer)->Finish(recording.truth, {});
  ASSERT_FALSE(finished);
  EXPECT_EQ(finished.error().message,
            folder / "a.mat: a .mat has no place for ground truth without twist");
}

TEST(DatasetWriter, PosesAloneMakeTruthWithoutTwist) {
  for (const auto format : {DatasetFormat::kFolder, DatasetFormat::kEuroc}) {
    const TempFolder folder;
    Recording recording = MakeRecording(2);
    for (TruthSample& sample : recording.truth) sample.twist.reset();
    WriteRecording(recording, folder / "a", format);
    const auto source = OpenDataSource(folder / "a", {});
    ASSERT_TRUE(source) << source.error().message;
    ASSERT_EQ((*source)->ground_truth().size(), recording.truth.size());
    for (const TruthSample& sample : (*source)->ground_truth()) EXPECT_FALSE(sample.twist);
  }
}

}  // namespace
}  // namespace tagtwist::internal::dataset_round_trip_test

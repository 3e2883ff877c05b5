// What the plain folder accepts and refuses.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>

#include "frontend/io/images/image_file.h"
#include "tests/support/dataset_fixture.h"
#include "tests/support/temp_folder.h"

namespace tagtwist::internal::folder_source_test {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

// A folder of four frames, all of whose files a test may spoil.
class FolderSource : public ::testing::Test {
 protected:
  void SetUp() override {
    WriteText(folder_ / "timestamps.csv", "t,file\n0.1,0.png\n0.2,1.png\n0.3,2.png\n0.4,3.png\n");
    for (int i = 0; i < 4; ++i) WriteImage(Image(i), MakeImage(i));
  }
  std::string Image(int i) const { return folder_ / (std::to_string(i) + ".png"); }
  std::string Fault() const { return OpenFault(folder_.path()); }
  std::string DetectionsFault() const {
    DataSourceOptions options;
    options.use_detections = true;
    return OpenFault(folder_.path(), options);
  }
  std::vector<Frame> Frames(std::string* fault = nullptr, bool use_detections = false) const {
    DataSourceOptions options;
    options.use_detections = use_detections;
    const auto source = OpenDataSource(folder_.path(), options);
    EXPECT_TRUE(source) << source.error().message;
    return source ? ReadAllFrames(source->get(), fault) : std::vector<Frame>{};
  }
  TempFolder folder_;
};

TEST_F(FolderSource, ReadsFramesInOrder) {
  const auto frames = Frames();
  ASSERT_EQ(frames.size(), 4u);
  EXPECT_EQ(frames[2].t_ns, 300'000'000);
  EXPECT_EQ(frames[2].name, Image(2));
  EXPECT_EQ(cv::norm(frames[2].image, MakeImage(2), cv::NORM_INF), 0);
}

TEST_F(FolderSource, RefusesBadStamps) {
  const std::string table = folder_ / "timestamps.csv";
  WriteText(table, "t,file\n0.1,0.png\n0.1,1.png\n");
  EXPECT_THAT(Fault(), HasSubstr(table + ":3: passed over 1 of 2 rows: 1 stamp repeats"));
  WriteText(table, "t,file\n0.2,0.png\n0.1,1.png\n");
  EXPECT_THAT(Fault(), HasSubstr(table + ":3: passed over 1 of 2 rows: 1 runs backwards"));
  WriteText(table, "t,file\nnan,0.png\n");
  EXPECT_EQ(Fault(), table + ":2: no row has a stamp");
}

TEST_F(FolderSource, RefusesABadTable) {
  const std::string table = folder_ / "timestamps.csv";
  WriteText(table, "");
  EXPECT_EQ(Fault(), table + ": empty file");
  WriteText(table, "t,file\n");
  EXPECT_EQ(Fault(), table + ": no rows");
  WriteText(table, "t,image\n0,0.png\n");
  EXPECT_EQ(Fault(), table + ":1: missing column 'file'");
  WriteText(table, "t,file\n0.1,0.png\n0.2");
  EXPECT_EQ(Fault(), table + ":3: expected 2 columns, got 1");
  WriteText(table, std::string("\x7f"
                               "ELF\0\0\x01\xff\n\x80",
                               10));
  EXPECT_EQ(Fault(), table + ":1: missing column 't'");
}

TEST_F(FolderSource, RefusesAPathThatIsNoDataSet) {
  EXPECT_EQ(OpenFault(folder_ / "none"), folder_ / "none: no such file or folder");
  EXPECT_THAT(OpenFault(Image(0)), HasSubstr("0.png: expected a course .mat, a video or a folder"));
  const TempFolder empty;
  EXPECT_EQ(OpenFault(empty.path()),
            empty.path() +
                ": expected a data set (timestamps.csv, mav0/cam0/data.csv, or images with stamps "
                "for names), got none");
  WriteText(empty / "detections.csv", "t,id\n");
  EXPECT_THAT(OpenFault(empty.path()), StartsWith(empty.path() + ": no timestamps.csv; "));
}

TEST_F(FolderSource, SurvivesASingleBadImage) {
  const std::string png = ReadText(Image(1));
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"", "empty file"},
      {"garbage", "cannot decode, no sound PNG, JPEG, TIFF, BMP, WebP or PNM"},
      {png.substr(0, png.size() / 2), "truncated PNG"},
      {png.substr(0, png.size() - 5), "truncated PNG"},
      {png.substr(0, 100) + "?" + png.substr(101), "damaged PNG"}};
  for (const auto& [bytes, problem] : cases) {
    WriteText(Image(1), bytes);
    ::testing::internal::CaptureStderr();
    const auto frames = Frames();
    EXPECT_EQ(::testing::internal::GetCapturedStderr(), "") << "a library does not print";
    ASSERT_EQ(frames.size(), 4u);
    EXPECT_TRUE(frames[1].image.empty());
    EXPECT_EQ(frames[1].image_problem, problem);
    EXPECT_EQ(frames[1].name, Image(1));
    EXPECT_FALSE(frames[2].image.empty());
  }
  std::filesystem::remove(Image(1));
  const auto frames = Frames();
  ASSERT_EQ(frames.size(), 4u);
  EXPECT_EQ(frames[1].image_problem, "cannot open: No such file or directory");
}

TEST_F(FolderSource, RefusesImagesThatDifferInSize) {
  WriteText(Image(0), "bad, so that the first good one sets the size");
  WriteImage(Image(2), MakeImage(2, 41, 30));
  std::string fault;
  EXPECT_EQ(Frames(&fault).size(), 2u);
  EXPECT_EQ(fault, Image(2) + ": expected 40 x 30 px like " + Image(1) + ", got 41 x 30");
}

TEST_F(FolderSource, RefusesAFolderWithNoImageAtAll) {
  for (int i = 0; i < 4; ++i) std::filesystem::remove(Image(i));
  EXPECT_THAT(Fault(), StartsWith(folder_ / "timestamps.csv:2: none of the images exists"));
}

TEST_F(FolderSource, TurnsColourIntoGrayAndLeavesPixelsInPlace) {
  cv::Mat colour(30, 40, CV_8UC3, cv::Scalar(10, 100, 200));
  ASSERT_TRUE(cv::imwrite(Image(0), colour));
  const auto frames = Frames();
  ASSERT_EQ(frames.at(0).image.type(), CV_8UC1);
  EXPECT_NEAR(frames[0].image.at<uchar>(3, 5), 0.114 * 10 + 0.587 * 100 + 0.299 * 200, 1.0);
}

TEST_F(FolderSource, AttachesDetectionsByStamp) {
  WriteText(folder_ / "detections.csv",
            "t,id,u1,v1,u2,v2,u3,v3,u4,v4\n"
            "0.1,7,1,2,3,4,5,6,7,8\n0.1,7,1,2,3,4,5,6,7,8\n"
            "0.3000005,3,1.5,2,3,4,5,6,7,-8e-1\n");
  const auto frames = Frames(nullptr, true);
  ASSERT_EQ(frames.size(), 4u);
  EXPECT_EQ(frames[0].detections.size(), 2u) << "a repeated id is not this reader's to judge";
  EXPECT_TRUE(frames[1].detections.empty());
  ASSERT_EQ(frames[2].detections.size(), 1u);
  EXPECT_EQ(frames[2].t_ns, 300'000'000) << "the frame's stamp stands";
  EXPECT_EQ(frames[2].detections[0].id, 3);
  EXPECT_EQ(frames[2].detections[0].corners[0], Eigen::Vector2d(1.5, 2));
  EXPECT_EQ(frames[2].detections[0].corners[3], Eigen::Vector2d(7, -0.8));
  EXPECT_FALSE(frames[2].image.empty()) << "images are there for the tracks";
}

TEST_F(FolderSource, DetectionsStandForAMissingTable) {
  std::filesystem::remove(folder_ / "timestamps.csv");
  WriteText(folder_ / "detections.csv",
            "t,id,u1,v1,u2,v2,u3,v3,u4,v4\n0.1,7,1,2,3,4,5,6,7,8\n0.1,8,1,2,3,4,5,6,7,8\n"
            "0.2,7,1,2,3,4,5,6,7,8\n");
  const auto frames = Frames(nullptr, true);
  ASSERT_EQ(frames.size(), 2u);
  EXPECT_EQ(frames[0].detections.size(), 2u);
  EXPECT_EQ(frames[1].t_ns, 200'000'000);
  EXPECT_EQ(frames[1].name, folder_ / "detections.csv:4");
  EXPECT_EQ(frames[1].image_problem, "");
}

TEST_F(FolderSource, RefusesBadDetections) {
  const std::string path = folder_ / "detections.csv";
  const std::string header = "t,id,u1,v1,u2,v2,u3,v3,u4,v4\n";
  const std::string good = "0.1,7,1,2,3,4,5,6,7,8\n";
  EXPECT_EQ(DetectionsFault(), path + ": cannot open: No such file or directory");
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"", ": empty file"},
      {"t,id,u1,v1\n", ":1: missing column 'u2'"},
      {header + good + "0.2,7,1,2,3,4,5\n", ":3: expected 10 columns, got 7"},
      {header + "0.15,7,1,2,3,4,5,6,7,8\n", ":2: stamp 0.150000000 s is no frame's"},
      {header + good + "0.2,x,1,2,3,4,5,6,7,8\n", ":3: id: expected an integer, got 'x'"},
      {header + "0.1,-1,1,2,3,4,5,6,7,8\n", ":2: id: expected a tag id >= 0, got -1"},
      {header + "0.1,1,1,2,3,4,5,6,7,inf\n", ":2: v4: expected a finite number, got 'inf'"},
      {header + "0.2,7,1,2,3,4,5,6,7,8\n" + good,
       ":3: passed over 1 of 2 rows: 1 runs backwards (the first: line 3), too few are left"}};
  for (const auto& [text, fault] : cases) {
    WriteText(path, text);
    EXPECT_EQ(DetectionsFault(), path + fault);
    EXPECT_EQ(Fault(), "opened") << "not read when not asked for";
  }
  std::filesystem::remove(folder_ / "timestamps.csv");
  WriteText(path, header);
  EXPECT_EQ(DetectionsFault(), path + ": no rows");
}

TEST_F(FolderSource, RefusesBadImuAndGroundTruth) {
  const std::string imu = folder_ / "imu.csv", truth = folder_ / "ground_truth.csv";
  WriteText(imu, "t,ax,ay,az,gx,gy,gz\n0,1,2,3,4,5,6\n0,1,2,3,4,5,6\n");
  EXPECT_THAT(Fault(), HasSubstr(imu + ":3: passed over 1 of 2 rows: 1 stamp repeats"));
  WriteText(imu, "t,ax,ay,az,gx,gy,gz\n0,1,2,3,4,5,\n");
  EXPECT_EQ(Fault(), imu + ":2: gz: expected a finite number, got ''");
  std::filesystem::remove(imu);
  WriteText(truth, "t,x,y,z,qx,qy,qz\n0,1,2,3,0,0,0\n");
  EXPECT_THAT(Fault(), HasSubstr(truth + ":1: missing column 'qx', 'qy', 'qz' or 'qw'"));
}

TEST(ImageFile, TellsATruncatedJpeg) {
  std::vector<unsigned char> bytes;
  ASSERT_TRUE(cv::imencode(".jpg", MakeImage(0, 400, 300), bytes));
  const std::string whole(bytes.begin(), bytes.end());
  EXPECT_TRUE(DecodeGrayImage(whole));
  EXPECT_TRUE(DecodeGrayImage(whole + "appended by a camera"));
  for (const size_t size : {whole.size() / 2, whole.size() - 1, size_t{100}, size_t{3}}) {
    const auto cut = DecodeGrayImage(whole.substr(0, size));
    ASSERT_FALSE(cut) << size;
    EXPECT_EQ(cut.error().message, "truncated JPEG");
  }
}

TEST(ImageFile, ADamagedSizeAsksForNoMemory) {
  const auto png = EncodePng(MakeImage(0));
  ASSERT_TRUE(png);
  std::string huge = *png;
  huge[16] = '\x7f';
  EXPECT_FALSE(DecodeGrayImage(huge));
}

TEST(RealDataFolder, CourseFramesAndFloorMat) {
  const std::string root = TAGTWIST_REAL_DATA_DIR;
  if (!std::filesystem::exists(root)) GTEST_SKIP() << "no real data at " << root;
  struct Case {
    std::string folder;
    size_t frames, tags, truth, imu;
    cv::Size size;
  };
  for (const Case& set : {Case{"course-dataset4-frames", 61, 868, 61, 0, {376, 240}},
                          Case{"umd-floor-mat", 450, 18520, 0, 2220, {576, 576}}}) {
    DataSourceOptions options;
    options.use_detections = true;
    const auto source = OpenDataSource(root + "/" + set.folder, options);
    ASSERT_TRUE(source) << source.error().message;
    EXPECT_EQ((*source)->ground_truth().size(), set.truth);
    EXPECT_EQ((*source)->imu().size(), set.imu);
    const auto frames = ReadAllFrames(source->get());
    EXPECT_EQ(frames.size(), set.frames);
    size_t tags = 0;
    for (const Frame& frame : frames) {
      tags += frame.detections.size();
      EXPECT_EQ(frame.image_problem, "") << frame.name;
      EXPECT_EQ(frame.image.size(), set.size) << frame.name;
    }
    EXPECT_EQ(tags, set.tags);
  }
}

}  // namespace
}  // namespace tagtwist::internal::folder_source_test

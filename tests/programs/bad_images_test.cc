// Recordings whose images are bad, as tagtwist_estimate meets them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "frontend/io/tables/csv.h"
#include "tests/support/program_test_util.h"
#include "tests/support/test_files.h"

namespace tagtwist::internal::bad_images_test {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::StartsWith;

class BadImages : public ::testing::Test {
 protected:
  BadImages() {
    MakeRecording(folder_.path(), "rec", DatasetFormat::kFolder, true);
    const auto table = CsvTable::Read(folder_ / "rec/timestamps.csv");
    if (!table) throw std::runtime_error(table.error().message);
    const auto file = table->FindColumn("file");
    for (size_t row = 0; row < table->rows(); ++row) {
      images_.push_back(folder_ / ("rec/" + std::string(table->Cell(row, *file))));
    }
  }

  ProgramRun Estimate(const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments = {"--dataset", "rec", "--output", "out"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return RunProgram(folder_.path(), "tagtwist_estimate", arguments);
  }
  void ExpectRefusal(const std::string& fault) const {
    const ProgramRun run = Estimate();
    EXPECT_EQ(run.status, 1) << run.err;
    EXPECT_TRUE(IsOneLine(run.err)) << run.err;
    EXPECT_THAT(run.err, StartsWith("tagtwist_estimate: "));
    EXPECT_THAT(run.err, HasSubstr(fault));
    EXPECT_TRUE(HasNoResults(folder_ / "out"));
  }
  // One line on stderr that holds `fault`, all frames estimated, frame 3 from its neighbours.
  void ExpectSurvival(const std::string& fault, const std::vector<std::string>& more = {}) const {
    const ProgramRun run = Estimate(more);
    EXPECT_EQ(run.status, 0) << run.err;
    EXPECT_TRUE(IsOneLine(run.err)) << run.err;
    EXPECT_THAT(run.err, HasSubstr(fault));
    const auto states = CsvTable::Read(folder_ / "out/states.csv");
    ASSERT_TRUE(states) << states.error().message;
    ASSERT_EQ(states->rows(), images_.size());
    const auto status = states->FindColumn("status");
    ASSERT_TRUE(status);
    for (size_t row = 0; row < states->rows(); ++row) {
      EXPECT_EQ(states->Cell(row, *status), row == 3 ? "predicted" : "ok") << row;
    }
  }

  TempFolder folder_;
  std::vector<std::string> images_;
};

TEST_F(BadImages, GoodOnesPassWithoutAWord) {
  const ProgramRun run = Estimate();
  EXPECT_EQ(run.status, 0);
  EXPECT_EQ(run.err, "");
}

TEST_F(BadImages, OneOfGarbageIsToldOnceAndSurvived) {
  WriteText(images_[3], Garbage());
  ExpectSurvival(fs::path(images_[3]).filename().string());
}

TEST_F(BadImages, OneOfGarbageIsToldOnceAndSurvivedByTheWindow) {
  WriteText(images_[3], Garbage());
  ExpectSurvival(fs::path(images_[3]).filename().string(), {"--sliding_window"});
}

TEST_F(BadImages, OneThatIsCutIsToldOnceAndSurvived) {
  Truncate(images_[3], 100);
  ExpectSurvival(fs::path(images_[3]).filename().string());
}

TEST_F(BadImages, OneThatIsEmptyIsToldOnceAndSurvived) {
  Truncate(images_[3], 0);
  ExpectSurvival(fs::path(images_[3]).filename().string());
}

TEST_F(BadImages, OneThatIsMissingIsToldOnceAndSurvived) {
  fs::remove(images_[3]);
  ExpectSurvival(fs::path(images_[3]).filename().string());
}

TEST_F(BadImages, AllOfGarbageAreRefused) {
  for (const std::string& image : images_) WriteText(image, Garbage());
  ExpectRefusal(fs::path(images_[0]).filename().string());
}

TEST_F(BadImages, AllMissingAreRefused) {
  for (const std::string& image : images_) fs::remove(image);
  ExpectRefusal("none of the images exists");
}

TEST_F(BadImages, AllWithoutATagAreRefused) {
  for (const std::string& image : images_) {
    cv::imwrite(image, cv::Mat(240, 376, CV_8UC1, cv::Scalar(90)));
  }
  ExpectRefusal("rec: no frame shows a tag of the map");
}

TEST_F(BadImages, OneOfAnotherSizeIsRefused) {
  cv::imwrite(images_[3], cv::Mat(120, 188, CV_8UC1, cv::Scalar(90)));
  ExpectRefusal("expected 376 x 240 px");
}

TEST_F(BadImages, AllOfAnotherSizeThanTheCamerasAreRefused) {
  for (const std::string& image : images_) {
    cv::Mat half;
    cv::resize(cv::imread(image, cv::IMREAD_GRAYSCALE), half, {}, 0.5, 0.5);
    cv::imwrite(image, half);
  }
  ExpectRefusal("376 x 240");
}

}  // namespace
}  // namespace tagtwist::internal::bad_images_test

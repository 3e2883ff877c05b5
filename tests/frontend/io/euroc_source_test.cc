// What the EuRoC/ASL folder accepts and refuses.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "tests/support/dataset_fixture.h"
#include "tests/support/temp_folder.h"

namespace tagtwist::internal::euroc_source_test {
namespace {

using ::testing::HasSubstr;

class EurocSource : public ::testing::Test {
 protected:
  void SetUp() override {
    const std::string mav = folder_ / "mav0/";
    for (const char* sub : {"cam0/data", "imu0", "state_groundtruth_estimate0", "tags0"}) {
      std::filesystem::create_directories(mav + sub);
    }
    WriteText(frames_,
              "#timestamp [ns],filename\r\n1403636579763555527,a.png\r\n"
              "1403636579813555527,b.png\r\n");
    WriteImage(mav + "cam0/data/a.png", MakeImage(0));
    WriteImage(mav + "cam0/data/b.png", MakeImage(1));
  }
  std::string Truth(const std::string& rows) const {
    return "#timestamp, p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w [], q_RS_x [], q_RS_y "
           "[], q_RS_z [], v_RS_R_x [m s^-1], v_RS_R_y [m s^-1], v_RS_R_z [m s^-1], b_w_RS_S_x "
           "[rad s^-1], b_w_RS_S_y [rad s^-1], b_w_RS_S_z [rad s^-1]\n" +
           rows;
  }
  TempFolder folder_;
  const std::string frames_ = folder_ / "mav0/cam0/data.csv";
  const std::string imu_ = folder_ / "mav0/imu0/data.csv";
  const std::string truth_ = folder_ / "mav0/state_groundtruth_estimate0/data.csv";
  const std::string tags_ = folder_ / "mav0/tags0/data.csv";
};

TEST_F(EurocSource, OpensTheFolderAndTheOneInside) {
  for (const std::string& path : {folder_.path(), folder_ / "mav0"}) {
    const auto source = OpenDataSource(path, {});
    ASSERT_TRUE(source) << source.error().message;
    const auto frames = ReadAllFrames(source->get());
    ASSERT_EQ(frames.size(), 2u);
    EXPECT_EQ(frames[1].t_ns, 1403636579813555527);
    EXPECT_EQ(cv::norm(frames[1].image, MakeImage(1), cv::NORM_INF), 0);
  }
}

TEST_F(EurocSource, OpensEachOfItsCameras) {
  const std::string second = folder_ / "mav0/cam1";
  std::filesystem::create_directories(second + "/data");
  WriteText(second + "/data.csv", "#timestamp [ns],filename\n1403636579763555530,c.png\n");
  WriteImage(second + "/data/c.png", MakeImage(2));
  WriteText(truth_, Truth("1403636579763555530,1,2,3,1,0,0,0,4,5,6,0,0,0\n"));
  for (const std::string& path : {second, second + "/"}) {
    const auto source = OpenDataSource(path, {});
    ASSERT_TRUE(source) << source.error().message;
    EXPECT_EQ((*source)->ground_truth().size(), 1u);
    const auto frames = ReadAllFrames(source->get());
    ASSERT_EQ(frames.size(), 1u);
    EXPECT_EQ(cv::norm(frames[0].image, MakeImage(2), cv::NORM_INF), 0);
  }
  std::filesystem::create_directories(folder_ / "mav0/tags1");
  WriteText(folder_ / "mav0/tags1/data.csv",
            "#timestamp [ns],id,u1,v1,u2,v2,u3,v3,u4,v4\n"
            "1403636579763555530,7,1,2,3,4,5,6,7,8\n");
  DataSourceOptions options;
  options.use_detections = true;
  const auto source = OpenDataSource(second, options);
  ASSERT_TRUE(source) << source.error().message;
  EXPECT_EQ(ReadAllFrames(source->get()).at(0).detections.at(0).id, 7);
}

TEST_F(EurocSource, TakesTheRateFromTheGyroLessItsBias) {
  WriteText(imu_,
            "#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad s^-1],"
            "a_RS_S_x [m s^-2],a_RS_S_y [m s^-2],a_RS_S_z [m s^-2]\n"
            "1000000000,1,2,3,4,5,6\n1005000000,7,8,9,10,11,12\n");
  WriteText(truth_, Truth("1004000000,1,2,3,1,0,0,0,4,5,6,0.5,0.25,0.125\n"
                          "1100000000,1,2,3,0.9987502603949663,0,0,0.04997916927067833,4,5,6,0,0,"
                          "0\n"));
  const auto source = OpenDataSource(folder_.path(), {});
  ASSERT_TRUE(source) << source.error().message;
  ASSERT_EQ((*source)->imu().size(), 2u);
  EXPECT_EQ((*source)->imu()[0].gyro_radps, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ((*source)->imu()[0].accel_mps2, Eigen::Vector3d(4, 5, 6));
  const auto& truth = (*source)->ground_truth();
  ASSERT_EQ(truth.size(), 2u);
  EXPECT_EQ(truth[0].twist->v_world, Eigen::Vector3d(4, 5, 6));
  EXPECT_EQ(truth[0].twist->omega_body, Eigen::Vector3d(6.5, 7.75, 8.875));
  const Eigen::Vector3d differenced(0, 0, 0.1 / 0.096);  // no IMU near: 0.1 rad in 96 ms
  EXPECT_LT((truth[1].twist->omega_body - differenced).norm(), 1e-9);
}

TEST_F(EurocSource, TakesDetectionsOfItsOwn) {
  WriteText(tags_,
            "#timestamp [ns],id,u1,v1,u2,v2,u3,v3,u4,v4\n"
            "1403636579813555527,5,1,2,3,4,5,6,7,8\n");
  DataSourceOptions options;
  options.use_detections = true;
  const auto source = OpenDataSource(folder_.path(), options);
  ASSERT_TRUE(source) << source.error().message;
  const auto frames = ReadAllFrames(source->get());
  ASSERT_EQ(frames.size(), 2u);
  ASSERT_EQ(frames[1].detections.size(), 1u);
  EXPECT_EQ(frames[1].detections[0].id, 5);
}

TEST_F(EurocSource, RefusesBadFiles) {
  WriteText(truth_, Truth("1,1,2,3,0.5,0,0,0,4,5,6,0,0,0\n"));
  EXPECT_THAT(OpenFault(folder_.path()),
              HasSubstr(truth_ + ":2: quaternion: expected unit norm, got 0.5 ("));
  WriteText(truth_, "#timestamp [ns],p_RS_R_x [m]\n1,2\n");
  EXPECT_EQ(OpenFault(folder_.path()), truth_ + ":1: missing column 'p_RS_R_y'");
  WriteText(imu_, "#timestamp [ns],w_RS_S_x\n1.5,2\n");
  EXPECT_EQ(OpenFault(folder_.path()), imu_ + ":1: missing column 'a_RS_S_x'");
  WriteText(frames_, "#timestamp [ns],filename\n1.5,a.png\n");
  EXPECT_EQ(OpenFault(folder_.path()), frames_ + ":2: timestamp: expected an integer, got '1.5'");
}

}  // namespace
}  // namespace tagtwist::internal::euroc_source_test

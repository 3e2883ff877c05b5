#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "frontend/io/tables/csv.h"
#include "frontend/io/trajectories/trajectory_file.h"
#include "frontend/io/trajectories/vicon.h"
#include "tests/support/dataset_fixture.h"
#include "tests/support/temp_folder.h"

namespace tagtwist::internal::ground_truth_io_test {
namespace {

using ::testing::HasSubstr;

using ::testing::StartsWith;

class GroundTruthIo : public ::testing::Test {
 protected:
  std::vector<TruthSample> Read(const std::string& text) {
    WriteText(path_, text);
    auto truth = ReadGroundTruth(path_);
    EXPECT_TRUE(truth) << truth.error().message;
    return truth ? *truth : std::vector<TruthSample>{};
  }
  // Without the path at its head.
  std::string Fault(const std::string& text) {
    WriteText(path_, text);
    const auto truth = ReadGroundTruth(path_);
    if (truth) return "read";
    EXPECT_THAT(truth.error().message, StartsWith(path_));
    return truth.error().message.substr(path_.size());
  }
  TempFolder folder_;
  const std::string path_ = folder_ / "truth";
};

void ExpectSameTruth(const std::vector<TruthSample>& got, const std::vector<TruthSample>& want,
                     bool with_twist) {
  ASSERT_EQ(got.size(), want.size());
  for (size_t i = 0; i < want.size(); ++i) {
    EXPECT_EQ(got[i].t_ns, want[i].t_ns);
    ASSERT_EQ(got[i].twist.has_value(), with_twist);
    const Twist none;
    const StateVector difference =
        Difference({got[i].world_from_body, with_twist ? *got[i].twist : none},
                   {want[i].world_from_body, with_twist ? *want[i].twist : none});
    EXPECT_LT(difference.norm(), 1e-12) << i;
  }
}

TEST_F(GroundTruthIo, CsvRoundTrip) {
  const auto truth = MakeRecording(5).truth;
  ExpectSameTruth(Read(FormatGroundTruthCsv(truth)), truth, true);
}

TEST_F(GroundTruthIo, TumRoundTrip) {
  const auto truth = MakeRecording(5).truth;
  const std::string text = FormatTum(truth);
  EXPECT_THAT(text, StartsWith("# t x y z qx qy qz qw\n0.000000003 0.3333333333333333 0 -1.5 "));
  ExpectSameTruth(Read(text), truth, false);
}

TEST_F(GroundTruthIo, TumTakesCommentsTabsAndExponents) {
  const auto truth = Read("# t, x, y\n\n1e0\t1 2 3e-1  0 0 0 1 \r\n2 1 2 3 0 0 0 1");
  ASSERT_EQ(truth.size(), 2u);
  EXPECT_EQ(truth[0].t_ns, 1'000'000'000);
  EXPECT_EQ(Eigen::Vector3d(truth[0].world_from_body.translation()), Eigen::Vector3d(1, 2, 0.3));
}

TEST_F(GroundTruthIo, ColumnsInAnyOrderWithOthersBetween) {
  const auto truth = Read(
      "wz,t,roll,x,y,z,qw,qx,qy,qz,vx,vy,vz,wx,wy\n"
      "9,0.5,7,1,2,3,1.001,0,0,0,4,5,6,7,8\n");
  ASSERT_EQ(truth.size(), 1u);
  EXPECT_EQ(truth[0].t_ns, 500'000'000);
  EXPECT_EQ(Eigen::Vector3d(truth[0].world_from_body.translation()), Eigen::Vector3d(1, 2, 3));
  EXPECT_DOUBLE_EQ(truth[0].world_from_body.rotation().norm(), 1.0) << "normalised";
  ASSERT_TRUE(truth[0].twist);
  EXPECT_EQ(truth[0].twist->v_world, Eigen::Vector3d(4, 5, 6));
  EXPECT_EQ(truth[0].twist->omega_body, Eigen::Vector3d(7, 8, 9));
}

TEST_F(GroundTruthIo, EurocFileAloneHasRatesFromTheAttitude) {
  const auto truth = Read(
      "#timestamp,p_RS_R_x [m],p_RS_R_y [m],p_RS_R_z [m],q_RS_w [],q_RS_x [],q_RS_y [],"
      "q_RS_z [],v_RS_R_x [m s^-1],v_RS_R_y [m s^-1],v_RS_R_z [m s^-1]\n"
      "1000000000,1,2,3,1,0,0,0,4,5,6\n"
      "1100000000,1,2,3,0.9987502603949663,0.04997916927067833,0,0,4,5,6\n");
  ASSERT_EQ(truth.size(), 2u);
  ASSERT_TRUE(truth[1].twist);
  EXPECT_EQ(truth[1].twist->v_world, Eigen::Vector3d(4, 5, 6));
  EXPECT_LT((truth[1].twist->omega_body - Eigen::Vector3d(1, 0, 0)).norm(), 1e-9);
}

TEST_F(GroundTruthIo, MatHasItInVicon) {
  const Recording recording = MakeRecording(3);
  WriteRecording(recording, folder_ / "a.mat", DatasetFormat::kMat);
  const auto truth = ReadGroundTruth(folder_ / "a.mat");
  ASSERT_TRUE(truth) << truth.error().message;
  EXPECT_EQ(truth->size(), recording.truth.size());
  Recording bare = recording;
  bare.truth.clear();
  WriteRecording(bare, folder_ / "b.mat", DatasetFormat::kMat);
  const auto none = ReadGroundTruth(folder_ / "b.mat");
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().message, folder_ / "b.mat: no ground truth: no variable 'vicon'");
}

TEST_F(GroundTruthIo, RefusesBadCsv) {
  const std::string header = "t,x,y,z,qx,qy,qz,qw\n", row = "0,1,2,3,0,0,0,1\n";
  EXPECT_EQ(Fault(""), ": empty file");
  EXPECT_THAT(Fault(header), HasSubstr(": no rows"));
  EXPECT_THAT(Fault("t,x,y,z,qx,qy,qz\n0,1,2,3,0,0,0\n"),
              HasSubstr(":1: missing column 'qx', 'qy'"));
  EXPECT_THAT(Fault(header + row + row), HasSubstr(":3: 1 of 2 rows whose stamp repeats"));
  EXPECT_THAT(Fault(header + "1,1,2,3,0,0,0,1\n" + row),
              HasSubstr(":3: 1 of 2 rows whose stamp runs backwards"));
  EXPECT_THAT(Fault(header + "0,1,2,nan,0,0,0,1\n"), HasSubstr(":2: 1 of 1 rows without numbers"));
  EXPECT_THAT(Fault(header + "0,1,2,3,0,0,0,1.02\n"),
              HasSubstr(":2: quaternion: expected unit norm, got 1.02 (are these its columns?"));
  EXPECT_THAT(Fault(header + "0,1,2,3,0,0,0,0\n"),
              HasSubstr(":2: 1 of 1 rows with a quaternion of zero"));
}

TEST_F(GroundTruthIo, RefusesBadTum) {
  EXPECT_THAT(Fault("# nothing\n"), HasSubstr(":1: no rows"));
  EXPECT_THAT(Fault("0 1 2 3 0 0 0\n"), HasSubstr(":1: expected t x y z qx qy qz qw"));
  EXPECT_THAT(Fault("# c\n0 1 2 3 0 0 0 1\n0 1 2 3 0 0 0 1\n"),
              HasSubstr(":3: 1 of 2 rows whose stamp"));
  EXPECT_THAT(Fault("x 1 2 3 0 0 0 1\n"), HasSubstr(":1: no rows"));
  EXPECT_EQ(Fault("0 1 2 inf 0 0 0 1\n"), ":1: expected a finite number, got 'inf'");
  EXPECT_THAT(Fault("0 1 2 3 0 0 0 2\n"), HasSubstr(":1: quaternion: expected unit norm, got 2 ("));
}

TEST_F(GroundTruthIo, RefusesWhatIsNotThere) {
  const auto missing = ReadGroundTruth(folder_ / "none");
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().message, folder_ / "none: cannot open: No such file or directory");
  EXPECT_FALSE(ReadGroundTruth(folder_.path()));
}

TEST(Vicon, EulerOrderIsZxy) {
  // By hand: yaw 90 deg turns the body's x to the world's y; roll about the turned x, pitch last.
  const double quarter = std::acos(0.0);
  const auto near = [](const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
    return (a - b).norm() < 1e-12;
  };
  EXPECT_TRUE(near(RotationFromZxy({0, 0, quarter}) * Eigen::Vector3d(1, 0, 0), {0, 1, 0}));
  EXPECT_TRUE(near(RotationFromZxy({quarter, 0, quarter}) * Eigen::Vector3d(0, 1, 0), {0, 0, 1}));
  // Pitch moves x to -z of the rolled frame, which roll 90 deg has turned to the world's +y.
  EXPECT_TRUE(near(RotationFromZxy({quarter, quarter, 0}) * Eigen::Vector3d(1, 0, 0), {0, 1, 0}));
}

TEST(Vicon, AnglesAndRotationsAreInverse) {
  for (const Eigen::Vector3d& angles :
       {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(-0.11, 0.3, -3.1), Eigen::Vector3d(1.5, -3, 2),
        Eigen::Vector3d(-1.57, 0.1, 0.2)}) {
    EXPECT_LT((ZxyFromRotation(RotationFromZxy(angles)) - angles).norm(), 1e-9)
        << angles.transpose();
  }
  const double quarter = std::acos(0.0);
  const Eigen::Quaterniond locked = RotationFromZxy({quarter, 0.3, 0.4});
  EXPECT_LT(RotationFromZxy(ZxyFromRotation(locked)).angularDistance(locked), 1e-7);
}

TEST(RealDataGroundTruth, ViconFilesAgreeWithTheEulerOrder) {
  const std::string root = TAGTWIST_REAL_DATA_DIR;
  if (!std::filesystem::exists(root)) GTEST_SKIP() << "no real data at " << root;
  for (const auto& [file, samples] :
       {std::pair{"/course/vicon_dataset1.csv", 1768}, {"/course/vicon_dataset4.csv", 759}}) {
    const auto truth = ReadGroundTruth(root + file);
    ASSERT_TRUE(truth) << truth.error().message;
    EXPECT_EQ(truth->size(), static_cast<size_t>(samples));
    const auto table = CsvTable::Read(root + file);
    ASSERT_TRUE(table);
    const auto angles = table->RequireColumns({"roll", "pitch", "yaw"});
    ASSERT_TRUE(angles);
    for (size_t row = 0; row < truth->size(); row += 50) {
      const auto n = table->Numbers(row, *angles);
      ASSERT_TRUE(n);
      const Eigen::Quaterniond q = RotationFromZxy(Eigen::Vector3d(n->data()));
      EXPECT_LT(q.angularDistance((*truth)[row].world_from_body.rotation()), 1e-6) << row;
    }
    EXPECT_TRUE((*truth)[0].twist);
  }
}

}  // namespace
}  // namespace tagtwist::internal::ground_truth_io_test

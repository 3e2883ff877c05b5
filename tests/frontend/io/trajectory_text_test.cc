// Trajectories as other programs write them: each form read to the same poses, each fault told.
#include "frontend/io/trajectories/trajectory_text.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cstdio>

#include "frontend/types/so3.h"
#include "tests/support/temp_folder.h"
#include "tests/support/test_files.h"

namespace tagtwist::internal::trajectory_text_test {
namespace {

using ::testing::HasSubstr;

constexpr int kSamples = 5;

std::string Printf(const char* format, double value) {
  char text[64];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

double TimeOf(int i) { return 0.25 + 0.1 * i; }
Eigen::Vector3d PositionOf(int i) { return {1.5 + 0.1 * i, -0.25 * i, 1.25}; }
Eigen::Quaterniond AttitudeOf(int i) { return ExpSo3(Eigen::Vector3d(0.1 * i, 0.3, -0.2)); }

// Rows of "t x y z" and the quaternion in that order, apart by `separator`, times in units of
// `per_second` to the second.
std::string Rows(const std::string& separator, const std::string& order, double per_second = 1,
                 const char* stamp_format = "%.9f", double position_scale = 1) {
  std::string out;
  for (int i = 0; i < kSamples; ++i) {
    out += Printf(stamp_format, per_second * TimeOf(i));
    for (const double x : PositionOf(i)) out += separator + Printf("%.12g", position_scale * x);
    const Eigen::Quaterniond q = AttitudeOf(i);
    for (const char axis : order) {
      const double value = axis == 'x' ? q.x() : axis == 'y' ? q.y() : axis == 'z' ? q.z() : q.w();
      out += separator + Printf("%.12g", value);
    }
    out += "\n";
  }
  return out;
}

std::string WithDecimalCommas(std::string text) {
  for (char& c : text) c = c == '.' ? ',' : c;
  return text;
}

std::string ToUtf16(const std::string& text) {
  std::string out = "\xFF\xFE";
  for (const char c : text) out += std::string(1, c) + '\0';
  return out;
}

struct Form {
  std::string name, text;
};
void PrintTo(const Form& form, std::ostream* out) { *out << form.name; }

std::string Motive() {
  std::string out =
      "Format Version,1.23,Take Name,Take 1,Rotation Type,Quaternion,Length Units,Millimeters\n\n"
      ",,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body\n"
      ",,Drone,Drone,Drone,Drone,Drone,Drone,Drone\n,,\"5B\",\"5B\",\"5B\",\"5B\",\"5B\",\"5B\","
      "\"5B\"\n"
      ",,Rotation,Rotation,Rotation,Rotation,Position,Position,Position\n"
      "Frame,Time (Seconds),X,Y,Z,W,X,Y,Z\n";
  for (int i = 0; i < kSamples; ++i) {
    const Eigen::Quaterniond q = AttitudeOf(i);
    out += std::to_string(i) + Printf(",%.9f", TimeOf(i));
    for (const double x : {q.x(), q.y(), q.z(), q.w()}) out += Printf(",%.12g", x);
    for (const double x : PositionOf(i)) out += Printf(",%.12g", 1e3 * x);
    out += "\n";
  }
  return out;
}

// Frames count tenths of a second from 0.25 s on: the rate is 20 Hz.
std::string Vicon() {
  std::string out =
      "Segments\n20\n,,Drone:Drone\nFrame,Sub Frame,RX,RY,RZ,TX,TY,TZ\n,,rad,rad,rad,mm,mm,mm\n";
  for (int i = 0; i < kSamples; ++i) {
    out += std::to_string(5 + 2 * i) + ",0";
    for (const double x : LogSo3(AttitudeOf(i))) out += Printf(",%.12g", x);
    for (const double x : PositionOf(i)) out += Printf(",%.12g", 1e3 * x);
    out += "\n";
  }
  return out;
}

std::string Qualisys() {
  std::string out =
      "NO_OF_FRAMES\t5\nNO_OF_CAMERAS\t8\nFREQUENCY\t10\nTIME_STAMP\t2024-05-07, 15:11:00\n"
      "DATA_INCLUDED\t6D\nBODY_NAMES\tDrone\n"
      "Frame\tTime\tX\tY\tZ\tRoll\tPitch\tYaw\tResidual";
  for (int i = 0; i < 9; ++i) out += "\tRot[" + std::to_string(i) + "]";
  out += "\n";
  for (int i = 0; i < kSamples; ++i) {
    out += std::to_string(i + 1) + Printf("\t%.5f", TimeOf(i));
    for (const double x : PositionOf(i)) out += Printf("\t%.12g", 1e3 * x);
    out += "\t1\t2\t3\t0.5";
    const Eigen::Matrix3d rotation = AttitudeOf(i).toRotationMatrix();
    for (int k = 0; k < 9; ++k) out += Printf("\t%.12g", rotation.data()[k]);
    out += "\n";
  }
  return out;
}

std::string Indexed() {
  std::string rows = Rows(" ", "xyzw"), out;
  int i = 0;
  for (size_t at = 0; at < rows.size();) {
    const size_t end = rows.find('\n', at) + 1;
    out += std::to_string(i++) + " " + rows.substr(at, end - at);
    at = end;
  }
  return out;
}

std::vector<Form> Forms() {
  const std::string tum = Rows(" ", "xyzw");
  return {
      {"Tum", tum},
      {"TumTabsAndTrailingBlanks", "\t" + Rows("\t", "xyzw")},
      {"TumWithByteOrderMark", "\xEF\xBB\xBF# comment\n" + tum},
      {"TumInUtf16", ToUtf16(tum)},
      {"TumWithIndex", Indexed()},
      {"TumInNanoseconds", Rows(" ", "xyzw", 1e9, "%.0f")},
      {"TumInNanosecondsWithADot", "# t x y z qx qy qz qw\n" + Rows(" ", "xyzw", 1e9, "%.0f")},
      {"CommasWithoutNames", Rows(",", "xyzw")},
      {"NamesOfTumInAComment", "# timestamp,tx,ty,tz,qx,qy,qz,qw\n" + Rows(",", "xyzw")},
      {"Pandas", "timestamp,tx,ty,tz,qx,qy,qz,qw\n" + Rows(",", "xyzw")},
      {"WFirstByName", "t,x,y,z,qw,qx,qy,qz\n" + Rows(",", "wxyz")},
      {"Millimetres", "t,x [mm],y [mm],z [mm],qx,qy,qz,qw\n" + Rows(",", "xyzw", 1, "%.9f", 1e3)},
      {"SemicolonsAndDecimalCommas",
       "t;x;y;z;qx;qy;qz;qw\n" + WithDecimalCommas(Rows(";", "xyzw"))},
      {"SemicolonsWithoutNames", WithDecimalCommas(Rows(";", "xyzw"))},
      {"BlanksAndDecimalCommas", WithDecimalCommas(tum)},
      {"OpenVins", "#time(ns),px,py,pz,qw,qx,qy,qz\n" + Rows(",", "wxyz", 1e9, "%.0f")},
      {"RosTopic",
       "%time,field.header.frame_id,field.header.stamp,field.pose.position.x,"
       "field.pose.position.y,field.pose.position.z,field.pose.orientation.x,"
       "field.pose.orientation.y,field.pose.orientation.z,field.pose.orientation.w\n" +
           [] {
             std::string rows = Rows(",", "xyzw", 1e9, "%.0f"), out;
             for (size_t at = 0; at < rows.size();) {
               const size_t end = rows.find('\n', at) + 1;
               out += "7,map," + rows.substr(at, end - at);
               at = end;
             }
             return out;
           }()},
      {"Motive", Motive()},
      {"Vicon", Vicon()},
      {"Qualisys", Qualisys()},
  };
}

class TrajectoryForms : public ::testing::TestWithParam<Form> {};

TEST_P(TrajectoryForms, AreReadToTheSamePoses) {
  const auto file = ReadTrajectoryText(GetParam().text, "file", "");
  ASSERT_TRUE(file) << file.error().message;
  ASSERT_EQ(file->samples.size(), static_cast<size_t>(kSamples));
  for (int i = 0; i < kSamples; ++i) {
    const TruthSample& sample = file->samples[static_cast<size_t>(i)];
    EXPECT_NEAR(ToSeconds(sample.t_ns), TimeOf(i), 1e-6);
    EXPECT_LT((sample.world_from_body.translation() - PositionOf(i)).norm(), 1e-9);
    EXPECT_LT(sample.world_from_body.rotation().angularDistance(AttitudeOf(i)), 1e-7);
  }
}
INSTANTIATE_TEST_SUITE_P(All, TrajectoryForms, ::testing::ValuesIn(Forms()),
                         [](const auto& test) { return test.param.name; });

TEST(TrajectoryText, PassesOverBadRowsAndCountsThem) {
  const std::string good = "1 1 1 0 0 0 1\n";
  const std::string text = "0 " + good + "1 " + good + "1 " + good + "0.5 " + good +
                           "2 nan nan nan nan nan nan nan\n3 1 1 1 0 0 0 0\n4 " + good + "5 " +
                           good;
  const auto file = ReadTrajectoryText(text, "file", "");
  ASSERT_TRUE(file) << file.error().message;
  EXPECT_EQ(file->samples.size(), 4U);
  std::string notes;
  for (const std::string& note : file->notes) notes += note + "\n";
  EXPECT_THAT(notes,
              HasSubstr("passed over 1 of 8 rows whose stamp repeats (the first on line 3)"));
  EXPECT_THAT(notes, HasSubstr("1 of 8 rows whose stamp runs backwards (the first on line 4)"));
  EXPECT_THAT(notes, HasSubstr("1 of 8 rows without numbers (the first on line 5)"));
  EXPECT_THAT(notes, HasSubstr("1 of 8 rows with a quaternion of zero (the first on line 6)"));
}

TEST(TrajectoryText, RefusesAFileOfWhichLittleIsLeft) {
  const auto file =
      ReadTrajectoryText("0 1 1 1 0 0 0 1\n0 1 1 1 0 0 0 1\n0 1 1 1 0 0 0 1\n", "file", "");
  ASSERT_FALSE(file);
  EXPECT_THAT(file.error().message, HasSubstr("file:2: 2 of 3 rows whose stamp repeats"));
}

TEST(TrajectoryText, VelocitiesThatWereNeverFilledAreLeftOut) {
  const std::string names =
      "t,x,y,z,qx,qy,qz,qw,vx_world,vy_world,vz_world,wx_body,wy_body,wz_body\n";
  const std::string zeros = ",0,0,0,0,0,0\n";
  const auto moving =
      ReadTrajectoryText(names + "0,0,0,0,0,0,0,1" + zeros + "1,1,0,0,0,0,0,1" + zeros, "file", "");
  ASSERT_TRUE(moving) << moving.error().message;
  EXPECT_FALSE(moving->samples[0].twist);
  EXPECT_EQ(moving->notes.size(), 1U);
  const auto at_rest =
      ReadTrajectoryText(names + "0,1,0,0,0,0,0,1" + zeros + "1,1,0,0,0,0,0,1" + zeros, "file", "");
  ASSERT_TRUE(at_rest) << at_rest.error().message;
  EXPECT_TRUE(at_rest->samples[0].twist);
}

TEST(TrajectoryText, ReadsKittiWithItsTimes) {
  const TempFolder folder;
  WriteText(folder.path() + "/times.txt", "0.0\n0.1\n");
  const std::string row = "1 0 0 ",
                    text = row + "2 0 1 0 3 0 0 1 4\n" + row + "5 0 1 0 6 0 0 1 7\n";
  const auto file = ReadTrajectoryText(text, folder.path() + "/poses.txt", "");
  ASSERT_TRUE(file) << file.error().message;
  EXPECT_EQ(file->samples[1].t_ns, 100000000);
  EXPECT_TRUE(file->samples[1].world_from_body.translation().isApprox(Eigen::Vector3d(5, 6, 7)));
}

TEST(TrajectoryText, ChoosesABodyByName) {
  std::string text = Vicon();
  text.replace(text.find(",,Drone:Drone"), 13, ",,Drone,,,,,,Wand");
  text.replace(text.find("TX,TY,TZ"), 8, "TX,TY,TZ,RX,RY,RZ,TX,TY,TZ");
  text.replace(text.find("mm,mm,mm"), 8, "mm,mm,mm,rad,rad,rad,mm,mm,mm");
  const auto none = ReadTrajectoryText(text, "file", "");
  ASSERT_FALSE(none);
  EXPECT_THAT(none.error().message,
              HasSubstr("several bodies: expected --truth_topic, one of Drone, Wand"));
  EXPECT_TRUE(ReadTrajectoryText(text, "file", "Drone"));
}

struct Refused {
  std::string name, text, fault;
};
void PrintTo(const Refused& refused, std::ostream* out) { *out << refused.name; }

class TrajectoryRefusals : public ::testing::TestWithParam<Refused> {};

TEST_P(TrajectoryRefusals, NameTheFormAndTheWayOn) {
  const auto file = ReadTrajectoryText(GetParam().text, "file", "");
  ASSERT_FALSE(file);
  EXPECT_THAT(file.error().message, HasSubstr(GetParam().fault));
}
INSTANTIATE_TEST_SUITE_P(
    All, TrajectoryRefusals,
    ::testing::Values(
        Refused{"Empty", "", "file: empty file"},
        Refused{"C3d", std::string("\x02\x50", 2) + std::string(600, '\0'),
                "a C3D file has points"},
        Refused{"Bytes", std::string("a\0b", 3), "bytes that are none"},
        Refused{"Prose", "this is no table\n", "got no row of numbers"},
        Refused{"PositionsAlone", "0 1 2 3\n", "file:1: positions alone"},
        Refused{"KittiWithoutTimes", "1 0 0 2 0 1 0 3 0 0 1 4\n", "times.txt"},
        Refused{"NotUnit", "0 1 1 1 0 0 0 1.05\n", "file:1: quaternion: expected unit norm"},
        Refused{"NamesWithoutAttitude", "t,x,y,z\n0,1,2,3\n", "file:1: missing column 'qx'"},
        Refused{"CutRow", "t,x,y,z,qx,qy,qz,qw\n0,1,1,1,0,0,0,1\n1,1,1\n",
                "file:3: expected 8 fields, got 3"},
        Refused{"WordForNumber", "0 1 1 1 0 0 0 1\n1 1 soon 1 0 0 0 1\n",
                "file:2: expected a finite number, got 'soon'"},
        Refused{"QualisysEuler",
                "FREQUENCY\t10\nDATA_INCLUDED\t6D\nBODY_NAMES\tA\nFrame\tTime\tX\tY\tZ\tRoll\n"
                "1\t0.0\t1\t2\t3\t4\n",
                "export the rotation matrix"}),
    [](const auto& test) { return test.param.name; });

}  // namespace
}  // namespace tagtwist::internal::trajectory_text_test

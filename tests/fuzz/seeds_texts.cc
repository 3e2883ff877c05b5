// Texts to start from, as the project's own writers and the programs of others make them.
#include "estimator/online/config.h"
#include "estimator/online/config_text.h"
#include "estimator/report/files/states_csv.h"
#include "frontend/io/tables/detections_csv.h"
#include "frontend/io/tables/imu_csv.h"
#include "frontend/io/trajectories/trajectory_file.h"
#include "tests/fuzz/fuzz_target.h"
#include "tests/support/dataset_fixture.h"
#include "tests/support/flights/synthetic_estimate.h"
#include "tests/support/formats/camera_formats.h"
#include "tests/support/formats/map_formats.h"

namespace tagtwist::internal {

std::vector<FuzzSeed> CameraSeeds() {
  return {{"kalibr", kKalibrCamchain}, {"opencv.yaml", kOpenCvYaml}, {"opencv.xml", kOpenCvXml},
          {"ros", kRosCameraInfo},     {"echo", kRosTopicEcho},      {"own", kOwnCamera}};
}

std::vector<FuzzSeed> MapSeeds() {
  return {
      {"kalibr", kKalibrGrid}, {"wpilib", kWpilibField}, {"tagslam", kTagSlam}, {"own", kOwnMap}};
}

std::vector<FuzzSeed> ConfigSeeds() {
  return {{"course", ReadText(std::string(TAGTWIST_SOURCE_DIR) + "/configs/course.yaml")},
          {"options", OptionsText(DefaultConfig())},
          {"camera", kOwnCamera},
          {"map", kOwnMap}};
}

std::vector<FuzzSeed> YamlSeeds() {
  std::vector<FuzzSeed> out = CameraSeeds();
  for (FuzzSeed& seed : MapSeeds()) out.push_back(std::move(seed));
  out.push_back({"aliases", "a: &a [1, {b: 'x'}]\nc: *a\nd: |\n  text\ne: >-\n  more\n"});
  return out;
}

std::vector<FuzzSeed> TableSeeds() {
  const Recording recording = MakeRecording(4, false);
  std::vector<FuzzSeed> out;
  for (const TimeUnit unit : {TimeUnit::kSeconds, TimeUnit::kNanoseconds}) {
    const std::string name = unit == TimeUnit::kSeconds ? "s" : "ns";
    std::string rows = DetectionsCsvHeader(unit);
    for (const FrameToWrite& frame : recording.frames) {
      rows += FormatDetections(frame.t_ns, frame.detections, unit);
    }
    out.push_back({"detections_" + name, rows});
    out.push_back({"imu_" + name, FormatImuCsv(recording.imu, unit)});
  }
  std::string rows = MeasuredTagsHeader();
  for (FrameToWrite frame : recording.frames) {
    for (TagDetection& tag : frame.detections) {
      tag.covariance = 0.01 * Eigen::Matrix<double, 8, 8>::Identity();
    }
    rows += FormatMeasuredTags(frame.t_ns, frame.detections, {3, 7});
  }
  out.push_back({"detections_with_covariances", rows});
  return out;
}

std::vector<FuzzSeed> TruthSeeds() {
  const std::vector<TruthSample> truth = MakeRecording(4, false).truth;
  return {{"own", FormatGroundTruthCsv(truth)},
          {"tum", FormatTum(truth)},
          {"euroc",
           "#timestamp,p_RS_R_x [m],p_RS_R_y [m],p_RS_R_z [m],q_RS_w [],q_RS_x [],q_RS_y [],"
           "q_RS_z []\n1403636580838555648,4.6,-1.7,0.8,0.5,-0.5,-0.5,-0.5\n"
           "1403636580843555328,4.6,-1.7,0.8,0.5,-0.5,-0.5,-0.5\n"},
          {"motive",
           "Format Version,1.23,Take Name,a,Capture Frame Rate,120,Rotation Type,Quaternion,"
           "Length Units,Meters,Coordinate Space,Global\n\n,Type,Rigid Body,Rigid Body,Rigid "
           "Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body\n,Name,d,d,d,d,d,d,d\n,ID,1,1,1,1,"
           "1,1,1\n,,Rotation,Rotation,Rotation,Rotation,Position,Position,Position\nFrame,Time "
           "(Seconds),X,Y,Z,W,X,Y,Z\n0,0.0,0,0,0,1,1,2,3\n1,0.008333,0,0,0,1,1,2,3\n"},
          {"semicolons", "t;x;y;z;qx;qy;qz;qw\n0,0;1,5;2;3;0;0;0;1\n0,1;1,5;2;3;0;0;0;1\n"},
          {"vicon",
           "Trajectories\n100\n,,d:d,,,,,\nFrame,Sub Frame,RX,RY,RZ,TX,TY,TZ\n,,rad,rad,rad,mm,"
           "mm,mm\n1,0,0,0,0,1,2,3\n2,0,0,0,0.1,1,2,3\n"}};
}

std::vector<FuzzSeed> StatesSeeds() {
  const Estimate estimate = SyntheticEstimate(4, true);
  return {{"states", FormatStatesCsv(estimate.frames)},
          {"covariance", FormatCovarianceCsv(estimate.frames)}};
}

}  // namespace tagtwist::internal

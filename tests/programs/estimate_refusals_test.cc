// Every refusal of tagtwist_estimate, of the program as it is run: exit status, one line that names
// the place and the fault, nothing written.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <functional>

#include "tests/support/program_test_util.h"
#include "tests/support/test_files.h"

namespace tagtwist::internal::estimate_refusals_test {
namespace {

namespace fs = std::filesystem;
using ::testing::AnyOf;
using ::testing::HasSubstr;
using ::testing::StartsWith;

// What is done to a good recording at "rec"; the folder holds nothing else.
using Spoil = std::function<void(const std::string& folder)>;
using Arguments = std::vector<std::string>;

struct Refusal {
  std::string name;
  DatasetFormat format;
  Spoil spoil;
  std::string fault;    // the line on stderr holds it
  Arguments arguments;  // besides --dataset rec --output out
  int status = 1;
};
void PrintTo(const Refusal& refusal, std::ostream* out) { *out << refusal.name; }

const Arguments kDetections = {"--use_detections"};

Spoil Write(const std::string& file, const std::string& text) {
  return [=](const std::string& folder) { WriteText(folder + "/" + file, text); };
}
Spoil Cut(const std::string& file, long bytes) {
  return [=](const std::string& folder) { Truncate(folder + "/" + file, bytes); };
}
Spoil Line(const std::string& file, size_t number, const std::string& line) {
  return [=](const std::string& folder) { ReplaceLine(folder + "/" + file, number, line); };
}
Spoil Remove(const std::string& file) {
  return [=](const std::string& folder) { fs::remove_all(folder + "/" + file); };
}
// The last row of a table ends in its middle; what is left lacks columns.
Spoil CutInLastRow(const std::string& file) {
  return [=](const std::string& folder) {
    const std::string path = folder + "/" + file, text = ReadText(path);
    const size_t begin = text.rfind('\n', text.size() - 2) + 1;
    WriteText(path, text.substr(0, (begin + text.size()) / 2));
  };
}
void Nothing(const std::string&) {}

// A CSV file of a recording: every way in which it may be bad.
void AddCsv(const std::string& name, DatasetFormat format, const std::string& file,
            const Arguments& arguments, std::vector<Refusal>* out) {
  const std::string base = fs::path(file).filename().string();
  const auto add = [&](const std::string& how, const Spoil& spoil, const std::string& fault) {
    out->push_back({name + how, format, spoil, fault, arguments});
  };
  add("Empty", Write(file, ""), base + ": ");
  add("Garbage", Write(file, Garbage()), base + ":");
  add("CutInARow", CutInLastRow(file), base + ":");
  add("StampNoNumber", Line(file, 3, "soon"), base + ":3: ");
}

std::vector<Refusal> DatasetRefusals() {
  constexpr auto kFolder = DatasetFormat::kFolder;
  constexpr auto kMat = DatasetFormat::kMat;
  return {
      {"Missing", kFolder, Remove("rec"), "rec: no such file or folder", kDetections},
      {"EmptyFolder", kFolder,
       [](const std::string& folder) {
         fs::remove_all(folder + "/rec");
         fs::create_directory(folder + "/rec");
       },
       "rec: expected a data set", kDetections},
      {"EmptyFile", kMat, Cut("rec", 0), "rec: empty file", kDetections},
      {"GarbageFile", kMat, Write("rec", Garbage()), "rec: expected a course .mat", kDetections},
      {"MatCutToItsHeader", kMat, Cut("rec", 128), "rec", kDetections},
      {"MatCutInHalf", kMat, Cut("rec", -2000), "rec", kDetections},
      {"MatCutByOneByte", kMat, Cut("rec", -1), "rec", kDetections},
      {"DetectionsMissing", kFolder, Remove("rec/detections.csv"), "detections.csv: ", kDetections},
      {"UnknownTagId", kFolder, Line("rec/detections.csv", 2, "0,108,1,1,2,1,2,2,1,2"),
       "detections.csv:2: id: expected a tag of the map, got 108", kDetections},
      {"TagIdNegative", kFolder, Line("rec/detections.csv", 2, "0,-1,1,1,2,1,2,2,1,2"),
       "detections.csv:2: id: ", kDetections},
      {"CornerNoNumber", kFolder, Line("rec/detections.csv", 2, "0,1,left,1,2,1,2,2,1,2"),
       "detections.csv:2: u1: expected a finite number, got 'left'", kDetections},
      {"ColumnTooMany", kFolder, Line("rec/detections.csv", 2, "0,1,1,1,2,1,2,2,1,2,9"),
       "detections.csv:2: ", kDetections},
      {"DetectionOfNoFrame", kFolder, Line("rec/detections.csv", 100000, "9,1,1,1,2,1,2,2,1,2"),
       "is no frame's", kDetections},
      {"NoDetection", kFolder, Write("rec/detections.csv", "t,id,u1,v1,u2,v2,u3,v3,u4,v4\n"),
       "rec: no frame shows a tag", kDetections},
  };
}

// Tables of a recording.
std::vector<Refusal> TableRefusals() {
  constexpr auto kFolder = DatasetFormat::kFolder;
  constexpr auto kEuroc = DatasetFormat::kEuroc;
  std::vector<Refusal> out = {
      {"StampNoNumber", kFolder, Line("rec/timestamps.csv", 3, "soon,"),
       "timestamps.csv:3: ", kDetections},
      {"NoFrame", kFolder, Write("rec/timestamps.csv", "t,file\n"), "timestamps.csv: no rows",
       kDetections},
      {"NoImageExists", kFolder, Nothing, "none of the images exists", {}},
      {"TruthQuaternionNotUnit", kFolder,
       Write("rec/ground_truth.csv", "t,x,y,z,qx,qy,qz,qw\n0,1,1,1,0,0,0,2\n"),
       "ground_truth.csv:2: ", kDetections},
      {"EurocStampInSeconds", kEuroc, Line("rec/mav0/cam0/data.csv", 3, "0.02,"),
       "data.csv:3: ", kDetections},
  };
  AddCsv("Timestamps", kFolder, "rec/timestamps.csv", kDetections, &out);
  AddCsv("Detections", kFolder, "rec/detections.csv", kDetections, &out);
  AddCsv("GroundTruth", kFolder, "rec/ground_truth.csv", kDetections, &out);
  AddCsv("Imu", kFolder, "rec/imu.csv", kDetections, &out);
  AddCsv("EurocFrames", kEuroc, "rec/mav0/cam0/data.csv", kDetections, &out);
  AddCsv("EurocImu", kEuroc, "rec/mav0/imu0/data.csv", kDetections, &out);
  AddCsv("EurocTruth", kEuroc, "rec/mav0/state_groundtruth_estimate0/data.csv", kDetections, &out);
  return out;
}

std::vector<Refusal> ConfigRefusals() {
  constexpr auto kFolder = DatasetFormat::kFolder;
  const Arguments config = {"--use_detections", "--config", "extra"};
  return {
      {"ConfigMissing", kFolder, Nothing, "extra: cannot open", config},
      {"ConfigEmpty", kFolder, Write("extra", ""), "extra: expected YAML", config},
      {"ConfigGarbage", kFolder, Write("extra", Garbage()), "extra", config},
      {"ConfigCut", kFolder, Write("extra", "camera:\n  width: 376\n  hei"), "extra:", config},
      {"ConfigKeyUnknown", kFolder, Write("extra", "estimator:\n  window: 3\n"),
       "extra:2: estimator.window: expected one of ", config},
      {"ConfigKeyRepeated", kFolder, Write("extra", "klt: {max_points: 9, max_points: 9}\n"),
       "extra:1: klt.max_points: expected the key once", config},
      {"ConfigKeyMistyped", kFolder, Write("extra", "estimator: {window_frames: 2.7}\n"),
       "extra:1: estimator.window_frames: expected a whole number, got 2.7", config},
      {"ConfigKeyOutOfRange", kFolder, Write("extra", "estimator:\n\n  window_frames: 1\n"),
       "extra:3: estimator.window_frames: expected >= 2, got 1", config},
  };
}

// Files besides recording and config, flags, the output.
std::vector<Refusal> OtherRefusals() {
  constexpr auto kFolder = DatasetFormat::kFolder;
  const auto with = [](const Arguments& more) {
    Arguments all = kDetections;
    all.insert(all.end(), more.begin(), more.end());
    return all;
  };
  const Arguments truth = with({"--ground_truth", "extra"});
  const std::string header = "t,x,y,z,qx,qy,qz,qw\n", pose = ",1,1,1,1,0,0,0\n";
  return {
      {"TruthMissing", kFolder, Nothing, "extra: ", truth},
      {"TruthEmpty", kFolder, Write("extra", ""), "extra", truth},
      {"TruthGarbage", kFolder, Write("extra", Garbage()), "extra", truth},
      {"TruthCut", kFolder, Write("extra", header + "0" + pose + "1,1,1"), "extra:3: ", truth},
      {"TruthStampsRepeat", kFolder, Write("extra", header + "1" + pose + "1" + pose),
       "extra:3: ", truth},
      {"TruthStampsRunBack", kFolder, Write("extra", header + "1" + pose + "0" + pose),
       "extra:3: ", truth},
      {"TruthStampNan", kFolder, Write("extra", header + "nan" + pose), "extra:2: ", truth},
      {"TruthOfAnotherTime", kFolder, Write("extra", header + "100" + pose + "101" + pose),
       "extra: no sample lies within the recording", truth},
      {"OutputBelowAFile", kFolder, Write("extra", ""), "extra/out",
       with({"--output", "extra/out"})},
      {"OutputIsAFile", kFolder, Write("extra", ""), "extra", with({"--output", "extra"})},
      {"TooShortToCalibrate",
       kFolder,
       Nothing,
       "a calibration needs 20 frames with tags, got 6",
       {"--use_detections", "--calibrate"}},
      {"OutputInNowhere", kFolder, Nothing, "/proc/out", with({"--output", "/proc/out"})},
      {"NoDataset", kFolder, Nothing, "--dataset", {"--dataset", ""}, 2},
      {"UnknownFlag",
       kFolder,
       Nothing,
       "unknown flag --datasets: did you mean --dataset?",
       {"--datasets", "rec"},
       2},
      {"DatasetTwice",
       kFolder,
       Nothing,
       "--dataset: given twice, 'rec' and 'other'",
       {"--dataset", "rec", "--dataset", "other"},
       2},
      {"WindowFramesInBatch",
       kFolder,
       Nothing,
       "--window_frames: needs --sliding_window",
       {"--window_frames", "20"},
       2},
      {"FlagWithoutValue", kFolder, Nothing, "--config", {"--config"}, 2},
      {"FlagOfWrongType", kFolder, Nothing, "sliding_window", {"--sliding_window=perhaps"}, 2},
      {"ArgumentTooMany", kFolder, Nothing, "rec", {"rec"}, 2},
  };
}

// What a frame-by-frame run asks for.
std::vector<Refusal> LiveRefusals() {
  constexpr auto kFolder = DatasetFormat::kFolder;
  return {
      {"StreamInBatch", kFolder, Nothing, "--stream: needs --sliding_window", {"--stream=x"}, 2},
      {"StreamIntoNowhere",
       kFolder,
       Nothing,
       "nowhere/x: cannot write",
       {"--use_detections", "--sliding_window", "--stream", "nowhere/x"}},
      {"DeadlineInBatch", kFolder, Nothing, "--deadline_ms: needs", {"--deadline_ms=5"}, 2},
      {"DeadlineNegative", kFolder, Nothing, "--deadline_ms: expected", {"--deadline_ms=-5"}, 2},
      {"RealtimeInBatch",
       kFolder,
       Nothing,
       "--realtime: needs --sliding_window",
       {"--realtime"},
       2},
      {"MaxFramesNegative", kFolder, Nothing, "--max_frames: expected", {"--max_frames=-1"}, 2},
      {"CameraInBatch", kFolder, Nothing, "a camera needs", {"--dataset=camera:0"}, 2},
      {"CameraWithTruth",
       kFolder,
       Nothing,
       "a camera excludes --ground_truth",
       {"--dataset=camera:0", "--sliding_window", "--ground_truth=x"},
       2},
      {"CameraMissing",
       kFolder,
       Nothing,
       "camera:97: no camera can be opened there",
       {"--dataset=camera:97", "--sliding_window"}},
      {"CameraStreamMissing",
       kFolder,
       Nothing,
       "camera:x.avi: no camera can be opened there",
       {"--dataset=camera:x.avi", "--sliding_window"}},
  };
}

class EstimateRefusals : public ::testing::TestWithParam<Refusal> {};

TEST_P(EstimateRefusals, OneLineAndNothingWritten) {
  const Refusal& refusal = GetParam();
  const TempFolder folder;
  MakeRecording(folder.path(), "rec", refusal.format, false);
  refusal.spoil(folder.path());
  const std::vector<std::string> before = ListTree(folder.path());
  const auto& own = refusal.arguments;
  const bool other_dataset = std::any_of(own.begin(), own.end(), [](const std::string& argument) {
    return argument.rfind("--dataset", 0) == 0 && argument.rfind("--datasets", 0) != 0;
  });
  Arguments arguments = {"--output", "out"};
  if (!other_dataset) arguments.insert(arguments.end(), {"--dataset", "rec"});
  arguments.insert(arguments.end(), refusal.arguments.begin(), refusal.arguments.end());
  const ProgramRun run = RunProgram(folder.path(), "tagtwist_estimate", arguments);
  EXPECT_EQ(run.status, refusal.status) << run.err;
  EXPECT_TRUE(IsOneLine(run.err)) << run.err;
  EXPECT_THAT(run.err, StartsWith("tagtwist_estimate: "));
  EXPECT_THAT(run.err, HasSubstr(refusal.fault));
  EXPECT_THAT(run.out, AnyOf("", StartsWith("recording  "))) << "what it takes, at most";
  std::vector<std::string> after = ListTree(folder.path());
  if (!run.out.empty()) {  // its inputs were taken: summary.json says why it failed
    EXPECT_THAT(ReadText(folder.path() + "/out/summary.json"), HasSubstr("\"status\": \"failed\""));
    after.erase(std::remove_if(after.begin(), after.end(),
                               [](const std::string& path) { return path.rfind("out", 0) == 0; }),
                after.end());
  }
  EXPECT_EQ(after, before);
}
INSTANTIATE_TEST_SUITE_P(Dataset, EstimateRefusals, ::testing::ValuesIn(DatasetRefusals()),
                         [](const auto& test) { return test.param.name; });
INSTANTIATE_TEST_SUITE_P(Table, EstimateRefusals, ::testing::ValuesIn(TableRefusals()),
                         [](const auto& test) { return test.param.name; });
INSTANTIATE_TEST_SUITE_P(Config, EstimateRefusals, ::testing::ValuesIn(ConfigRefusals()),
                         [](const auto& test) { return test.param.name; });
INSTANTIATE_TEST_SUITE_P(Live, EstimateRefusals, ::testing::ValuesIn(LiveRefusals()),
                         [](const auto& test) { return test.param.name; });
INSTANTIATE_TEST_SUITE_P(Other, EstimateRefusals, ::testing::ValuesIn(OtherRefusals()),
                         [](const auto& test) { return test.param.name; });

}  // namespace
}  // namespace tagtwist::internal::estimate_refusals_test

#include <gflags/gflags.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <functional>
#include <opencv2/core/utils/logger.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <type_traits>
#include <vector>

#include "bench/cpu_clock.h"
#include "bench/run_bench.h"
#include "estimator/online/config.h"
#include "frontend/base/option_check.h"
#include "frontend/base/statistics/quantile.h"
#include "frontend/io/images/video_file.h"
#include "frontend/io/recordings/data_source.h"
#include "frontend/io/setup/camera_file.h"
#include "frontend/io/setup/tag_map_file.h"
#include "frontend/io/tables/detections_reader.h"
#include "frontend/io/trajectories/trajectory_file.h"
#include "tests/fuzz/ros1_writer.h"
#include "tests/support/dataset_fixture.h"
#include "tests/support/formats/ros2_writers.h"
#include "tests/support/temp_folder.h"

DEFINE_int32(frames, 60, "Of each recording.");
DEFINE_int32(rounds, 15, "How often each reader reads under both limits, in turns.");
DEFINE_double(round_ms, 40, "CPU time of a reader in a round under one of them, at least.");
DEFINE_string(recording, "", "One more, of any kind that tagtwist_estimate reads.");
DEFINE_double(most, 0, "Exit 1 where a ratio is above it; 0: never.");

namespace tagtwist::internal {
namespace {

// Reads it all, once.
using Reading = std::function<Status(const Limits&)>;

struct Reader {
  std::string name;
  Reading read;
};

struct Times {
  double limited_ms = 0, lifted_ms = 0;  // of one reading, medians over the rounds
  double ratio = 0;                      // median of the rounds' own
};

template <typename T>
Status Whether(const Result<T>& result) {
  if (result) return Ok();
  return result.error();
}

// Each at the largest power of ten that is none of its problems.
Limits Lifted() {
  Limits out;
  Limits::VisitFields(out, [&](const char*, auto& limit) {
    using Number = std::decay_t<decltype(limit)>;
    for (double most = 1e15; most >= 1; most /= 10) {
      limit = static_cast<Number>(most);
      if (!out.Problem()) return;
    }
  });
  return out;
}

Status ReadRecording(const std::string& path, bool use_detections, const Limits& limits) {
  DataSourceOptions options;
  options.use_detections = use_detections;
  options.read_images = !use_detections;
  options.limits = limits;
  const auto source = OpenDataSource(path, options);
  if (!source) return source.error();
  while (true) {
    const auto frame = (*source)->Next();
    if (!frame) return frame.error();
    if (!*frame) return Ok();
  }
}

Reader RecordingReader(const std::string& name, const std::string& path,
                       bool use_detections = false) {
  return {name, [=](const Limits& limits) { return ReadRecording(path, use_detections, limits); }};
}

std::string ScreenImage(double t_s) {
  const int width = 376, height = 240;
  Ros2Writer out;
  out.Header(t_s) << uint32_t{height} << uint32_t{width} << std::string("mono8") << uint8_t{0}
                  << uint32_t{width} << std::vector<uint8_t>(width * height, 90);
  return out.Data();
}

std::vector<Message> Messages(int frames) {
  std::vector<Message> out;
  for (int i = 0; i < frames; ++i) {
    const double t_s = 10 + 0.02 * i;
    const auto arrival_ns = static_cast<int64_t>(1e9 * t_s) + 1000;
    out.push_back({"/cam", "sensor_msgs/msg/Image", arrival_ns, ScreenImage(t_s)});
    out.push_back({"/body", "geometry_msgs/msg/PoseStamped", arrival_ns, Ros2Pose(t_s, i)});
    out.push_back({"/imu", "sensor_msgs/msg/Imu", arrival_ns, Ros2Imu(t_s)});
  }
  return out;
}

Status WriteVideo(const std::string& path, int frames) {
  const auto video = VideoFile::Create(path, 50, {376, 240});
  if (!video) return video.error();
  for (int i = 0; i < frames; ++i) {
    cv::Mat colour;
    cv::cvtColor(MakeImage(i % 4, 376, 240), colour, cv::COLOR_GRAY2BGR);
    (*video)->Add(colour);
  }
  return (*video)->Finish();
}

// Everything that is read, in a folder.
Status WriteInputs(const TempFolder& folder, int frames) {
  Recording recording = MakeRecording(frames, /*with_images=*/false);
  WriteRecording(MakeRecording(20 * frames, /*with_images=*/false), folder / "tables",
                 DatasetFormat::kFolder);
  for (int i = 0; i < frames; ++i) {
    recording.frames[static_cast<size_t>(i)].image = MakeImage(i % 4, 376, 240);
  }
  WriteRecording(recording, folder / "folder", DatasetFormat::kFolder);
  WriteRecording(recording, folder / "euroc", DatasetFormat::kEuroc);
  WriteRecording(recording, folder / "own.mat", DatasetFormat::kMat);
  for (const char* compression : {"none", "lz4", "zstd"}) {
    WriteText(folder / (std::string(compression) + ".mcap"), Mcap(compression, Messages(frames)));
  }
  WriteSqlite(folder / "bag.db3", Messages(frames));
  WriteText(folder / "small.bag", Ros1Bag());
  return WriteVideo(folder / "film.avi", frames);
}

std::vector<Reader> Readers(const TempFolder& folder) {
  const std::string course = std::string(TAGTWIST_SOURCE_DIR) + "/configs/course.yaml";
  const std::string tables = folder / "tables";
  std::vector<Reader> out = {
      {"configuration",
       [=](const Limits& limits) {
         return Whether(LoadConfig(ConfigFiles{course, "", "", {}, {}, limits}));
       }},
      {"camera", [=](const Limits& limits) { return Whether(ReadCameraFile(course, "", limits)); }},
      {"map",
       [=](const Limits& limits) {
         return Whether(ReadTagMapFile({course, {}, ""}, limits));
       }},
      {"trajectory",
       [=](const Limits& limits) {
         return Whether(ReadGroundTruth(tables + "/ground_truth.csv", limits));
       }},
      {"detections", [=](const Limits& limits) {
         return Whether(ReadDetectionsCsv(tables + "/detections.csv", TimeUnit::kSeconds, {},
                                          nullptr, limits));
       }}};
  out.push_back(RecordingReader("folder, tags", tables, true));
  std::vector<std::string> recordings = {"folder",   "euroc",     "own.mat", "none.mcap",
                                         "lz4.mcap", "zstd.mcap", "bag.db3", "film.avi"};
#ifdef TAGTWIST_ROSBAG
  recordings.emplace_back("small.bag");
#endif
  for (const std::string& name : recordings) {
    out.push_back(RecordingReader(name, folder / name));
  }
  if (!FLAGS_recording.empty()) out.push_back(RecordingReader("recording", FLAGS_recording));
  return out;
}

// CPU time of one reading of `times`, with whatever threads it starts.
Result<double> TimeOf(const Reader& reader, const Limits& limits, int times) {
  const CpuClock clock(CLOCK_PROCESS_CPUTIME_ID);
  for (int i = 0; i < times; ++i) {
    if (const Status read = reader.read(limits); !read) return read.error();
  }
  return clock.ElapsedMs() / times;
}

Result<Times> Measure(const Reader& reader) {
  const Limits limited, lifted = Lifted();
  for (const Limits& limits : {limited, lifted}) {  // caches are warm then
    if (const auto once = TimeOf(reader, limits, 1); !once) return once.error();
  }
  const auto once_ms = TimeOf(reader, limited, 1);
  if (!once_ms) return once_ms.error();
  const int times = 1 + static_cast<int>(FLAGS_round_ms / std::max(*once_ms, 1e-3));
  std::vector<double> limited_ms, lifted_ms, ratios;
  for (int round = 0; round < FLAGS_rounds; ++round) {
    double ms[2] = {};
    for (int turn = 0; turn < 2; ++turn) {
      const int which = (round + turn) % 2;  // neither is always the first
      const auto time_ms = TimeOf(reader, which == 0 ? limited : lifted, times);
      if (!time_ms) return time_ms.error();
      ms[which] = *time_ms;
    }
    limited_ms.push_back(ms[0]);
    lifted_ms.push_back(ms[1]);
    ratios.push_back(ms[0] / ms[1]);
  }
  return Times{Quantile(limited_ms, 0.5), Quantile(lifted_ms, 0.5), Quantile(ratios, 0.5)};
}

Status MeasureAll() {
  cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
  const TempFolder folder;
  if (const Status written = WriteInputs(folder, FLAGS_frames); !written) return written;
  std::printf("%-14s %12s %12s %8s\n", "reader", "limits [ms]", "lifted [ms]", "ratio");
  std::string above;
  for (const Reader& reader : Readers(folder)) {
    const auto times = Measure(reader);
    if (!times) return times.error();
    std::printf("%-14s %12.3f %12.3f %8.3f\n", reader.name.c_str(), times->limited_ms,
                times->lifted_ms, times->ratio);
    std::fflush(stdout);
    if (FLAGS_most > 0 && times->ratio > FLAGS_most) above += " " + reader.name;
  }
  if (!above.empty()) return Error{"above " + std::to_string(FLAGS_most) + ":" + above};
  return Ok();
}

Usage ReadersUsage() {
  return {
      "readers",
      "[--recording PATH] [--most 1.02] [...]",
      "What limits cost: CPU time of each reader with its limits, over that with each of them\n"
      "lifted as far as it goes. The times themselves compare one version with another.",
      {{"What is read", {"frames", "recording"}}, {"Measuring", {"rounds", "round_ms", "most"}}}};
}

std::optional<std::string> FlagProblem() {
  return FirstFlagProblem(
      {CheckRange("frames", FLAGS_frames, 3, 1e5), CheckRange("rounds", FLAGS_rounds, 1, 1e5),
       CheckRange("round_ms", FLAGS_round_ms, 0, 1e6), CheckRange("most", FLAGS_most, 0, 1e3)});
}

}  // namespace
}  // namespace tagtwist::internal

int main(int argc, char** argv) {
  return tagtwist::internal::RunBench(argc, argv, tagtwist::internal::ReadersUsage(),
                                      tagtwist::internal::FlagProblem,
                                      tagtwist::internal::MeasureAll);
}

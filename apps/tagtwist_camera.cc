#include <gflags/gflags.h>

#include <cstdint>
#include <cstdlib>
#include <iostream>
#include <memory>
#include <opencv2/core/utils/logger.hpp>
#include <optional>
#include <string>
#include <tuple>
#include <utility>

#include "apps/support/clean_end.h"
#include "apps/support/guarded_main.h"
#include "apps/support/limits_flag.h"
#include "apps/support/port_text.h"
#include "apps/support/usage.h"
#include "estimator/jobs/camera/find_camera.h"
#include "estimator/jobs/camera/guide_camera.h"
#include "estimator/jobs/in_order.h"
#include "estimator/live/live_feed.h"
#include "estimator/publish/camera_page.h"
#include "estimator/report/files/camera_found.h"
#include "estimator/report/html/camera_report.h"
#include "frontend/base/files/atomic_file.h"
#include "frontend/base/files/run_files.h"
#include "frontend/base/number_text.h"
#include "frontend/base/printable.h"
#include "frontend/io/recordings/data_source.h"
#include "frontend/io/setup/tag_map_file.h"

DEFINE_string(
    from, "",
    "Recording of the tags: a video, a folder of images, or camera:0, which says what to show "
    "next. Needed.");
DEFINE_string(topic, "", "Of the images in a ROS bag; the only one that has any where left out.");
DEFINE_string(
    map, "",
    "Where the tags are: the kinds of file that tagtwist_estimate takes. Without it that is "
    "learned from the recording, of tags of one size on one sheet.");
DEFINE_double(tag_size_m, 0, "Side of a tag's black square, where --map does not say it.");
DEFINE_string(tag_family, "",
              "The tags' family, where --map does not say it; tag36h11 without --map.");
DEFINE_bool(use_detections, false,
            "Tag corners come from the recording (detections.csv, .mat), not from its images.");
DEFINE_string(image_size, "",
              "Of a recording without images, or wanted of a camera, [px]: 640x480.");
DEFINE_string(output, "", "Camera to write (YAML), for --camera_file. Needed.");
DEFINE_string(picture, "",
              "Picture to write (SVG): where the image saw corners, the figures, and the verdict.");
DEFINE_string(
    report, "",
    "Page to write (HTML): verdict, the lens with its sigmas, where the image saw corners.");
DEFINE_string(
    page, "",
    "A page that shows what to show next, on this machine alone unless --listen is given: PORT, "
    "8765 where none is said, 0 for any that is free. A recording plays as if it were a camera.");
DEFINE_string(listen, "",
              "IP address to serve --page at, 0.0.0.0 for all of the machine's; who wants in needs "
              "the token of the link that is told.");
DEFINE_bool(accept_poor, false,
            "Writes a calibration that is not good, too, with what speaks against it.");

namespace tagtwist::internal {
namespace {

Usage CameraUsage() {
  Usage usage;
  usage.program = "tagtwist_camera";
  usage.synopsis = "--from RECORDING|camera:N [--map FILE] --output camera.yaml";
  usage.summary =
      "Calibrates a camera of which nothing is known from a recording of a map of AprilTags: "
      "model\n"
      "and number of coefficients by frames that are left out, sigmas by the recording's halves.\n"
      "Says what is missing, and writes no calibration that is not good.";
  usage.groups = {
      {"What to read",
       {"from", "topic", "use_detections", "image_size", "map", "tag_size_m", "tag_family"}},
      {"What to write", {"output", "picture", "report", "accept_poor"}},
      {"Running", {"page", "listen", "limits"}}};
  usage.implied = {{"page", "8765"}};
  usage.examples = {
      {"A webcam, before a sheet that is tilted about before it",
       "tagtwist_camera --from sheet.mp4 --map april_6x6.yaml --output camera.yaml"},
      {"Of a sheet that nobody measured", "tagtwist_camera --from sheet.mp4 --output camera.yaml"},
      {"The same live; it says what to show next",
       "tagtwist_camera --from camera:0 --map april_6x6.yaml --output camera.yaml"},
      {"The same on a page",
       "tagtwist_camera --from camera:0 --map april_6x6.yaml --output camera.yaml --page"}};
  return usage;
}

Status CheckInputsAreKept() {
  RunFiles files;
  files.Reads("--map", FLAGS_map);
  files.ReadsRecording("--from", FLAGS_from);
  if (auto checked = files.Writes("--output", FLAGS_output); !checked) return checked;
  if (auto checked = files.Writes("--picture", FLAGS_picture); !checked) return checked;
  if (auto checked = files.Writes("--report", FLAGS_report); !checked) return checked;
  return files.WritesStandardOutput();
}

// "640x480"; both 0 for an empty text.
std::optional<std::pair<int, int>> ImageSizeOf(const std::string& text) {
  if (text.empty()) return std::pair(0, 0);
  const size_t x = text.find('x');
  if (x == std::string::npos) return std::nullopt;
  const auto width = ParseInteger(text.substr(0, x)), height = ParseInteger(text.substr(x + 1));
  constexpr int64_t kMost = 100000;
  if (!width || !height || *width < 1 || *height < 1 || *width > kMost || *height > kMost) {
    return std::nullopt;
  }
  return std::pair(static_cast<int>(*width), static_cast<int>(*height));
}

CameraJob JobOfFlags(const Limits& limits) {
  CameraJob job;
  job.limits = limits;
  job.warn = [](const std::string& note) {
    std::cerr << "tagtwist_camera: warning: " << Printable(note) << "\n";
  };
  job.recording = FLAGS_from;
  job.topic = FLAGS_topic;
  job.use_detections = FLAGS_use_detections;
  std::tie(job.width, job.height) = *ImageSizeOf(FLAGS_image_size);
  job.accepts_poor = FLAGS_accept_poor;
  job.threads = ResolveThreads(0);
  return job;
}

// A camera, or a recording.
Result<std::unique_ptr<DataSource>> Open(const CameraJob& job) {
  if (IsCamera(job.recording)) {
    Camera wanted;
    wanted.width = job.width > 0 ? job.width : 640;
    wanted.height = job.width > 0 ? job.height : 480;
    return OpenCameraSource(job.recording, wanted, SteadyNowNs, job.limits);
  }
  auto source = OpenDataSource(job.recording, {false, true, {}, job.topic, {}, job.limits});
  if (!source) return source;
  for (const std::string& note : (*source)->notes()) job.warn(note);
  return source;
}

// A live camera, or, with a page, a recording as if it were one.
Result<LensFound> FindLive(const CameraJob& job, const TagMap& map, CleanEnd* end,
                           CameraPage* page) {
  auto opened = Open(job);
  if (!opened) return opened.error();
  std::unique_ptr<DataSource> source = std::move(*opened);
  CameraGuide guide;
  guide.tell = [](const std::string& line) { std::cout << line << std::endl; };
  guide.stop = end->AskFirst();
  if (page != nullptr) {
    guide.show = [page](const GuideView& view) { page->Show(view); };
    LiveFeed::Options feed;  // what comes while a frame is looked at makes way for the newest
    feed.paced = !IsCamera(job.recording);
    feed.stop = guide.stop;
    source = std::make_unique<LiveFeed>(std::move(source), feed);
  }
  return GuideCamera(job, map, source.get(), guide);
}

// Nothing where no page is asked for. Told on standard output.
Result<std::unique_ptr<CameraPage>> OpenPage() {
  if (FLAGS_page.empty()) return std::unique_ptr<CameraPage>();
  CameraPage::Options options;
  options.port = *PortOf(FLAGS_page, 0);
  if (!FLAGS_listen.empty()) options.listen = FLAGS_listen;
  options.recording = FLAGS_from;
  auto page = CameraPage::Start(options);
  if (page) std::cout << (*page)->Link() << std::endl;
  return page;
}

Result<LensFound> Find(const TagMap& map, const Limits& limits, CleanEnd* end) {
  const CameraJob job = JobOfFlags(limits);
  auto page = OpenPage();
  if (!page) return page.error();
  if (*page == nullptr && !IsCamera(job.recording)) return FindCamera(job, map);
  auto found = FindLive(job, map, end, page->get());
  if (*page == nullptr) return found;
  CameraVerdictToShow verdict;
  verdict.is_good = found && found->missing.empty();
  verdict.text = found ? CameraVerdict(*found) : found.error().message;
  if (found) verdict.found = std::make_shared<const LensFound>(*found);
  (*page)->End(verdict);
  return found;
}

// Without --map one without tags, of their family.
Result<TagMap> MapOfFlags(const Limits& limits) {
  if (FLAGS_map.empty()) {
    return TagMap(FLAGS_tag_family.empty() ? "tag36h11" : FLAGS_tag_family, {});
  }
  TagMapFile file{FLAGS_map, {}, FLAGS_tag_family};
  if (FLAGS_tag_size_m > 0) file.tag_size_m = FLAGS_tag_size_m;
  return ReadTagMapFile(file, limits);
}

Status Run(const Limits& limits, CleanEnd* end) {
  if (const auto kept = CheckInputsAreKept(); !kept) return kept;
  const auto map = MapOfFlags(limits);
  if (!map) return map.error();
  const auto found = Find(*map, limits, end);
  if (!found) return found.error();
  std::cout << CameraFoundText(*found);
  if (!FLAGS_picture.empty()) {
    if (auto written = WriteFileAtomically(FLAGS_picture, CameraFoundSvg(*found)); !written) {
      return written;
    }
  }
  if (!FLAGS_report.empty()) {
    const std::string report = CameraReportHtml(*found, FLAGS_from);
    if (auto written = WriteFileAtomically(FLAGS_report, report); !written) return written;
  }
  if (!found->missing.empty() && !FLAGS_accept_poor) {
    return Error{FLAGS_from + ": the calibration is " + CameraVerdict(*found) +
                 " (--accept_poor writes it all the same)"};
  }
  return WriteFileAtomically(FLAGS_output, CameraFoundConfig(*found));
}

std::string WrongFlags() {
  for (const auto& [flag, value] : {std::pair("--from", FLAGS_from), {"--output", FLAGS_output}}) {
    if (value.empty()) return std::string(flag) + ": needed, and not given";
  }
  if (FLAGS_map.empty() && FLAGS_tag_size_m > 0) return "--tag_size_m: needs --map";
  if (!(FLAGS_tag_size_m >= 0)) return "--tag_size_m: expected > 0";
  if (!ImageSizeOf(FLAGS_image_size)) {
    return "--image_size: expected WIDTHxHEIGHT in pixels, got '" + FLAGS_image_size + "'";
  }
  if (IsCamera(FLAGS_from) && FLAGS_use_detections) {
    return "--use_detections: a camera has no corners of its own";
  }
  if (!FLAGS_page.empty() && !PortOf(FLAGS_page, 0)) {
    return "--page: expected a port, 0 to 65535, got '" + FLAGS_page + "'";
  }
  if (!FLAGS_page.empty() && FLAGS_use_detections) {
    return "--page: shows images, and --use_detections reads none";
  }
  if (!FLAGS_listen.empty() && FLAGS_page.empty()) return "--listen: needs --page";
  return "";
}

int Main(int argc, char** argv, const Usage& usage) {
  ParseFlagsOrExit2(argc, argv, usage);
  if (const std::string wrong = WrongFlags(); !wrong.empty()) return Fail(usage, wrong, 2);
  const auto limits = LimitsFromFlag();
  if (!limits) return Fail(usage, limits.error().message, 2);
  cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
  ::setenv("OPENCV_FFMPEG_LOGLEVEL", "-8", 0);
  CleanEnd end(usage, {{FLAGS_output, FLAGS_picture, FLAGS_report}, ""});
  const auto done = Run(*limits, &end);
  return done ? 0 : Fail(usage, done.error().message);
}

}  // namespace
}  // namespace tagtwist::internal

int main(int argc, char** argv) {
  return tagtwist::internal::GuardedMain(argc, argv, tagtwist::internal::CameraUsage,
                                         tagtwist::internal::Main);
}

#include <gflags/gflags.h>

#include <iostream>

#include "apps/map/map_pdf.h"
#include "apps/support/clean_end.h"
#include "apps/support/guarded_main.h"
#include "apps/support/limits_flag.h"
#include "apps/support/usage.h"
#include "estimator/evaluation/plausibility.h"
#include "estimator/jobs/in_order.h"
#include "estimator/jobs/map_recording.h"
#include "estimator/report/files/map_svg.h"
#include "estimator/report/files/mapping_text.h"
#include "frontend/base/files/atomic_file.h"
#include "frontend/base/files/run_files.h"
#include "frontend/io/setup/tag_map_file.h"

DEFINE_string(check, "",
              "Map to check and describe: a configuration, Kalibr aprilgrid, WPILib or Limelight "
              "field, TagSLAM bodies, apriltag_ros tags.yaml.");
DEFINE_string(map, "", "Map to render: the same kinds of file; --check's without it.");
DEFINE_double(tag_size_m, 0, "Side of a tag's black square, where the file does not say it.");
DEFINE_string(tag_family, "", "The tags' family, where the file does not say it.");
DEFINE_string(from, "",
              "Recording to make a map from: a course .mat, an EuRoC/ASL folder, a plain folder.");
DEFINE_string(config, "", "Camera and detector for --from; configs/course.yaml's without it.");
DEFINE_string(camera_file, "",
              "Calibration to take the camera from, for --from, before the one in --config.");
DEFINE_string(camera, "", "Which camera of --camera_file, where it has several: cam1.");
DEFINE_string(output, "", "Map to write (YAML); for --from.");
DEFINE_int32(root_tag, -1, "The tag whose frame is the world; -1: the one seen most often.");
DEFINE_string(topic, "", "Of the images in a ROS bag; the only one that has any where left out.");
DEFINE_bool(use_detections, false,
            "Tag corners come from the recording (detections.csv, .mat), not from its images.");
DEFINE_string(render, "",
              "Picture to write, in true size: an SVG of the whole map, or, where the name ends in "
              ".pdf, pages to print at 100 %.");
DEFINE_string(paper, "a4", "Of the PDF's pages: a4 or letter.");

namespace tagtwist::internal {
namespace {

Usage MapUsage() {
  Usage usage;
  usage.program = "tagtwist_map";
  usage.synopsis =
      "--check FILE | --map FILE --render FILE.svg|FILE.pdf | --from RECORDING --tag_size_m SIZE "
      "--output "
      "FILE";
  usage.summary =
      "Checks a map of AprilTags (ids given twice or not in the family, tags that overlap or have\n"
      "no size) and draws it. Makes one from a recording and the tags' size.";
  usage.groups = {
      {"The map", {"check", "map", "tag_size_m", "tag_family"}},
      {"Making one",
       {"from", "config", "camera_file", "camera", "root_tag", "topic", "use_detections"}},
      {"What to write", {"render", "paper", "output"}},
      {"Running", {"limits"}}};
  usage.examples = {
      {"A map to print, in true size", "tagtwist_map --map mat.yaml --render mat.pdf"},
      {"A map of tags that nobody surveyed",
       "tagtwist_map --from flight --tag_size_m 0.152 --output map.yaml"}};
  return usage;
}

bool IsPdf(const std::string& path) {
  return path.size() > 4 && path.compare(path.size() - 4, 4, ".pdf") == 0;
}

std::string WrongFlags() {
  if (const auto paper = PaperOf(FLAGS_paper); !paper) return "--paper: " + paper.error().message;
  if (FLAGS_paper != "a4" && !IsPdf(FLAGS_render)) return "--paper: expected with --render x.pdf";
  if (!FLAGS_from.empty()) {
    if (!FLAGS_check.empty() || !FLAGS_map.empty() || !FLAGS_render.empty()) {
      return "--from: expected without --check, --map and --render";
    }
    if (!(FLAGS_tag_size_m > 0)) return "--tag_size_m: needed with --from, expected > 0";
    if (!FLAGS_camera.empty() && FLAGS_camera_file.empty()) {
      return "--camera: expected with --camera_file";
    }
    return FLAGS_output.empty() ? "--output: needed with --from, and not given" : "";
  }
  if (FLAGS_check.empty() && FLAGS_map.empty()) return "--check or --map: needed, and not given";
  if (!FLAGS_map.empty() && FLAGS_render.empty()) return "--map: expected with --render";
  if (!(FLAGS_tag_size_m >= 0)) return "--tag_size_m: expected > 0";
  return "";
}

Result<TagMap> Read(const std::string& path, const Limits& limits) {
  TagMapFile file{path, {}, FLAGS_tag_family};
  if (FLAGS_tag_size_m > 0) file.tag_size_m = FLAGS_tag_size_m;
  return ReadTagMapFile(file, limits);
}

Status MakeMap(const Limits& limits) {
  const auto config =
      LoadConfig(ConfigFiles{FLAGS_config, FLAGS_camera_file, FLAGS_camera, {}, {}, limits});
  if (!config) return config.error();
  MapJob job;
  job.recording = FLAGS_from;
  job.topic = FLAGS_topic;
  job.use_detections = FLAGS_use_detections;
  job.threads = ResolveThreads(0);
  job.mapping.tag_size_m = FLAGS_tag_size_m;
  job.mapping.family = FLAGS_tag_family.empty() ? config->set_up.map.family() : FLAGS_tag_family;
  if (FLAGS_root_tag >= 0) job.mapping.root = FLAGS_root_tag;
  const auto mapping = MapRecording(job, *config);
  if (!mapping) return mapping.error();
  std::cout << mapping->map.tags().size() << " tags mapped, " << mapping->left_out.size()
            << " seen and not placed; corner noise " << mapping->corner_sigma_px << " px\n";
  return WriteFileAtomically(FLAGS_output, MappingText(*mapping));
}

Status CheckInputsAreKept() {
  RunFiles files;
  files.Reads("--check", FLAGS_check);
  files.Reads("--map", FLAGS_map);
  files.Reads("--config", FLAGS_config);
  files.Reads("--camera_file", FLAGS_camera_file);
  files.ReadsRecording("--from", FLAGS_from);
  if (auto checked = files.Writes("--render", FLAGS_render); !checked) return checked;
  if (auto checked = files.Writes("--output", FLAGS_output); !checked) return checked;
  return files.WritesStandardOutput();
}

Status Run(const Limits& limits) {
  if (const auto kept = CheckInputsAreKept(); !kept) return kept;
  if (!FLAGS_from.empty()) return MakeMap(limits);
  if (!FLAGS_check.empty()) {
    const auto map = Read(FLAGS_check, limits);
    if (!map) return map.error();
    std::cout << FLAGS_check << ": " << DescribeMap(*map) << "\n";
    for (const Fault& fault : ImplausibleMap(*map)) {
      std::cerr << "tagtwist_map: warning: " << FLAGS_check << ": " << fault.fact << " "
                << fault.advice << "\n";
    }
  }
  if (FLAGS_render.empty()) return Ok();
  const std::string& source = FLAGS_map.empty() ? FLAGS_check : FLAGS_map;
  const auto map = Read(source, limits);
  if (!map) return map.error();
  const auto picture =
      IsPdf(FLAGS_render) ? MapPdf(*map, *PaperOf(FLAGS_paper), source) : MapSvg(*map);
  if (!picture) return picture.error();
  return WriteFileAtomically(FLAGS_render, *picture);
}

int Main(int argc, char** argv, const Usage& usage) {
  ParseFlagsOrExit2(argc, argv, usage);
  const std::string wrong = WrongFlags();
  if (!wrong.empty()) return Fail(usage, wrong, 2);
  const auto limits = LimitsFromFlag();
  if (!limits) return Fail(usage, limits.error().message, 2);
  const CleanEnd end(usage, {{FLAGS_render, FLAGS_output}, ""});
  const auto done = Run(*limits);
  return done ? 0 : Fail(usage, done.error().message);
}

}  // namespace
}  // namespace tagtwist::internal

int main(int argc, char** argv) {
  return tagtwist::internal::GuardedMain(argc, argv, tagtwist::internal::MapUsage,
                                         tagtwist::internal::Main);
}

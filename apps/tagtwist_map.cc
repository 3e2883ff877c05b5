#include <gflags/gflags.h>
#include <glog/logging.h>

#include <iostream>

#include "apps/usage.h"
#include "estimator/map_svg.h"
#include "estimator/tag_map_file.h"
#include "frontend/atomic_file.h"

DEFINE_string(check, "",
              "Map to check and describe: a configuration, Kalibr aprilgrid, WPILib field, TagSLAM "
              "bodies.");
DEFINE_string(map, "", "Map to render: the same kinds of file; --check's without it.");
DEFINE_double(tag_size_m, 0, "Side of a tag's black square, where the file does not say it.");
DEFINE_string(tag_family, "", "The tags' family, where the file does not say it.");
DEFINE_string(render, "", "SVG to write, in true size: print it at 100 %, or look at it.");

namespace tagtwist {
namespace {

Usage MapUsage() {
  Usage usage;
  usage.program = "tagtwist_map";
  usage.synopsis = "--check FILE | --map FILE --render FILE.svg";
  usage.summary =
      "Checks a map of AprilTags (ids given twice or not in the family, tags that overlap or have\n"
      "no size) and draws it.";
  usage.groups = {{"The map", {"check", "map", "tag_size_m", "tag_family"}},
                  {"What to write", {"render"}}};
  return usage;
}

std::string WrongFlags() {
  if (FLAGS_check.empty() && FLAGS_map.empty()) return "--check or --map: needed, and not given";
  if (!FLAGS_map.empty() && FLAGS_render.empty()) return "--map: expected with --render";
  if (!(FLAGS_tag_size_m >= 0)) return "--tag_size_m: expected > 0";
  return "";
}

Result<TagMap> Read(const std::string& path) {
  TagMapFile file{path, {}, FLAGS_tag_family};
  if (FLAGS_tag_size_m > 0) file.tag_size_m = FLAGS_tag_size_m;
  return ReadTagMapFile(file);
}

Status Run() {
  if (!FLAGS_check.empty()) {
    const auto map = Read(FLAGS_check);
    if (!map) return map.error();
    std::cout << FLAGS_check << ": " << DescribeMap(*map) << "\n";
  }
  if (FLAGS_render.empty()) return Ok();
  const auto map = Read(FLAGS_map.empty() ? FLAGS_check : FLAGS_map);
  if (!map) return map.error();
  const auto svg = MapSvg(*map);
  if (!svg) return svg.error();
  return WriteFileAtomically(FLAGS_render, *svg);
}

}  // namespace
}  // namespace tagtwist

int main(int argc, char** argv) {
  google::InitGoogleLogging(argv[0]);
  const tagtwist::Usage usage = tagtwist::MapUsage();
  tagtwist::ParseFlagsOrExit2(argc, argv, usage);
  const std::string wrong = tagtwist::WrongFlags();
  if (!wrong.empty()) return tagtwist::Fail(usage, wrong, 2);
  const auto done = tagtwist::Run();
  return done ? 0 : tagtwist::Fail(usage, done.error().message);
}

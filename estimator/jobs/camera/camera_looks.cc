#include "estimator/jobs/camera/camera_looks.h"

#include <algorithm>
#include <map>
#include <string>
#include <utility>

#include "estimator/calibration/lens/layout_from_nothing.h"
#include "estimator/jobs/camera/measure_looks.h"
#include "frontend/tags/tag_finder.h"
#include "frontend/types/rig.h"

namespace tagtwist::internal {
namespace {

Result<std::vector<FrameMeasurements>> PatternCorners(const CameraJob& job,
                                                      const std::vector<Look>& looks,
                                                      const SetUp& set_up) {
  auto measured = Measure(
      looks, job.threads, [&] { return TagFinder::Create(set_up, TagDetectorOptions()); },
      [](const TagFinder& finder, const cv::Mat& image) { return finder.Find(image); });
  if (!measured) return measured.error();
  return Usable(std::move(*measured));
}

// Those of the stamps, which are sorted.
template <typename Stamped>
std::vector<Stamped> OfStamps(const std::vector<Stamped>& all,
                              const std::vector<int64_t>& stamps_ns) {
  std::vector<Stamped> out;
  for (const Stamped& one : all) {
    if (std::binary_search(stamps_ns.begin(), stamps_ns.end(), one.t_ns)) out.push_back(one);
  }
  return out;
}

}  // namespace

std::string AsSentence(const std::vector<std::string>& lines) {
  std::string out;
  for (const std::string& line : lines) out += (out.empty() ? "" : "; ") + line;
  return out;
}

Status TakeSize(const Frame& frame, Looks* looks) {
  if (frame.image.empty()) return Ok();
  if (looks->width == 0) looks->width = frame.image.cols, looks->height = frame.image.rows;
  if (frame.image.cols == looks->width && frame.image.rows == looks->height) return Ok();
  return Error{frame.name + ": the image's size differs from those before"};
}

std::vector<TagDetection> TagsOfMap(const std::vector<TagDetection>& tags, const TagMap& map,
                                    const Looks& size, double border_px) {
  const bool is_any = map.tags().empty();
  std::map<int, int> count;
  for (const TagDetection& tag : tags) ++count[tag.id];
  std::vector<TagDetection> out;
  for (const TagDetection& tag : tags) {
    const bool is_whole = std::all_of(tag.corners.begin(), tag.corners.end(), [&](const auto& c) {
      return c.x() >= border_px && c.y() >= border_px && c.x() <= size.width - 1 - border_px &&
             c.y() <= size.height - 1 - border_px;
    });
    if (is_whole && count[tag.id] == 1 && (is_any || map.Find(tag.id) != nullptr))
      out.push_back(tag);
  }
  return out;
}

Result<StartedLooks> StartLooks(const TagMap& map, const Looks& looks,
                                const std::vector<FrameMeasurements>& first) {
  constexpr double kAnySideM = 0.1;
  StartedLooks out{map, first, {}};
  const bool learns = map.tags().empty();
  if (learns) {
    auto layout = LayoutFromNothing(first, {looks.width, looks.height, map.family(), kAnySideM});
    if (!layout) {
      return Error{
          "without --map where the tags are is learned, and cannot be: " + layout.error().message +
          " (--map FILE says it, --tag_family their family, " + map.family() + ")"};
    }
    out.map = std::move(*layout);
    out.frames = OfMap(first, out.map);
  }
  auto starts = StartLens(out.frames, out.map, looks.width, looks.height);
  if (!starts) return starts.error();
  out.starts = std::move(*starts);
  out.starts.map_is_learned = learns;
  return out;
}

Result<LensFound> FindLensOfLooks(const CameraJob& job, const TagMap& map, const Looks& looks,
                                  const std::vector<FrameMeasurements>& first) {
  const auto named = [&](const Error& error) {
    return Error{job.recording + ": " + error.message};
  };
  auto started = StartLooks(map, looks, first);
  if (!started) return named(started.error());
  LensStarts& starts = started->starts;
  if (!starts.missing.empty() && !job.accepts_poor) {
    return named({"not calibrated, since its views are not good: " + AsSentence(starts.missing) +
                  " (--accept_poor calibrates all the same)"});
  }
  auto found = FindLens(OfStamps(started->frames, starts.stamps_ns), started->map, starts);
  if (!found) return named(found.error());
  if (job.use_detections) return found;
  const SetUp& set_up = found->calibration.set_up;
  const Camera& camera = set_up.rig.front().camera;
  const TagMap& where = starts.map_is_learned ? set_up.map : started->map;
  const auto measured = PatternCorners(job, OfStamps(looks.looks, starts.stamps_ns),
                                       MakeSetUp(camera, Pose(), where));
  if (!measured) return measured.error();
  starts.cameras = {{camera.lens, camera}};
  starts.best = camera.lens;
  auto refined = FindLens(*measured, where, starts);
  if (!refined) return named(refined.error());
  return refined;
}

}  // namespace tagtwist::internal

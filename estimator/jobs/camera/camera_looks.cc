#include "estimator/jobs/camera/camera_looks.h"

#include <algorithm>
#include <map>
#include <string>
#include <utility>

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
  std::map<int, int> count;
  for (const TagDetection& tag : tags) ++count[tag.id];
  std::vector<TagDetection> out;
  for (const TagDetection& tag : tags) {
    const bool is_whole = std::all_of(tag.corners.begin(), tag.corners.end(), [&](const auto& c) {
      return c.x() >= border_px && c.y() >= border_px && c.x() <= size.width - 1 - border_px &&
             c.y() <= size.height - 1 - border_px;
    });
    if (is_whole && count[tag.id] == 1 && map.Find(tag.id) != nullptr) out.push_back(tag);
  }
  return out;
}

Result<LensFound> FindLensOfLooks(const CameraJob& job, const TagMap& map, const Looks& looks,
                                  const std::vector<FrameMeasurements>& first) {
  const auto named = [&](const Error& error) {
    return Error{job.recording + ": " + error.message};
  };
  auto starts = StartLens(first, map, looks.width, looks.height);
  if (!starts) return named(starts.error());
  if (!starts->missing.empty() && !job.accepts_poor) {
    return named({"not calibrated, since its views are not good: " + AsSentence(starts->missing) +
                  " (--accept_poor calibrates all the same)"});
  }
  const std::vector<FrameMeasurements> spread = OfStamps(first, starts->stamps_ns);
  auto found = FindLens(spread, map, *starts);
  if (!found) return named(found.error());
  if (job.use_detections) return found;
  const Camera& camera = found->calibration.set_up.rig.front().camera;
  const auto measured =
      PatternCorners(job, OfStamps(looks.looks, starts->stamps_ns), MakeSetUp(camera, Pose(), map));
  if (!measured) return measured.error();
  starts->cameras = {{camera.lens, camera}};
  starts->best = camera.lens;
  auto refined = FindLens(*measured, map, *starts);
  if (!refined) return named(refined.error());
  return refined;
}

}  // namespace tagtwist::internal

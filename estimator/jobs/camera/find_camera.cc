#include "estimator/jobs/camera/find_camera.h"

#include <algorithm>
#include <cstdint>
#include <map>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <utility>
#include <vector>

#include "estimator/jobs/on_threads.h"
#include "estimator/jobs/progress.h"
#include "frontend/io/recordings/data_source.h"
#include "frontend/tags/tag_detector.h"
#include "frontend/tags/tag_finder.h"
#include "frontend/types/rig.h"

namespace tagtwist::internal {
namespace {

// A frame that was looked at.
struct Look {
  int64_t t_ns = 0;
  cv::Mat image;                   // empty where the corners are given
  std::vector<TagDetection> tags;  // given
};
struct Looks {
  int width = 0, height = 0;
  std::vector<Look> looks;
};

// Frames between two places that are looked at.
size_t StepOf(size_t n_frames, const cv::Mat& image) {
  constexpr size_t kMostPlaces = 80, kMostBytes = size_t{256} << 20;
  const size_t bytes = std::max<size_t>(1, image.total());
  const size_t places = std::clamp<size_t>(kMostBytes / bytes / 2, 20, kMostPlaces);
  return std::max<size_t>(1, n_frames / places);
}

Status TakeSize(const Frame& frame, Looks* out) {
  if (frame.image.empty()) return Ok();
  if (out->width == 0) out->width = frame.image.cols, out->height = frame.image.rows;
  if (frame.image.cols == out->width && frame.image.rows == out->height) return Ok();
  return Error{frame.name + ": the image's size differs from those before"};
}

// Places spread over the recording, with the frame that follows each.
Result<Looks> LookAt(const CameraJob& job) {
  auto source =
      OpenDataSource(job.recording, {job.use_detections, !job.use_detections, {}, job.topic});
  if (!source) return source.error();
  const size_t n = (*source)->stamps_ns().size();
  Progress progress("looking", n);
  Looks out;
  out.width = job.width, out.height = job.height;
  std::optional<size_t> step;
  for (size_t i = 0;; ++i) {
    auto frame = (*source)->Next();
    if (!frame) return frame.error();
    if (!*frame) break;
    progress.Update(i + 1);
    if (const Status sized = TakeSize(**frame, &out); !sized) return sized.error();
    if (!step && (job.use_detections || !(*frame)->image.empty()))
      step = StepOf(n, (*frame)->image);
    if (!step || i % *step > (*step > 2 ? 1 : 0)) continue;
    out.looks.push_back({(*frame)->t_ns, (*frame)->image, (*frame)->detections});
  }
  if (out.width > 0 && out.height > 0) return out;
  return Error{job.recording + ": no image tells the size of the camera's (--image_size says it)"};
}

// Those of the map that are seen once, clear of the border.
std::vector<TagDetection> OfMap(const std::vector<TagDetection>& tags, const TagMap& map,
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

// Finds the tags of each look by finders that `make` makes, one a thread.
template <typename Make, typename Find>
Result<std::vector<FrameMeasurements>> Measure(const std::vector<Look>& looks, int threads,
                                               const Make& make, const Find& find) {
  if (auto one = make(); !one) return one.error();
  std::vector<FrameMeasurements> out(looks.size());
  OnThreads(threads)(looks.size(), [&](size_t first, size_t last) {
    const auto finder = make();
    for (size_t i = first; i < last; ++i) {
      out[i].t_ns = looks[i].t_ns;
      if (finder) out[i].tags = find(*finder, looks[i].image);
    }
  });
  return out;
}

// With two tags or more.
std::vector<FrameMeasurements> Usable(std::vector<FrameMeasurements> frames) {
  const auto too_few = [](const FrameMeasurements& frame) { return frame.tags.size() < 2; };
  frames.erase(std::remove_if(frames.begin(), frames.end(), too_few), frames.end());
  return frames;
}

// Corners that need no lens to be found.
Result<std::vector<FrameMeasurements>> FirstCorners(const CameraJob& job, const Looks& looks,
                                                    const TagMap& map) {
  const TagDetectorOptions options;
  const double border_px = job.use_detections ? 0 : options.border_px;
  std::vector<FrameMeasurements> out;
  if (job.use_detections) {
    for (const Look& look : looks.looks) {
      out.emplace_back();
      out.back().t_ns = look.t_ns;
      out.back().tags = look.tags;
    }
  } else {
    auto measured = Measure(
        looks.looks, job.threads, [&] { return TagDetector::Create(map.family(), options); },
        [](const TagDetector& detector, const cv::Mat& image) { return detector.Detect(image); });
    if (!measured) return measured.error();
    out = std::move(*measured);
  }
  for (FrameMeasurements& frame : out) frame.tags = OfMap(frame.tags, map, looks, border_px);
  return Usable(std::move(out));
}

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

std::string Joined(const std::vector<std::string>& lines) {
  std::string out;
  for (const std::string& line : lines) out += (out.empty() ? "" : "; ") + line;
  return out;
}

}  // namespace

Result<LensFound> FindCamera(const CameraJob& job, const TagMap& map) {
  const auto named = [&](const Error& error) {
    return Error{job.recording + ": " + error.message};
  };
  const auto looks = LookAt(job);
  if (!looks) return looks.error();
  const auto seen = FirstCorners(job, *looks, map);
  if (!seen) return seen.error();
  auto starts = StartLens(*seen, map, looks->width, looks->height);
  if (!starts) return named(starts.error());
  if (!starts->missing.empty() && !job.accepts_poor) {
    return named({"not calibrated, since its views are not good: " + Joined(starts->missing) +
                  " (--accept_poor calibrates all the same)"});
  }
  const std::vector<FrameMeasurements> spread = OfStamps(*seen, starts->stamps_ns);
  auto found = FindLens(spread, map, *starts);
  if (!found) return named(found.error());
  if (job.use_detections) return found;
  const Camera& camera = found->calibration.set_up.rig.front().camera;
  const auto measured = PatternCorners(job, OfStamps(looks->looks, starts->stamps_ns),
                                       MakeSetUp(camera, Pose(), map));
  if (!measured) return measured.error();
  starts->cameras = {{camera.lens, camera}};
  starts->best = camera.lens;
  auto refined = FindLens(*measured, map, *starts);
  if (!refined) return named(refined.error());
  return refined;
}

}  // namespace tagtwist::internal

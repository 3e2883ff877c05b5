#include "estimator/jobs/camera/find_camera.h"

#include <algorithm>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "estimator/jobs/camera/camera_looks.h"
#include "estimator/jobs/camera/measure_looks.h"
#include "estimator/jobs/progress.h"
#include "frontend/io/recordings/data_source.h"
#include "frontend/tags/tag_detector.h"

namespace tagtwist::internal {
namespace {

// Frames between two places that are looked at.
size_t StepOf(size_t n_frames, const cv::Mat& image) {
  constexpr size_t kMostPlaces = 80, kMostBytes = size_t{256} << 20;
  const size_t bytes = std::max<size_t>(1, image.total());
  const size_t places = std::clamp<size_t>(kMostBytes / bytes / 2, 20, kMostPlaces);
  return std::max<size_t>(1, n_frames / places);
}

// Places spread over the recording, with the frame that follows each.
Result<Looks> LookAt(const CameraJob& job) {
  auto source = OpenDataSource(
      job.recording, {job.use_detections, !job.use_detections, {}, job.topic, {}, job.limits});
  if (!source) return source.error();
  for (const std::string& note : (*source)->notes()) {
    if (job.warn) job.warn(note);
  }
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
  for (FrameMeasurements& frame : out) frame.tags = TagsOfMap(frame.tags, map, looks, border_px);
  return Usable(std::move(out));
}

}  // namespace

Result<LensFound> FindCamera(const CameraJob& job, const TagMap& map) {
  const auto looks = LookAt(job);
  if (!looks) return looks.error();
  const auto first = FirstCorners(job, *looks, map);
  if (!first) return first.error();
  return FindLensOfLooks(job, map, *looks, *first);
}

}  // namespace tagtwist::internal

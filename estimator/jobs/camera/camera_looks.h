#pragma once
#include <string>
#include <vector>

#include "estimator/calibration/lens/lens_from_nothing.h"
#include "estimator/jobs/camera/camera_job.h"
#include "estimator/jobs/camera/measure_looks.h"
#include "frontend/base/result.h"
#include "frontend/io/recordings/data_source.h"
#include "frontend/types/measurements.h"
#include "frontend/types/tag_map.h"

namespace tagtwist::internal {

/// Joined by semicolons.
std::string AsSentence(const std::vector<std::string>& lines);

/// The size of the first image; an error where another one has another.
Status TakeSize(const Frame& frame, Looks* looks);

/// Those of the map that are seen once, clear of the border; of a map without tags, all such.
std::vector<TagDetection> TagsOfMap(const std::vector<TagDetection>& tags, const TagMap& map,
                                    const Looks& size, double border_px);

/// What was looked at, with where the tags are, and lenses to start from.
struct StartedLooks {
  TagMap map;
  std::vector<FrameMeasurements> frames;
  LensStarts starts;
};
/// A map without tags is learned from the frames (LayoutFromNothing).
Result<StartedLooks> StartLooks(const TagMap& map, const Looks& looks,
                                const std::vector<FrameMeasurements>& first);

/// The lens by what was looked at, from `first`: corners that need no lens to be found, two tags or
/// more a frame. Errors name job.recording.
Result<LensFound> FindLensOfLooks(const CameraJob& job, const TagMap& map, const Looks& looks,
                                  const std::vector<FrameMeasurements>& first);

}  // namespace tagtwist::internal

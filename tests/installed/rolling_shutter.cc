// Corners of a rolling shutter, told by CONFIG's line_time_s: rolling_shutter CONFIG RECORDING
#include <tagtwist/estimator/batch/batch.h>
#include <tagtwist/estimator/online/config.h>
#include <tagtwist/frontend/io/recordings/data_source.h>
#include <tagtwist/frontend/tags/filter_tags.h>

#include "example.h"

int main(int, char** argv) {
  const auto config = OrExit(tagtwist::LoadConfig(argv[1]));
  const auto source = OrExit(tagtwist::OpenDataSource(argv[2], {/*use_detections=*/true}));
  const auto& [rig, map] = config.set_up;
  tagtwist::FrontEnd front_end(config.set_up, config.front_end);
  tagtwist::BatchEstimator batch(config.set_up, config.estimator);
  while (const auto frame = OrExit(source->Next())) {
    const auto tags = tagtwist::FilterTags(frame->detections, map, rig.front().camera, 1.5);
    batch.Add(front_end.Process(frame->t_ns, tags, frame->image));
  }
  return Judge(OrExit(batch.Solve()).frames, source->ground_truth());
}

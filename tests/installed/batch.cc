// A recording as a whole, from its images: batch CONFIG RECORDING
#include <tagtwist/estimator/batch/batch.h>
#include <tagtwist/estimator/online/config.h>
#include <tagtwist/frontend/io/recordings/data_source.h>
#include <tagtwist/frontend/tags/tag_finder.h>

#include "example.h"

int main(int, char** argv) {
  const auto config = OrExit(tagtwist::LoadConfig(argv[1]));
  const auto source = OrExit(tagtwist::OpenDataSource(argv[2], {}));
  auto finder = OrExit(tagtwist::TagFinder::Create(config.set_up, config.front_end.detector));
  tagtwist::FrontEnd front_end(config.set_up, config.front_end);
  tagtwist::BatchEstimator batch(config.set_up, config.estimator);
  while (const auto frame = OrExit(source->Next())) {
    batch.Add(front_end.Process(frame->t_ns, finder.Find(frame->image), frame->image));
  }
  const auto estimate = OrExit(batch.Solve());
  return Judge(estimate.frames, source->ground_truth());
}

// Frame by frame, as from a camera: online CONFIG RECORDING
#include <tagtwist/estimator/online/online_estimator.h>
#include <tagtwist/frontend/io/recordings/data_source.h>

#include "example.h"

int main(int, char** argv) {
  const auto config = OrExit(tagtwist::LoadConfig(argv[1]));
  const auto source = OrExit(tagtwist::OpenDataSource(argv[2], {}));
  auto estimator = OrExit(tagtwist::OnlineEstimator::Create(config));
  std::vector<tagtwist::FrameEstimate> states;
  while (const auto frame = OrExit(source->Next())) {
    states.push_back(OrExit(estimator.AddImage(frame->t_ns, frame->image)).current);
  }
  return Judge(states, source->ground_truth());
}

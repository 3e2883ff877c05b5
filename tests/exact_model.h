#pragma once
#include <cstdint>
#include <random>
#include <vector>

#include "estimator/graph_builder.h"
#include "frontend/types/body_state.h"
#include "frontend/types/measurements.h"

namespace tagtwist {

/// A flight over the course's mat drawn from the estimator's own model: states from white noise on
/// acceleration, corners with Gaussian noise. What an estimator says of its errors must then hold.
struct ExactModelOptions {
  int frames = 60;
  double rate_hz = 50;
  double accel_psd = 0.05, angular_accel_psd = 0.05;
  double corner_sigma_px = 0.15;
  int max_tags = 6;  // the first ones in view, by id
  unsigned seed = 1;
};

struct ExactModelFlight {
  std::vector<BodyState> truth;
  std::vector<FrameMeasurements> measurements;
};

ExactModelFlight DrawFlight(const ExactModelOptions& options);

/// The course's camera, mount and mat.
EstimatorSetup CourseSetup(const EstimatorOptions& options = {});

}  // namespace tagtwist

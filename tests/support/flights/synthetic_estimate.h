#pragma once
#include <Eigen/Cholesky>
#include <string>
#include <vector>

#include "estimator/result/estimate.h"
#include "estimator/result/run_facts.h"
#include "tests/support/evaluation_data.h"

namespace tagtwist::internal {

/// What an estimator would say of the smooth flight of evaluation_data.h: optimised states drawn
/// from their own covariance, a closed form with ten times that error and low-passed noise, every
/// 40th frame without tags, and in window mode two frames without a state at the start.
inline Estimate SyntheticEstimate(size_t frames, bool window) {
  std::mt19937_64 rng(11);
  Estimate e;
  e.mode = window ? EstimateMode::kSlidingWindow : EstimateMode::kBatch;
  e.noise.source = NoiseSource::kLearned;
  StateVector low_pass = StateVector::Zero();
  for (size_t i = 0; i < frames; ++i) {
    FrameEstimate f;
    f.t_ns = 100'000'000 + static_cast<int64_t>(i) * 20'400'000;
    const BodyState truth = SmoothState(ToSeconds(f.t_ns));
    f.covariance = RealisticCovariance(rng);
    const StateVector error = f.covariance.llt().matrixL() * NormalVector(rng);
    f.state = Retract(truth, -error);
    f.n_tags = i % 40 == 39 ? 0 : 6 + static_cast<int>(i % 7);
    f.n_tracks = 60 + static_cast<int>(i % 13);
    f.status = f.n_tags == 0 ? FrameStatus::kPredicted : FrameStatus::kOk;
    if (f.n_tags > 0) {
      const StateVector draw = f.covariance.llt().matrixL() * NormalVector(rng);
      const StateVector plain = 10 * draw;
      low_pass = 0.8 * low_pass + 0.2 * plain;
      f.closed_form.world_from_body = Retract(truth, 0.3 * plain).world_from_body;
      if (i > 0) {
        f.closed_form.twist_plain = Retract(truth, 1.5 * plain).twist;
        f.closed_form.twist_ransac = Retract(truth, plain).twist;
        f.closed_form.twist_low_pass = Retract(truth, low_pass).twist;
      }
    }
    if (window && i < 2) {
      f = FrameEstimate();
      f.t_ns = 100'000'000 + static_cast<int64_t>(i) * 20'400'000;
    }
    e.frames.push_back(f);
    for (int k = 0; k < 4 * f.n_tags; ++k) {
      e.reprojection_px.push_back(0.2 * std::abs(NormalVector(rng)(0)));
    }
  }
  if (window) e.lagged = e.frames;
  e.warnings = {"images/000017.png: cannot decode; the frame keeps its state from its neighbours"};
  return e;
}

/// What the run over those frames took.
inline RunFacts SyntheticFacts(const std::string& dataset, size_t frames) {
  RunFacts facts;
  facts.dataset = dataset;
  facts.wall_s = 12.5;
  facts.peak_rss_mib = 200.25;
  for (size_t i = 0; i < frames; ++i) {
    const double jitter = 0.1 * static_cast<double>(i % 9);
    facts.times.detect_ms.push_back(3 + jitter);
    facts.times.track_ms.push_back(1 + jitter);
    facts.times.seed_ms.push_back(0.5 + jitter);
    facts.times.frame_ms.push_back(4.5 + 3 * jitter);
  }
  facts.times.optimise_ms = {123.0};
  return facts;
}

}  // namespace tagtwist::internal

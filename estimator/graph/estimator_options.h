#pragma once
#include <array>
#include <optional>
#include <string>
#include <utility>

#include "frontend/base/named_enum.h"

namespace tagtwist {

/// What of the motion is white noise. kAuto: the one whose density is given; else in batch the one
/// that the data make likelier, in the window the jerk.
enum class MotionPriorChoice { kAuto, kAcceleration, kJerk };
template <>
struct EnumNames<MotionPriorChoice> {
  static constexpr std::array<std::pair<MotionPriorChoice, const char*>, 3> kAll = {
      {{MotionPriorChoice::kAuto, "auto"},
       {MotionPriorChoice::kAcceleration, "acceleration"},
       {MotionPriorChoice::kJerk, "jerk"}}};
};

/// When the frames were taken: at their stamps, or at the ticks of a steady clock fitted to them.
/// kAuto: the steady clock where the images say so clearly.
enum class ClockChoice { kAuto, kStamps, kSteady };
template <>
struct EnumNames<ClockChoice> {
  static constexpr std::array<std::pair<ClockChoice, const char*>, 3> kAll = {
      {{ClockChoice::kAuto, "auto"},
       {ClockChoice::kStamps, "stamps"},
       {ClockChoice::kSteady, "steady"}}};
};

/// What solves the graphs. kAuto: by itself each what suits it, bands and chains where there are no
/// tracked points; kCeres: Ceres all of them, which is slower and ends at the same states.
enum class Solver { kAuto, kCeres };
template <>
struct EnumNames<Solver> {
  static constexpr std::array<std::pair<Solver, const char*>, 2> kAll = {
      {{Solver::kAuto, "auto"}, {Solver::kCeres, "ceres"}}};
};

/// What the factor graph is built with. A noise parameter that is not given is learned from the
/// data. Field names are the YAML keys of the section `estimator`.
struct EstimatorOptions {
  std::optional<double> corner_sigma_px;    // one corner coordinate [px], > 0
  std::optional<double> track_sigma_px;     // one track coordinate [px], > 0
  std::optional<double> accel_psd;          // white noise on acceleration [(m/s^2)^2/Hz], > 0
  std::optional<double> angular_accel_psd;  // [(rad/s^2)^2/Hz], > 0
  std::optional<double> jerk_psd;           // white noise on jerk [(m/s^3)^2/Hz], > 0
  std::optional<double> angular_jerk_psd;   // [(rad/s^3)^2/Hz], > 0
  MotionPriorChoice motion_prior = MotionPriorChoice::kAuto;
  ClockChoice clock = ClockChoice::kAuto;
  std::optional<double> stamp_sigma_s;  // of each frame's stamp where no clock is fitted [s], >= 0
  Solver solver = Solver::kAuto;
  bool systematic_errors = true;  // of lens, map and corners are in the covariance: those given
                                  // below, and the others as residuals show them
  std::optional<double> lens_field_sigma_px;   // what the lens leaves, of a corner [px], >= 0
  std::optional<double> tag_sigma_m;           // of each coordinate of a tag's place [m], >= 0
  std::optional<double> corner_bias_sigma_px;  // of all corners, along diagonals [px], >= 0
  std::optional<double> focal_sigma;           // of the focal length, relative, >= 0; never learned
  bool use_tracks = true;                      // KLT tracks enter the graph
  int max_tracks_per_frame = 40;               // in the graph, >= 0
  int track_segment_frames = 6;  // a track enters in pieces of at most this many frames, >= 2
  double robust_scale = 2.0;     // Huber threshold, in root mean squares of a block, > 0
  int window_frames = 15;        // states in the sliding window, >= 2
  int max_iterations = 30;       // of a batch solve, >= 1
  int window_iterations = 4;     // of a window's solve at each frame, >= 1

  std::optional<std::string> Problem() const;

  template <typename Self, typename Visitor>
  static void VisitFields(Self& self, Visitor&& visit) {
    visit("corner_sigma_px", self.corner_sigma_px);
    visit("track_sigma_px", self.track_sigma_px);
    visit("accel_psd", self.accel_psd);
    visit("angular_accel_psd", self.angular_accel_psd);
    visit("jerk_psd", self.jerk_psd);
    visit("angular_jerk_psd", self.angular_jerk_psd);
    visit("motion_prior", self.motion_prior);
    visit("clock", self.clock);
    visit("stamp_sigma_s", self.stamp_sigma_s);
    visit("solver", self.solver);
    visit("systematic_errors", self.systematic_errors);
    visit("lens_field_sigma_px", self.lens_field_sigma_px);
    visit("tag_sigma_m", self.tag_sigma_m);
    visit("corner_bias_sigma_px", self.corner_bias_sigma_px);
    visit("focal_sigma", self.focal_sigma);
    visit("use_tracks", self.use_tracks);
    visit("max_tracks_per_frame", self.max_tracks_per_frame);
    visit("track_segment_frames", self.track_segment_frames);
    visit("robust_scale", self.robust_scale);
    visit("window_frames", self.window_frames);
    visit("max_iterations", self.max_iterations);
    visit("window_iterations", self.window_iterations);
  }
};

}  // namespace tagtwist

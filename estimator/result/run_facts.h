#pragma once
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "frontend/base/files/input_digest.h"

namespace tagtwist::internal {
struct RunTally;
}  // namespace tagtwist::internal

namespace tagtwist {

/// Milliseconds spent on each frame, stage by stage; one entry a frame, or empty. In batch mode
/// optimise_ms has one entry: the whole solve.
struct StageTimes {
  std::vector<double> detect_ms, track_ms, seed_ms, optimise_ms, frame_ms;
};

/// Of milliseconds of which some alone are kept: what all of them are.
struct TimeTotal {
  size_t count = 0;
  double sum_ms = 0, max_ms = 0;
};

/// Of StageTimes.
struct StageTotals {
  TimeTotal detect, track, seed, optimise, frame;
  size_t frames_late = 0;  // that took longer than their deadline
};

/// A run whose frames came when they came.
struct LiveRun {
  size_t frames_dropped = 0;            // came while others waited
  std::vector<double> latency_ms;       // from stamp to state, one a frame
  std::optional<TimeTotal> total = {};  // where these are of some frames alone
};

/// Facts of a run, which its estimate does not depend on.
struct RunFacts {
  std::string dataset;      // as the user named it
  double wall_s = 0;        // from start to the writing of the results
  double peak_rss_mib = 0;  // largest memory held so far
  StageTimes times = {};
  /// Where estimate and times have some frames of a long run alone, evenly spread: what all of them
  /// are, of the estimate and of other bodies'. Else nullptr, and empty.
  std::shared_ptr<const internal::RunTally> all = {};
  std::vector<std::shared_ptr<const internal::RunTally>> all_of_others = {};
  std::optional<StageTotals> totals = {};  // where the times are of some frames alone
  std::optional<LiveRun> live = {};
  std::optional<double> deadline_ms = {};  // of a frame, where there was one
  std::vector<InputFile> inputs = {};      // that the run read
  std::vector<std::string> taken = {};     // what it took from them: a line each
  std::vector<std::string> doubts = {};    // mistakes in the set-up that it gives away: a sentence
                                           // each, the likeliest first
  std::string configuration = {};          // as it was resolved: YAML, and the map's digest
};

}  // namespace tagtwist

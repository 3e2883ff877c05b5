#pragma once
#include <cstddef>
#include <deque>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "estimator/publish/picture_json.h"
#include "estimator/publish/published_frame.h"

namespace tagtwist::internal {

/// A tag that the states of the last seconds were made without.
struct SetAside {
  int id = -1;
  std::string why;
  double share = 0;  // of the frames with a state that saw it
};

/// What the frames of the last ten seconds, by their stamps, say of a body's estimate, in words for
/// the person who watches. It judges nothing that takes longer to be seen: the report does.
class LiveVerdict {
 public:
  void Add(const PublishedFrame& frame, size_t body, const PictureNumbers& numbers);
  /// A sentence or two.
  std::string Text() const;
  /// Those left out in at least a tenth of the frames that saw them, by id.
  std::vector<SetAside> Aside() const;
  /// Milliseconds: the quantile of the latencies; 0 without a frame.
  double LatencyMs(double quantile) const;
  /// Frames a second.
  double RateHz() const;

 private:
  struct Entry {
    int64_t t_ns = 0;
    FrameStatus status = FrameStatus::kNoFix;
    int n_seen = 0;
    double latency_ms = 0;
    size_t dropped = 0;
    std::vector<std::pair<int, bool>> tags;  // id, used; of frames with a state
  };
  double Share(FrameStatus status) const;
  std::deque<Entry> entries_;
  std::map<int, std::string> why_;  // the latest word on each tag
};

/// Those of a run's bodies.
class LiveVerdicts {
 public:
  explicit LiveVerdicts(const PublishedRun& run);
  void Add(const PublishedFrame& frame, const PictureNumbers& numbers);
  /// A sentence or two; of several bodies each is named.
  std::string Text() const;
  /// What the page is told once a second, as one JSON object: `status` and `verdict` of each body,
  /// rate, latency, tags set aside. `recording_json`: of the recording, or "null".
  std::string FactsJson(const PublishedFrame& last, const std::string& recording_json) const;

 private:
  std::vector<std::string> names_;
  std::vector<LiveVerdict> verdicts_;
};

}  // namespace tagtwist::internal

#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "estimator/publish/published_frame.h"
#include "frontend/base/result.h"

namespace tagtwist::internal {

/// Where a run's frames go.
struct PublishOptions {
  std::vector<std::string> udp;  // "host:port"
  std::string mcap;              // a file; empty: none
  std::string record;            // a folder or an .mkv for the images; empty: none
  bool page = false, foxglove = false;
  uint16_t port = 0;                  // of both; 0: any that is free
  std::optional<std::string> listen;  // an IP address, with a token; nullopt: this machine alone
  bool waits = false;                 // for files, which then lack no frame: the run is not live
  bool IsAsked() const {
    return !udp.empty() || !mcap.empty() || !record.empty() || page || foxglove;
  }
};

/// Sends frames to whoever wants them, in threads of its own. Files and readers that cannot keep up
/// lose frames, which are counted; whoever publishes loses no time.
class Publisher {
 public:
  /// An error names the place that cannot be had.
  static Result<std::unique_ptr<Publisher>> Start(const PublishOptions& options,
                                                  const PublishedRun& run);
  virtual ~Publisher() = default;

  virtual void Publish(FramePtr frame) = 0;
  /// What to open, a line each: "page       http://127.0.0.1:8765/".
  virtual std::vector<std::string> Links() const = 0;

  /// What was not published, at the end.
  struct Losses {
    std::vector<std::string> warnings;  // frames that were dropped, a line each
    std::string failure;                // of a file, which lacks what came after; empty: none
  };
  /// Waits until all is written. Once, and nothing may be published afterwards.
  virtual Losses Finish() = 0;
};

}  // namespace tagtwist::internal

#pragma once
#include <atomic>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "estimator/publish/image_recorder.h"
#include "estimator/publish/mcap/mcap_writer.h"
#include "estimator/publish/published_frame.h"
#include "estimator/publish/worker.h"

namespace tagtwist::internal {

/// A file or folder that gets frames in a thread of its own.
class Outlet {
 public:
  virtual ~Outlet() = default;
  virtual void Push(const FramePtr& frame) = 0;
  /// Waits until all is written; why not all is, one line.
  virtual std::string Finish() = 0;
  virtual size_t dropped() const = 0;
};

/// `waits`: nothing is dropped.
Result<std::unique_ptr<Outlet>> OpenMcapOutlet(const std::string& path, const PublishedRun& run,
                                               bool waits);

/// Images of a run; whether it takes any can be switched. "folder" is the place's name.
class RecordingOutlet : public Outlet {
 public:
  virtual void Switch(bool on) = 0;
  /// {"on": ..., "frames": ..., "dropped": ..., "folder": ..., "problem": ...}.
  virtual std::string Json() const = 0;
};
/// A video (lossless_video.h) where the place ends in .mkv, else a folder (image_recorder.h), of
/// several cameras one with a folder for each.
Result<std::unique_ptr<RecordingOutlet>> OpenRecording(const std::string& place, const Rig& rig,
                                                       bool waits);

/// JPEG of an 8-bit gray image; empty where it cannot be.
std::string EncodeJpeg(const cv::Mat& gray);

}  // namespace tagtwist::internal

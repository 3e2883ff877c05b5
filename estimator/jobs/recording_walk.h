#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "estimator/jobs/progress.h"
#include "estimator/jobs/run_options.h"
#include "estimator/result/run_facts.h"
#include "frontend/base/result.h"

namespace tagtwist::internal {

/// The account that every run keeps of the frames of a recording that it goes through.
class RecordingWalk {
 public:
  /// `n_frames`: how many there may be, for the bar.
  RecordingWalk(std::string dataset, size_t n_frames, const RunOptions& options);

  /// Whether the options leave room for another frame.
  bool HasRoom() const { return n_frames_ < options_.max_frames; }
  /// Whether a frame of that stamp, the next one, is before the end that the options set.
  bool Takes(int64_t t_ns);
  /// A frame was taken; `image_problem` is empty where there is none.
  void Add(const std::string& image_problem, bool has_tags);
  /// That error, of the frame that is being worked on.
  Error OfFrame(const Error& error) const;
  /// At the end, which takes the bar away: an error where no frame shows a tag; else what there is
  /// to warn of.
  Result<std::vector<std::string>> Finish();

 private:
  std::string ImageProblemsText() const;

  std::string dataset_;
  RunOptions options_;
  std::optional<Progress> progress_;
  size_t n_frames_ = 0, n_image_problems_ = 0;
  std::string first_image_problem_;
  bool has_tags_ = false;
  std::optional<int64_t> first_ns_;
};

}  // namespace tagtwist::internal

#include "estimator/jobs/recording_walk.h"

#include <utility>

namespace tagtwist::internal {

RecordingWalk::RecordingWalk(std::string dataset, size_t n_frames, const RunOptions& options)
    : dataset_(std::move(dataset)), options_(options) {
  if (options.progress) progress_.emplace("estimating", n_frames);
}

bool RecordingWalk::Takes(int64_t t_ns) {
  if (!first_ns_) first_ns_ = t_ns;
  return t_ns - *first_ns_ <= options_.duration_ns;
}

void RecordingWalk::Add(const std::string& image_problem, bool has_tags) {
  if (!image_problem.empty() && n_image_problems_++ == 0) first_image_problem_ = image_problem;
  has_tags_ = has_tags_ || has_tags;
  ++n_frames_;
  if (progress_) progress_->Update(n_frames_);
}

Error RecordingWalk::OfFrame(const Error& error) const {
  return Error{dataset_ + ": frame " + std::to_string(n_frames_) + ": " + error.message};
}

std::string RecordingWalk::ImageProblemsText() const {
  if (n_image_problems_ == 1) {
    return first_image_problem_ + "; the frame's state comes from its neighbours";
  }
  return first_image_problem_ + "; so with " + std::to_string(n_image_problems_) +
         " images: their states come from others";
}

Result<std::vector<std::string>> RecordingWalk::Finish() {
  progress_.reset();
  if (n_frames_ == 0) return Error{dataset_ + ": has no frame"};
  if (!has_tags_ && n_image_problems_ > 0) {
    return Error{first_image_problem_ + ", and no other frame shows a tag"};
  }
  if (!has_tags_) return Error{dataset_ + ": no frame shows a tag of the map"};
  if (n_image_problems_ == 0) return std::vector<std::string>();
  return std::vector<std::string>{ImageProblemsText()};
}

}  // namespace tagtwist::internal

#include "estimator/start/set_up_check.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "estimator/rig/rig_tags.h"
#include "estimator/start/corner_order.h"
#include "frontend/geometry/frame_pose.h"
#include "frontend/geometry/quad_shape.h"

namespace tagtwist::internal {
namespace {

constexpr size_t kFrames = 10;   // are enough
constexpr int kLeastTurned = 5;  // tags
constexpr int kLeastTags = 4;    // of frames with two and more, at the end of a recording

std::vector<TagDetection> OfTurn(const std::vector<TagDetection>& tags, QuadTurn turn) {
  std::vector<TagDetection> out;
  std::copy_if(tags.begin(), tags.end(), std::back_inserter(out),
               [&](const TagDetection& tag) { return TurnOf(tag.corners) == turn; });
  return out;
}

int CountTags(const std::vector<std::vector<TagDetection>>& frames) {
  size_t n = 0;
  for (const std::vector<TagDetection>& tags : frames) n += tags.size();
  return static_cast<int>(n);
}

}  // namespace

SetUpCheck::SetUpCheck(TagMap map, Camera camera)
    : map_(std::move(map)), camera_(std::move(camera)) {}

Status SetUpCheck::Add(const std::vector<TagDetection>& tags) {
  if (frames_are_judged_ && std::all_of(tags.begin(), tags.end(), [](const TagDetection& tag) {
        return TurnOf(tag.corners) != QuadTurn::kClockwise;
      })) {
    anticlockwise_ +=
        static_cast<int>(std::count_if(tags.begin(), tags.end(), [](const TagDetection& tag) {
          return TurnOf(tag.corners) == QuadTurn::kAnticlockwise;
        }));
    return Ok();
  }
  const auto clockwise = OfTurn(tags, QuadTurn::kClockwise);
  const auto anticlockwise = OfTurn(tags, QuadTurn::kAnticlockwise);
  clockwise_ += static_cast<int>(clockwise.size());
  anticlockwise_ += static_cast<int>(anticlockwise.size());
  if (clockwise.size() > 1 && clockwise_frames_.size() < kFrames) {
    clockwise_frames_.push_back(clockwise);
  }
  if (!clockwise.empty()) {
    if (const auto fine = JudgeTurns(kLeastTurned); !fine) return fine;
  }
  if (frames_are_judged_ || anticlockwise.size() < 2) return Ok();
  frames_.push_back(anticlockwise);
  size_factors_.push_back(FitSizeFactor(anticlockwise, map_, camera_));
  const FramePose found = FindFramePose(anticlockwise, map_, camera_, Pose());
  const auto n = std::count(found.tag_inlier.begin(), found.tag_inlier.end(), true);
  if (n > 1) agreeing_tags_ += static_cast<int>(n);
  if (frames_.size() < kFrames) return Ok();
  const auto judged = JudgeFrames(0);
  ForgetFrames();
  return judged;
}

// What tags say that do not agree, as told or otherwise, may be clearer in later frames.
void SetUpCheck::ForgetFrames() {
  constexpr int kRounds = 5;
  frames_are_judged_ = 2 * agreeing_tags_ >= CountTags(frames_) || ++rounds_ == kRounds;
  frames_.clear();
  size_factors_.clear();
  agreeing_tags_ = 0;
}

Status SetUpCheck::Finish() const {
  if (const auto fine = JudgeTurns(1); !fine) return fine;
  return frames_are_judged_ ? Ok() : JudgeFrames(kLeastTags);
}

// A tag cannot be seen clockwise. Single ones are no tags: phantoms.
Status SetUpCheck::JudgeTurns(int least) const {
  if (clockwise_ < least || 5 * clockwise_ < 4 * (clockwise_ + anticlockwise_)) return Ok();
  const auto orders = FittingOrders(clockwise_frames_, map_, camera_);
  return Error{orders.size() == 1 ? CornerOrderText(orders.front()) : ClockwiseText()};
}

Status SetUpCheck::JudgeFrames(int least_tags) const {
  const int n_tags = CountTags(frames_);
  if (n_tags < std::max(least_tags, 1)) return Ok();
  if (const auto factor = CommonSizeFactor(size_factors_)) {
    return Error{SizeFactorText(*factor, map_)};
  }
  if (2 * agreeing_tags_ >= n_tags) return Ok();
  const auto orders = FittingOrders(frames_, map_, camera_);
  const bool as_told = std::any_of(orders.begin(), orders.end(),
                                   [](const CornerOrder& order) { return order.IsRight(); });
  if (orders.empty() || as_told) return Ok();
  return Error{CornerOrderText(orders.front())};
}

RigCheck::RigCheck(const EstimatorSetup& setup) : names_(setup.camera_names) {
  for (const Camera& camera : setup.Cameras()) checks_.emplace_back(setup.map, camera);
}

Status RigCheck::OfCamera(size_t camera, Status status) const {
  if (status || checks_.size() == 1) return status;
  return Error{"camera " + names_[camera] + ": " + status.error().message};
}

Status RigCheck::Add(const std::vector<TagDetection>& tags) {
  if (checks_.size() == 1) return checks_.front().Add(tags);
  for (size_t i = 0; i < checks_.size(); ++i) {
    const auto own = TagsOfCamera(tags, static_cast<int>(i));
    if (const auto fine = checks_[i].Add(own); !fine) return OfCamera(i, fine);
  }
  return Ok();
}

Status RigCheck::Finish() const {
  for (size_t i = 0; i < checks_.size(); ++i) {
    if (const auto fine = checks_[i].Finish(); !fine) return OfCamera(i, fine);
  }
  return Ok();
}

}  // namespace tagtwist::internal

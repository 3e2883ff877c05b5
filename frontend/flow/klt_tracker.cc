#include "frontend/flow/klt_tracker.h"

#include <algorithm>
#include <cmath>
#include <opencv2/video/tracking.hpp>
#include <utility>

#include "frontend/base/statistics/quantile.h"
#include "frontend/flow/corner_picker.h"
#include "frontend/flow/image_noise.h"
#include "frontend/flow/image_shift.h"
#include "frontend/geometry/homography.h"
#include "frontend/geometry/tag_outline.h"

namespace tagtwist::internal {
namespace {

// Homography now_from_last of the tags that both images show; nullopt with fewer than two, or when
// they do not move as one plane.
std::optional<Eigen::Matrix3d> PredictMotion(const std::vector<TagDetection>& last,
                                             const std::vector<TagDetection>& now) {
  std::vector<Eigen::Vector2d> last_points, points;
  for (const TagDetection& tag : now) {
    const auto same = std::find_if(last.begin(), last.end(),
                                   [&](const TagDetection& other) { return other.id == tag.id; });
    if (same == last.end()) continue;
    last_points.insert(last_points.end(), same->corners.begin(), same->corners.end());
    points.insert(points.end(), tag.corners.begin(), tag.corners.end());
  }
  if (points.size() < 8) return std::nullopt;
  auto now_from_last = FitHomography(last_points, points, /*normalise=*/true);
  if (!now_from_last) return std::nullopt;
  constexpr double kMaxErrorPx = 2;
  for (size_t i = 0; i < points.size(); ++i) {
    if (!((Transfer(*now_from_last, last_points[i]) - points[i]).norm() < kMaxErrorPx)) {
      return std::nullopt;
    }
  }
  return now_from_last;
}

cv::Point2f ToPoint(const Eigen::Vector2d& pixel) {
  return {static_cast<float>(pixel.x()), static_cast<float>(pixel.y())};
}

// Where the answer is known to a pixel or two, one level above the full image will do; so it is on
// the way back, which starts at the point that it should find.
int NearLevel(const KltOptions& options) { return std::min(options.pyramid_levels, 1); }

std::vector<cv::Mat> BuildPyramid(const cv::Mat& image, const KltOptions& options) {
  std::vector<cv::Mat> out;
  cv::buildOpticalFlowPyramid(image, out, {options.window_px, options.window_px},
                              options.pyramid_levels, /*withDerivatives=*/true);
  return out;
}

}  // namespace

std::vector<TrackObservation> KltTracker::Track(const cv::Mat& image,
                                                const std::vector<TagDetection>& tags,
                                                size_t tags_elsewhere,
                                                const std::vector<TagDetection>& moving_tags) {
  const bool usable = image.type() == CV_8UC1 && !image.empty();
  if (!usable || (!pyramid_.empty() && pyramid_[0].size() != image.size())) {
    pyramid_.clear();
    tracks_.clear();
  }
  if (!usable || kept_.size() != image.size()) kept_.release();
  if (!usable) return {};
  if (options_.enough_tags > 0 &&
      static_cast<int>(tags.size() + tags_elsewhere) >= options_.enough_tags) {
    pyramid_.clear();
    tracks_.clear();
    image.copyTo(kept_);
    tags_ = tags;
    return {};
  }
  for (TrackObservation& track : tracks_) track.pixel_before.reset();
  if (!kept_.empty()) BeginInKeptImage();
  std::vector<cv::Mat> pyramid = BuildPyramid(image, options_);
  if (!tracks_.empty()) Follow(pyramid, tags);
  Replenish(image);
  MarkOnTag(tags, moving_tags);
  pyramid_ = std::move(pyramid);
  tags_ = tags;
  return tracks_;
}

void KltTracker::BeginInKeptImage() {
  pyramid_ = BuildPyramid(kept_, options_);
  Replenish(kept_);
  for (TrackObservation& track : tracks_) track.pixel_before = track.pixel;
  kept_.release();
}

KltTracker::Step KltTracker::FollowFrom(const std::vector<cv::Mat>& pyramid,
                                        std::vector<cv::Point2f> ahead, int levels) const {
  std::vector<cv::Point2f> start;
  for (const TrackObservation& track : tracks_) start.push_back(ToPoint(track.pixel));
  const cv::Size window(options_.window_px, options_.window_px);
  const cv::TermCriteria criteria(cv::TermCriteria::COUNT | cv::TermCriteria::EPS,
                                  options_.max_iterations, options_.convergence_px);
  std::vector<uchar> ok, back_ok;
  std::vector<float> difference, back_difference;
  cv::calcOpticalFlowPyrLK(pyramid_, pyramid, start, ahead, ok, difference, window, levels,
                           criteria, cv::OPTFLOW_USE_INITIAL_FLOW);
  std::vector<cv::Point2f> back = start;
  cv::calcOpticalFlowPyrLK(pyramid, pyramid_, ahead, back, back_ok, back_difference, window,
                           NearLevel(options_), criteria, cv::OPTFLOW_USE_INITIAL_FLOW);
  const double max_x = pyramid[0].cols - 1 - options_.border_px;
  const double max_y = pyramid[0].rows - 1 - options_.border_px;
  const auto is_inside = [&](const Eigen::Vector2d& pixel) {
    return pixel.x() >= options_.border_px && pixel.y() >= options_.border_px &&
           pixel.x() <= max_x && pixel.y() <= max_y;
  };
  Step out;
  std::vector<double> right, down;
  for (size_t i = 0; i < tracks_.size(); ++i) {
    const Eigen::Vector2d pixel(ahead[i].x, ahead[i].y);
    if (ok[i] != 0 && back_ok[i] != 0 && is_inside(pixel) &&
        difference[i] <= options_.max_difference &&
        cv::norm(back[i] - start[i]) <= options_.forward_backward_px) {
      out.followed.push_back({tracks_[i].track_id, pixel, false, tracks_[i].pixel_before});
      right.push_back(pixel.x() - tracks_[i].pixel.x());
      down.push_back(pixel.y() - tracks_[i].pixel.y());
    }
  }
  if (out.followed.empty()) return out;
  const Eigen::Vector2d common(Quantile(std::move(right), 0.5), Quantile(std::move(down), 0.5));
  const auto in_view =
      std::count_if(tracks_.begin(), tracks_.end(),
                    [&](const TrackObservation& track) { return is_inside(track.pixel + common); });
  out.share = static_cast<double>(out.followed.size()) /
              std::max(static_cast<double>(in_view), static_cast<double>(out.followed.size()));
  return out;
}

void KltTracker::Follow(const std::vector<cv::Mat>& pyramid,
                        const std::vector<TagDetection>& tags) {
  const auto motion = PredictMotion(tags_, tags);
  std::vector<cv::Point2f> ahead;
  for (const TrackObservation& track : tracks_) {
    ahead.push_back(ToPoint(motion ? Transfer(*motion, track.pixel) : track.pixel));
  }
  if (motion) {
    tracks_ = FollowFrom(pyramid, std::move(ahead), NearLevel(options_)).followed;
    return;
  }
  // Beyond some 40 px the search ends on other edges, most of which are not those, and the few
  // points that pass every check by themselves are wrong together.
  constexpr double kMostOfThem = 0.8, kLeast = 0.6;
  Step step = FollowFrom(pyramid, ahead, options_.pyramid_levels);
  if (step.share < kMostOfThem) {
    const cv::Point2f shift = ToPoint(EstimateShift(pyramid_[0], pyramid[0]));
    for (cv::Point2f& point : ahead) point += shift;
    Step shifted = FollowFrom(pyramid, std::move(ahead), options_.pyramid_levels);
    if (shifted.share > step.share) step = std::move(shifted);
  }
  tracks_.clear();
  if (step.share >= kLeast) tracks_ = std::move(step.followed);
}

void KltTracker::Replenish(const cv::Mat& image) {
  CornerPickOptions pick_options;
  pick_options.n_wanted = options_.max_points - static_cast<int>(tracks_.size());
  // FAST is the dearest part of a frame that needs few new points; a tenth may be missing.
  if (pick_options.n_wanted <= options_.max_points / 10) return;
  pick_options.min_distance_px = options_.min_distance_px;
  pick_options.border_px = options_.border_px;
  std::vector<Eigen::Vector2d> taken;
  for (const TrackObservation& track : tracks_) taken.push_back(track.pixel);
  // Corners of the noise stay where they are in the image, and many of them find others there:
  // where the floor has few of its own they would say that nothing moves.
  constexpr double kOfNoise = 6;
  // As long as fainter corners may be had, strong ones in one place do not take their part.
  const int n_cells =
      std::max(static_cast<int>(image.total()) / (kCornerCellPx * kCornerCellPx), 1);
  const int twice_the_share = 2 * options_.max_points / n_cells + 1;
  const int faintest = std::clamp(static_cast<int>(std::ceil(kOfNoise * EstimateNoise(image))),
                                  options_.min_fast_threshold, options_.fast_threshold);
  for (;;) {
    fast_threshold_ = std::max(fast_threshold_, faintest);
    pick_options.threshold = fast_threshold_;
    const bool is_faintest = fast_threshold_ <= faintest;
    pick_options.most_in_cell = is_faintest ? options_.max_points : twice_the_share;
    const CornerPick pick = PickCorners(image, taken, pick_options);
    const bool few = static_cast<int>(pick.corners.size()) < pick_options.n_wanted;
    if (few && !is_faintest) {
      fast_threshold_ /= 2;
      continue;
    }
    if (pick.n_found > 10 * options_.max_points) {
      fast_threshold_ = std::min(fast_threshold_ + 2, options_.fast_threshold);
    }
    for (const Eigen::Vector2d& corner : pick.corners) {
      tracks_.push_back({next_id_++, corner, false});
    }
    return;
  }
}

void KltTracker::MarkOnTag(const std::vector<TagDetection>& tags,
                           const std::vector<TagDetection>& moving_tags) {
  std::vector<std::array<Eigen::Vector2d, 4>> outlines;
  outlines.reserve(tags.size() + moving_tags.size());
  for (const auto* some : {&tags, &moving_tags}) {
    for (const TagDetection& tag : *some)
      outlines.push_back(GrownOutline(tag, options_.tag_margin));
  }
  for (TrackObservation& track : tracks_) {
    track.on_tag = std::any_of(outlines.begin(), outlines.end(),
                               [&](const auto& outline) { return IsInside(track.pixel, outline); });
  }
}

}  // namespace tagtwist::internal

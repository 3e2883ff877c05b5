#include "estimator/jobs/overlay/overlay.h"

#include <opencv2/imgproc.hpp>

namespace tagtwist::internal {
namespace {

constexpr int kLeastWidth = 720, kStrip = 28;  // [px]
constexpr int kFractionBits = 4;               // of coordinates that OpenCV draws at

const cv::Scalar kSeen(80, 220, 80), kPredicted(0, 150, 255), kTrack(255, 170, 60);  // BGR
const cv::Scalar kText(235, 235, 235);

int Even(int n) { return n + n % 2; }

void DrawQuad(const std::array<cv::Point, 4>& corners, const cv::Scalar& colour, int thickness,
              cv::Mat* canvas) {
  for (size_t c = 0; c < 4; ++c) {
    cv::line(*canvas, corners[c], corners[(c + 1) % 4], colour, thickness, cv::LINE_AA,
             kFractionBits);
  }
}

void Write(const std::string& text, cv::Point at, double size, const cv::Scalar& colour,
           cv::Mat* canvas) {
  cv::putText(*canvas, text, at, cv::FONT_HERSHEY_SIMPLEX, size, {0, 0, 0}, 3, cv::LINE_AA);
  cv::putText(*canvas, text, at, cv::FONT_HERSHEY_SIMPLEX, size, colour, 1, cv::LINE_AA);
}

// The largest letters, at most 0.5, with which the text is no wider than that.
double LetterSize(const std::string& text, int width) {
  constexpr double kLargest = 0.5;
  int baseline = 0;
  const int full = cv::getTextSize(text, cv::FONT_HERSHEY_SIMPLEX, kLargest, 1, &baseline).width;
  return full <= width ? kLargest : kLargest * width / full;
}

}  // namespace

OverlayDrawing::OverlayDrawing(const Camera& camera, const TagMap& map)
    : camera_(camera), map_(map), scale_(1 + (kLeastWidth - 1) / camera.width) {}

cv::Point OverlayDrawing::ToCanvas(const Eigen::Vector2d& pixel) const {
  constexpr int kOne = 1 << kFractionBits;
  const Eigen::Vector2d at = scale_ * (pixel.array() + 0.5) - 0.5;
  return {cvRound(at.x() * kOne), cvRound(at.y() * kOne)};
}

void OverlayDrawing::DrawMap(const Pose& cam_from_world, cv::Mat* canvas) const {
  const double margin_px = -0.5 * camera_.width;  // what is farther out is not seen
  for (const Tag& tag : map_.tags()) {
    std::array<cv::Point, 4> corners;
    bool is_seen = true;
    for (size_t c = 0; c < 4 && is_seen; ++c) {
      Eigen::Vector2d pixel;
      is_seen = camera_.Project(cam_from_world * map_.CornersInWorld(tag.id)[c], &pixel) &&
                camera_.Contains(pixel, margin_px);
      if (is_seen) corners[c] = ToCanvas(pixel);
    }
    if (is_seen) DrawQuad(corners, kPredicted, 1, canvas);
  }
}

void OverlayDrawing::DrawTags(const std::vector<TagDetection>& tags, cv::Mat* canvas) const {
  for (const TagDetection& tag : tags) {
    std::array<cv::Point, 4> corners;
    for (size_t c = 0; c < 4; ++c) corners[c] = ToCanvas(tag.corners[c]);
    DrawQuad(corners, kSeen, 2, canvas);
    cv::circle(*canvas, corners[0], 3 << kFractionBits, kSeen, cv::FILLED, cv::LINE_AA,
               kFractionBits);
    const cv::Point middle = (corners[0] + corners[1] + corners[2] + corners[3]) / 4;
    Write(std::to_string(tag.id),
          {(middle.x >> kFractionBits) - 10, (middle.y >> kFractionBits) + 6}, 0.5, kSeen, canvas);
  }
}

void OverlayDrawing::DrawTracks(const std::vector<TrackObservation>& tracks, cv::Mat* canvas) {
  std::map<int64_t, Eigen::Vector2d> now;
  for (const TrackObservation& track : tracks) {
    now[track.track_id] = track.pixel;
    const auto before = before_.find(track.track_id);
    const Eigen::Vector2d from =
        before != before_.end() ? before->second : track.pixel_before.value_or(track.pixel);
    cv::line(*canvas, ToCanvas(from), ToCanvas(track.pixel), kTrack, 2, cv::LINE_AA, kFractionBits);
    cv::circle(*canvas, ToCanvas(track.pixel), 2 << kFractionBits, kTrack, cv::FILLED, cv::LINE_AA,
               kFractionBits);
  }
  before_ = std::move(now);
}

cv::Mat OverlayDrawing::Draw(const OverlayFrame& frame) {
  const cv::Size drawn(scale_ * camera_.width, scale_ * camera_.height);
  cv::Mat canvas(Even(drawn.height + kStrip), Even(drawn.width), CV_8UC3, cv::Scalar(0, 0, 0));
  if (!frame.image.empty()) {
    cv::Mat large, colour;
    cv::resize(frame.image, large, drawn, 0, 0, cv::INTER_NEAREST);
    cv::cvtColor(large, colour, cv::COLOR_GRAY2BGR);
    colour.copyTo(canvas({0, 0, drawn.width, drawn.height}));
  }
  cv::Mat view = canvas({0, 0, drawn.width, drawn.height});
  DrawTracks(frame.tracks, &view);
  DrawTags(frame.tags, &view);
  if (frame.cam_from_world) DrawMap(*frame.cam_from_world, &view);  // thin, over the tags
  Write(frame.text, {8, drawn.height + 19}, LetterSize(frame.text, drawn.width - 16), kText,
        &canvas);
  return canvas;
}

}  // namespace tagtwist::internal

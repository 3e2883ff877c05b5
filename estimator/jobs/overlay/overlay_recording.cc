#include "estimator/jobs/overlay/overlay_recording.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <memory>
#include <utility>
#include <vector>

#include "estimator/jobs/measurement_stream.h"
#include "estimator/jobs/overlay/overlay.h"
#include "estimator/jobs/progress.h"
#include "frontend/base/format_text.h"
#include "frontend/base/statistics/quantile.h"
#include "frontend/io/images/video_file.h"

namespace tagtwist::internal {
namespace {

// Hands a source's frames on and keeps their images until they are asked for.
class KeptImages : public DataSource {
 public:
  explicit KeptImages(DataSource* source) : source_(source) {}

  Result<std::optional<Frame>> Next() override {
    auto frame = source_->Next();
    if (frame && *frame) images_.push_back((*frame)->image);
    return frame;
  }
  const std::vector<int64_t>& stamps_ns() const override { return source_->stamps_ns(); }
  const std::vector<TruthSample>& ground_truth() const override { return source_->ground_truth(); }
  const std::vector<ImuSample>& imu() const override { return source_->imu(); }

  cv::Mat TakeOldest() {
    cv::Mat out = images_.front();
    images_.pop_front();
    return out;
  }

 private:
  DataSource* source_;
  std::deque<cv::Mat> images_;  // of the frames under way
};

double FramesPerSecond(const std::vector<FrameEstimate>& frames) {
  std::vector<double> steps;
  for (size_t i = 1; i < frames.size(); ++i) {
    steps.push_back(ToSeconds(frames[i].t_ns - frames[i - 1].t_ns));
  }
  // MPEG-4 counts time in at most 65535 parts of a second.
  return steps.empty() ? 25 : std::clamp(std::round(1e3 / Quantile(steps, 0.5)) * 1e-3, 1.0, 60.0);
}

std::string StateText(const FrameEstimate& f, double t_s) {
  std::string out =
      Format("%7.3f s  %s  %d tags  %d tracks", t_s, ToString(f.status), f.n_tags, f.n_tracks);
  if (f.status == FrameStatus::kNoFix) return out;
  const Eigen::Vector3d p = f.state.world_from_body.translation();
  return out + Format("  x %.3f y %.3f z %.3f m (+-%.2g mm)  v %.2f m/s  w %.2f rad/s", p.x(),
                      p.y(), p.z(), 1e3 * std::sqrt(f.covariance.diagonal().segment<3>(3).sum()),
                      f.state.twist.v_world.norm(), f.state.twist.omega_body.norm());
}

OverlayFrame FrameOf(const FrameEstimate& estimate, const Config& config, double t_s,
                     FrameMeasurements measurements, cv::Mat image) {
  OverlayFrame out;
  out.image = std::move(image);
  out.tags = std::move(measurements.tags);
  out.tracks = std::move(measurements.tracks);
  out.text = StateText(estimate, t_s);
  if (estimate.status != FrameStatus::kNoFix) {
    out.cam_from_world =
        config.set_up.rig.front().cam_from_body * Inverse(estimate.state.world_from_body);
  }
  return out;
}

}  // namespace

Status CheckOverlay(const std::string& dataset, const OverlayOptions& options, DataSource* source) {
  if (const auto fine = CheckVideoName(options.file); !fine) return fine;
  const auto first = source->Next();
  if (!first) return first.error();
  if (*first && (*first)->image.empty() && (*first)->image_problem.empty()) {
    return Error{dataset + ": has no images to draw " + options.file + " on"};
  }
  return Ok();
}

Status WriteOverlay(const OverlayOptions& options, const Config& config, const Estimate& estimate,
                    DataSource* source) {
  KeptImages images(source);
  auto stream =
      MeasurementStream::Create(&images, config, {options.use_detections, options.threads});
  if (!stream) return stream.error();
  OverlayDrawing drawing(config.set_up.rig.front().camera, config.set_up.map);
  std::unique_ptr<VideoFile> video;
  Progress progress("drawing", estimate.frames.size());
  for (size_t i = 0; i < estimate.frames.size(); ++i) {
    auto measured = stream->Next();
    if (!measured) return measured.error();
    if (!*measured) break;
    const FrameEstimate& frame = estimate.frames[i];
    const double t_s = ToSeconds(frame.t_ns - estimate.frames.front().t_ns);
    const cv::Mat drawn = drawing.Draw(
        FrameOf(frame, config, t_s, std::move((*measured)->measurements), images.TakeOldest()));
    if (!video) {
      auto created =
          VideoFile::Create(options.file, FramesPerSecond(estimate.frames), drawn.size());
      if (!created) return created.error();
      video = std::move(*created);
    }
    video->Add(drawn);
    progress.Update(i + 1);
  }
  return video ? video->Finish() : Ok();
}

}  // namespace tagtwist::internal

#include "estimator/calibration/set_up/set_up_hypotheses.h"

#include <cmath>

#include "frontend/base/format_text.h"

namespace tagtwist::internal {
namespace {

// At least so much, and not so much that no one would make that mistake.
bool IsBetween(double log_ratio, double least) {
  constexpr double kMostRatio = 5;
  return log_ratio > least && log_ratio < std::log(kMostRatio);
}

std::optional<Fault> FocalWords(const SetUpFit& fit, const Camera& camera, double least, double) {
  const double ratio = std::exp(fit.change.log_focal);
  if (!IsBetween(std::abs(fit.change.log_focal), least * 0.04)) return std::nullopt;
  return Fault{Format("The corners fit a focal length of %.0f px, %.2f times the calibration's "
                      "%.0f px.",
                      ratio * camera.fx, ratio, camera.fx),
               "Look for the calibration of this camera at this zoom and resolution."};
}

std::optional<Fault> ResolutionWords(const SetUpFit& fit, const Camera& camera, double least,
                                     double) {
  const double ratio = std::exp(fit.change.log_resolution);
  if (!IsBetween(std::abs(fit.change.log_resolution), least * 0.04)) return std::nullopt;
  return Fault{Format("The corners fit the calibration scaled by %.2f: it is for images of "
                      "another resolution (fx %.0f px instead of %.0f).",
                      ratio, ratio * camera.fx, camera.fx),
               "Multiply fx, fy, cx and cy by that, or calibrate at this resolution."};
}

std::optional<Fault> CentreWords(const SetUpFit& fit, const Camera& camera, double least, double) {
  const Eigen::Vector2d shift = fit.change.centre_px;
  if (!(shift.norm() > least * 0.02 * camera.width)) return std::nullopt;
  return Fault{Format("The corners fit a principal point that lies (%.0f, %.0f) px from the "
                      "calibration's (%.0f, %.0f): the image is cropped or shifted.",
                      shift.x(), shift.y(), camera.cx, camera.cy),
               "Subtract the crop's first column and row from cx and cy."};
}

std::optional<Fault> RadialWords(const SetUpFit& fit, const Camera& camera, double least, double) {
  const Eigen::Vector2d corner((camera.width - camera.cx) / camera.fx,
                               (camera.height - camera.cy) / camera.fy);
  const double r2 = corner.squaredNorm(), r = std::sqrt(r2);
  const double shift_px =
      camera.fx * r * std::abs(r2 * (fit.change.radial.x() + r2 * fit.change.radial.y()));
  const bool polynomial =
      camera.lens == LensModel::kRadialTangential || camera.lens == LensModel::kEquidistant;
  if (!polynomial || least > 1 || !(shift_px > 3)) return std::nullopt;
  const bool none = !camera.IsDistorted();
  return Fault{
      Format("The corners fit a lens that bends the image's corners by %.0f px %s.", shift_px,
             none ? "where the calibration has no distortion" : "more than the calibration's"),
      none ? "Give the distortion, or rectify the images."
           : "A lens that is told twice (images that are rectified already) would look like that."};
}

std::optional<Fault> SizeWords(const SetUpFit& fit, const Camera&, double least, double) {
  const double ratio = std::exp(fit.change.log_size);
  if (!IsBetween(std::abs(fit.change.log_size), least * 0.03)) return std::nullopt;
  return Fault{Format("The tags are %.3f times as large, against their distances, as the map "
                      "says.",
                      ratio),
               "Measure the black square without its white border, and the gaps between "
               "tags (Kalibr's tagSpacing is a share of the size)."};
}

std::optional<Fault> GapWords(const SetUpFit& fit, const Camera&, double least, double) {
  const Eigen::Vector2d stretch = fit.change.log_stretch;
  const double uneven = std::abs(stretch.x() - stretch.y());
  if (!IsBetween(stretch.cwiseAbs().maxCoeff(), least * 0.02) || !(uneven > least * 0.02)) {
    return std::nullopt;
  }
  return Fault{
      Format("The gaps between the tags are not the map's: along its x they lie %.3f times "
             "as far from one another as it says, along its y %.3f times.",
             std::exp(stretch.x()), std::exp(stretch.y())),
      "Gaps are from edge to edge of the black squares, those between rows along x, those "
      "between columns along y."};
}

std::optional<Fault> SqueezeWords(const SetUpFit& fit, const Camera& camera, double least, double) {
  const double of_y = std::exp(fit.change.log_resolution);
  const double of_x = of_y * std::exp(fit.change.log_squeeze);
  if (!IsBetween(std::abs(fit.change.log_squeeze), least * 0.04)) return std::nullopt;
  return Fault{Format("The corners fit the calibration with its x scaled by %.2f and its y by "
                      "%.2f (fx %.0f px, fy %.0f): the images are stretched against it.",
                      of_x, of_y, of_x * camera.fx, of_y * camera.fy),
               "Multiply fx and cx by the first, fy and cy by the second, or take images of the "
               "calibration's shape (4:3 is not 16:9)."};
}

std::optional<Fault> ShutterWords(const SetUpFit& fit, const Camera& camera, double least,
                                  double given_line_time_s) {
  const double readout_ms = 1e3 * fit.change.line_time_s * camera.height;
  const double given_ms = 1e3 * given_line_time_s * camera.height;
  if (!(std::abs(readout_ms - given_ms) > least * 3)) return std::nullopt;
  return Fault{Format("The corners fit a rolling shutter that reads an image in %.0f ms "
                      "(line_time_s: %.2e), where %.0f ms are told.",
                      readout_ms, fit.change.line_time_s, given_ms),
               "Tell the line time in the configuration's camera, or use a global shutter."};
}

}  // namespace

const std::vector<SetUpHypothesis>& SetUpHypotheses() {
  static const std::vector<SetUpHypothesis> all = {
      {{true, false, false, false, false, false, false, false}, FocalWords},
      {{false, true, false, false, false, false, false, false}, ResolutionWords},
      {{false, false, true, true, false, false, false, false}, CentreWords},
      {{false, false, false, false, true, true, false, false}, RadialWords},
      {{false, false, false, false, false, false, true, false}, SizeWords},
      {{false, false, false, false, false, false, false, true}, ShutterWords},
      {{false, false, false, false, false, false, false, false, true, true}, GapWords},
      {{false, true, false, false, false, false, false, false, false, false, true}, SqueezeWords}};
  return all;
}

}  // namespace tagtwist::internal

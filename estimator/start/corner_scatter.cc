#include "estimator/start/corner_scatter.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace tagtwist::internal {
namespace {

using Matrix8d = Eigen::Matrix<double, 8, 8>;

constexpr double kLeastPx = 0.02;
constexpr double kSwitches = 0.01;                // in a frame, to any other level
constexpr double kStray = 0.03, kStrayTimes = 8;  // tags that lie so many times farther off
constexpr size_t kTagsToKnow = 50;                // before that nothing is unusual
constexpr size_t kTagsToCount = 20;
constexpr double kClearly = 5;  // in the logarithm of a likelihood

double VarianceOf(size_t level) {
  return kLeastPx * kLeastPx * std::exp2(0.5 * static_cast<double>(level));
}

// What the likelihood of a misfit, two degrees of freedom, needs of a level.
struct Level {
  double half_information, log_variance;

  explicit Level(size_t level)
      : half_information(0.5 / VarianceOf(level)), log_variance(std::log(VarianceOf(level))) {}
  // Log, to a constant: of a tag like the others, or of a stray one, whichever is likelier.
  double LogLikelihood(double squares_px2) const {
    static const double usual = std::log(1 - kStray);
    static const double stray = std::log(kStray / (kStrayTimes * kStrayTimes));
    const double distance = half_information * squares_px2;
    return std::max(usual - distance, stray - distance / (kStrayTimes * kStrayTimes)) -
           log_variance;
  }
};

}  // namespace

CornerScatter::CornerScatter() {
  weights_.fill(1.0 / kLevels);
  even_.fill(1.0 / kLevels);
}

// What a frame tells for levels that switch, against one for all, each as the frames before say.
void CornerScatter::Compare(const Levels& logs) {
  const double most = *std::max_element(logs.begin(), logs.end());
  double switching = 0, even = 0;
  for (size_t i = 0; i < kLevels; ++i) {
    const double likelihood = std::exp(logs[i] - most);
    switching += ((1 - kSwitches) * weights_[i] + kSwitches / kLevels) * likelihood;
    even_[i] = std::max(even_[i] * likelihood, std::numeric_limits<double>::min());
    even += even_[i];
  }
  for (double& weight : even_) weight /= even;
  // Of ten frames or so: of many tags even the levels' grid shows, slowly.
  constexpr double kFade = 0.9;
  advantage_ = kFade * advantage_ + std::log(switching / even);
}

double CornerScatter::Add(const std::vector<double>& misfits_px) {
  Levels logs = {};
  for (size_t i = 0; i < kLevels; ++i) {
    const Level level(i);
    for (const double misfit_px : misfits_px) {
      if (misfit_px > 0) logs[i] += level.LogLikelihood(misfit_px * misfit_px);
    }
  }
  tags_ += static_cast<size_t>(std::count_if(misfits_px.begin(), misfits_px.end(),
                                             [](double misfit_px) { return misfit_px > 0; }));
  Compare(logs);
  const double most = *std::max_element(logs.begin(), logs.end());
  double sum = 0;
  for (size_t i = 0; i < kLevels; ++i) {
    weights_[i] = ((1 - kSwitches) * weights_[i] + kSwitches / kLevels) * std::exp(logs[i] - most);
    sum += weights_[i];
  }
  double variance_px2 = 0;
  for (size_t i = 0; i < kLevels; ++i) {
    weights_[i] /= sum;
    variance_px2 += weights_[i] * VarianceOf(i);
    if (tags_ > kTagsToCount && !misfits_px.empty()) frames_at_[i] += weights_[i];
  }
  is_uneven_ = is_uneven_ || (advantage_ > kClearly && IsUnusual(variance_px2));
  return variance_px2;
}

bool CornerScatter::IsUnusual(double variance_px2) const {
  constexpr double kUnusual = 2.8;  // that chance leads to in a frame of some hundred
  return tags_ >= kTagsToKnow && variance_px2 > kUnusual * UsualPx2();
}

void CornerScatter::ForgetCounts() {
  tags_ = 0;
  frames_at_ = {};
}

// That of a quarter of the frames.
double CornerScatter::UsualPx2() const {
  constexpr double kUsual = 0.25;
  double left = kUsual * std::accumulate(frames_at_.begin(), frames_at_.end(), 0.0);
  size_t level = 0;
  while (level + 1 < kLevels && left > frames_at_[level]) left -= frames_at_[level++];
  return VarianceOf(level);
}

void CornerScatter::Widen(double variance_px2, const std::vector<double>& misfits_px,
                          std::vector<TagDetection>* tags) const {
  constexpr double kFarSquares = 18;  // of the variance: e^-9 of all tags
  if (tags_ < kTagsToKnow || misfits_px.size() != tags->size()) return;
  const double usual_px2 = UsualPx2();
  // Half of what is usual stays, too: learned from unusual frames alone the rest may come out as
  // next to nothing, and the usual ones would contradict it.
  const double kept_px2 = is_uneven_ ? 0.5 * usual_px2 : 0;
  const double of_frame_px2 =
      is_uneven_ && IsUnusual(variance_px2) ? variance_px2 - kept_px2 : kept_px2;
  for (size_t i = 0; i < tags->size(); ++i) {
    const double squares_px2 = misfits_px[i] * misfits_px[i];
    const double far_px2 = kFarSquares * std::max(variance_px2, usual_px2);
    const double beyond_px2 = squares_px2 > far_px2
                                  ? std::max(of_frame_px2, 0.5 * squares_px2 - usual_px2)
                                  : of_frame_px2;
    TagDetection& tag = (*tags)[i];
    tag.covariance.reset();
    if (beyond_px2 > 0) tag.covariance = Matrix8d(beyond_px2 * Matrix8d::Identity());
  }
}

bool IsJudgedByShape(const EstimatorSetup& setup, const std::vector<TagDetection>& tags) {
  const bool is_known = std::any_of(
      tags.begin(), tags.end(), [](const TagDetection& tag) { return tag.covariance.has_value(); });
  return !is_known && !setup.options.corner_sigma_px && !setup.HasRollingShutter();
}

void WidenScattered(const std::vector<std::vector<double>>& misfits_px,
                    std::vector<FrameMeasurements>* frames) {
  CornerScatter scatter;
  // Backwards first, so that the first frame is known from those after it.
  for (size_t i = misfits_px.size(); i > 0; --i) scatter.Add(misfits_px[i - 1]);
  scatter.ForgetCounts();
  std::vector<double> variances_px2;
  for (const auto& of_frame : misfits_px) variances_px2.push_back(scatter.Add(of_frame));
  for (size_t i = 0; i < frames->size(); ++i) {
    scatter.Widen(variances_px2[i], misfits_px[i], &(*frames)[i].tags);
  }
}

}  // namespace tagtwist::internal

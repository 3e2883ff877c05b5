#include "frontend/tags/guided_detector.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_set>
#include <utility>

#include "frontend/types/so3.h"

namespace tagtwist::internal {
namespace {

constexpr double kSigmas = 3;         // a corner is looked for within so many
constexpr double kFollowPx = 0.5;     // off by less, a fit starts at the prediction itself
constexpr double kMostSearchPx = 10;  // a prediction that is worse is none
constexpr double kLeastCorrelation = 0.6;
constexpr double kMostSurprise = 60;  // squared Mahalanobis distance, 8 degrees of freedom

using Vector8d = Eigen::Matrix<double, 8, 1>;
using Matrix8d = Eigen::Matrix<double, 8, 8>;

constexpr double kKnownGain = 1.5;  // known looks are worth a way across the image

Eigen::Vector2d Centre(const ExpectedTag& tag) {
  const auto& c = tag.tag.corners;
  return 0.25 * (c[0] + c[1] + c[2] + c[3]);
}

// Which of the tags to look for: the first one, then again and again the one that is farthest from
// all those chosen. `gains` scale the distances.
std::vector<bool> ChooseSpread(const std::vector<ExpectedTag>& tags,
                               const std::vector<double>& gains, size_t most_tags) {
  std::vector<bool> chosen(tags.size(), tags.size() <= most_tags);
  if (tags.size() <= most_tags) return chosen;
  std::vector<double> distance(tags.size(), std::numeric_limits<double>::infinity());
  size_t next = 0;
  for (size_t n = 0; n < most_tags; ++n) {
    chosen[next] = true;
    const Eigen::Vector2d centre = Centre(tags[next]);
    double most = -1;
    for (size_t i = 0; i < tags.size(); ++i) {
      distance[i] = std::min(distance[i], gains[i] * (Centre(tags[i]) - centre).norm());
      if (!chosen[i] && distance[i] > most) {
        most = distance[i];
        next = i;
      }
    }
  }
  return chosen;
}

// Infinite where the covariance is not finite.
double LargestSigma(const Matrix8d& covariance) {
  if (!covariance.allFinite()) return std::numeric_limits<double>::infinity();
  double most = 0;
  for (int c = 0; c < 8; c += 2) {
    const Eigen::Matrix2d p = covariance.block<2, 2>(c, c);
    const double mean = 0.5 * p.trace(), spread = 0.5 * (p(0, 0) - p(1, 1));
    most = std::max(most, mean + std::hypot(spread, p(0, 1)));
  }
  return std::sqrt(most);
}

// The prediction after a tag was seen. Where the tag does not agree with it the prediction stays as
// it was: the tag is found all the same, and whether it is right is for the estimator to say.
PosePrediction Updated(const PosePrediction& prediction, const ExpectedTag& expected,
                       const RefinedTag& seen) {
  Vector8d difference;
  for (int c = 0; c < 4; ++c) {
    const auto i = static_cast<size_t>(c);
    difference.segment<2>(2 * c) = seen.corners[i] - expected.tag.corners[i];
  }
  const double sigma = prediction.corner_sigma_px;
  const Matrix8d noise = seen.covariance + sigma * sigma * Matrix8d::Identity();
  const Eigen::LLT<Matrix8d> innovation(*expected.tag.covariance + noise);
  if (!(difference.dot(innovation.solve(difference)) < kMostSurprise)) return prediction;
  const Eigen::Matrix<double, 8, 6> gain_transposed =
      innovation.solve(expected.d_corners * prediction.covariance);
  const PoseStep step = gain_transposed.transpose() * difference;
  const PoseCovariance reduced = prediction.covariance - gain_transposed.transpose() *
                                                             expected.d_corners *
                                                             prediction.covariance;
  PosePrediction out = prediction;
  out.world_from_body = Retract(prediction.world_from_body, step);
  out.covariance = 0.5 * (reduced + reduced.transpose());
  return out;
}

}  // namespace

GuidedDetector::GuidedDetector(const Camera& camera, const Pose& cam_from_body, const TagMap& map,
                               double border_px, const GuidedOptions& options)
    : camera_(camera),
      cam_from_body_(cam_from_body),
      map_(map),
      border_px_(border_px),
      options_(options) {}

// Derivatives as in M5 of docs/maths.md.
std::optional<ExpectedTag> GuidedDetector::Expect(const Tag& tag,
                                                  const PosePrediction& prediction) const {
  ExpectedTag out;
  out.tag.id = tag.id;
  const Eigen::Matrix3d body_from_world =
      prediction.world_from_body.rotation().toRotationMatrix().transpose();
  const Eigen::Matrix3d cam_from_body = cam_from_body_.rotation().toRotationMatrix();
  const auto& corners_in_world = map_.CornersInWorld(tag.id);
  for (size_t c = 0; c < 4; ++c) {
    const Eigen::Vector3d in_body =
        body_from_world * (corners_in_world[c] - prediction.world_from_body.translation());
    const Eigen::Vector3d in_cam = cam_from_body * in_body + cam_from_body_.translation();
    Eigen::Matrix<double, 2, 3> d_pixel;
    if (!camera_.Project(in_cam, &out.tag.corners[c], &d_pixel) ||
        !camera_.Contains(out.tag.corners[c], border_px_)) {
      return std::nullopt;
    }
    Eigen::Matrix<double, 3, 6> d_body;
    d_body << Hat(in_body), -body_from_world;
    out.d_corners.middleRows<2>(2 * static_cast<int>(c)) = d_pixel * cam_from_body * d_body;
  }
  out.tag.covariance = out.d_corners * prediction.covariance * out.d_corners.transpose();
  out.sigma_px = LargestSigma(*out.tag.covariance);
  return out;
}

// The tags to look for: the ones seen in the last image first, then those known best.
std::vector<ExpectedTag> GuidedDetector::ExpectAll(const PosePrediction& prediction) const {
  std::vector<ExpectedTag> out;
  for (const Tag& tag : map_.tags()) {
    if (auto expected = Expect(tag, prediction)) out.push_back(std::move(*expected));
  }
  std::stable_sort(out.begin(), out.end(), [&](const ExpectedTag& a, const ExpectedTag& b) {
    const bool a_is_new = looks_.count(a.tag.id) == 0, b_is_new = looks_.count(b.tag.id) == 0;
    return a_is_new != b_is_new ? b_is_new : a.sigma_px < b.sigma_px;
  });
  std::vector<double> gains;
  for (const ExpectedTag& tag : out) gains.push_back(looks_.count(tag.tag.id) ? kKnownGain : 1.0);
  const std::vector<bool> chosen = ChooseSpread(out, gains, options_.most_tags);
  std::vector<ExpectedTag> kept;
  for (size_t i = 0; i < out.size(); ++i) {
    if (chosen[i]) kept.push_back(std::move(out[i]));
  }
  return kept;
}

std::optional<RefinedTag> GuidedDetector::Fit(const cv::Mat& gray, const CornerRefiner& refiner,
                                              const ExpectedTag& expected) const {
  const double off_px = kSigmas * expected.sigma_px;
  if (!(off_px < kMostSearchPx)) return std::nullopt;
  const auto look = looks_.find(expected.tag.id);
  if (look != looks_.end()) {
    if (auto followed = refiner.Follow(gray, expected.tag, look->second, off_px)) return followed;
  }
  if (off_px > kFollowPx) return refiner.Refine(gray, expected.tag, off_px);
  // Newly seen, or lit otherwise than a moment ago.
  if (!(refiner.Correlation(gray, expected.tag) > kLeastCorrelation)) return std::nullopt;
  return refiner.Refine(gray, expected.tag);
}

// Of a tag that a first look passed over: from a pose that was worse, or since it is not quite
// where the map has it.
std::optional<RefinedTag> GuidedDetector::FitAgain(const cv::Mat& gray,
                                                   const CornerRefiner& refiner,
                                                   const ExpectedTag& expected,
                                                   double corner_sigma_px, bool was_tried) const {
  const double off_px = kSigmas * std::hypot(expected.sigma_px, corner_sigma_px);
  if (!(off_px > kFollowPx)) return was_tried ? std::nullopt : Fit(gray, refiner, expected);
  return off_px < kMostSearchPx ? refiner.Refine(gray, expected.tag, off_px) : std::nullopt;
}

GuidedTags GuidedDetector::Find(const cv::Mat& gray, const CornerRefiner& refiner,
                                const PosePrediction& prediction, const TimeUp& time_up) {
  GuidedTags out;
  out.pose = prediction;
  std::unordered_set<int> tried;
  std::unordered_map<int, PatternLook> looks;
  const auto keep = [&](const ExpectedTag& expected, const std::optional<RefinedTag>& seen) {
    out.expected += tried.insert(expected.tag.id).second ? 1 : 0;
    if (!seen) return;
    out.pose = Updated(out.pose, expected, *seen);
    looks.emplace(expected.tag.id, seen->look);
    out.found.push_back({expected.tag.id, seen->corners, seen->covariance});
  };
  const auto pass = [&](const auto& fit) {
    for (const ExpectedTag& before : ExpectAll(out.pose)) {
      const auto expected = Expect(*map_.Find(before.tag.id), out.pose);
      if (!expected || looks.count(before.tag.id) > 0) continue;
      out.cut_short = out.cut_short || IsUp(time_up);
      if (out.cut_short) return;
      keep(*expected, fit(*expected));
    }
  };
  pass([&](const ExpectedTag& expected) { return Fit(gray, refiner, expected); });
  if (options_.is_thorough && !out.found.empty() && !out.cut_short) {
    pass([&](const ExpectedTag& expected) {
      return FitAgain(gray, refiner, expected, prediction.corner_sigma_px,
                      tried.count(expected.tag.id) > 0);
    });
  }
  std::sort(out.found.begin(), out.found.end(),
            [](const TagDetection& a, const TagDetection& b) { return a.id < b.id; });
  looks_ = std::move(looks);
  return out;
}

}  // namespace tagtwist::internal

#include "frontend/tags/tag_completion.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <iterator>
#include <unordered_set>
#include <utility>

namespace tagtwist::internal {
namespace {

using Matrix8d = Eigen::Matrix<double, 8, 8>;

// At least so much of a corner's error is the lens's and the map's.
constexpr double kLeastModelPx = 0.05;

// The tags found anew, and those detected that were not found anew; sorted by id.
std::vector<TagDetection> Merged(std::vector<TagDetection> fresh,
                                 const std::vector<TagDetection>& detected) {
  std::unordered_set<int> is_fresh;
  for (const TagDetection& tag : fresh) is_fresh.insert(tag.id);
  std::copy_if(detected.begin(), detected.end(), std::back_inserter(fresh),
               [&](const TagDetection& tag) { return is_fresh.count(tag.id) == 0; });
  std::sort(fresh.begin(), fresh.end(),
            [](const TagDetection& a, const TagDetection& b) { return a.id < b.id; });
  return fresh;
}

}  // namespace

std::optional<PosePrediction> PredictionBy(const Pose& pose, const FramePose& found,
                                           const std::vector<TagDetection>& tags, const TagMap& map,
                                           const GuidedDetector& guided) {
  PosePrediction out;
  out.world_from_body = pose;
  out.corner_sigma_px = std::max(kLeastModelPx, found.rms_px);
  PoseCovariance information = PoseCovariance::Zero();
  for (size_t i = 0; i < tags.size(); ++i) {
    if (!found.tag_inlier[i]) continue;
    const auto expected = guided.Expect(*map.Find(tags[i].id), out);
    if (!expected) continue;
    Matrix8d noise = tags[i].covariance.value_or(Matrix8d::Zero());
    noise.diagonal().array() += out.corner_sigma_px * out.corner_sigma_px;
    information += expected->d_corners.transpose() * noise.llt().solve(expected->d_corners);
  }
  const Eigen::LLT<PoseCovariance> factor(information);
  if (factor.info() != Eigen::Success) return std::nullopt;
  out.covariance = factor.solve(PoseCovariance::Identity());
  return out;
}

std::vector<TagDetection> CompleteTags(const cv::Mat& gray, const CornerRefiner& refiner,
                                       const TagMap& map, const Camera& camera, double border_px,
                                       const RefinedTags& refined) {
  const std::vector<TagDetection>& detected = refined.tags;
  const FramePose found = FindFramePose(detected, map, camera, Pose());
  if (found.status != FramePoseStatus::kOk) return detected;
  std::unordered_set<int> known;
  for (const TagDetection& tag : detected) {
    if (refined.IsRefined(tag.id)) known.insert(tag.id);
  }
  std::vector<Tag> missed;
  std::copy_if(map.tags().begin(), map.tags().end(), std::back_inserter(missed),
               [&](const Tag& tag) { return known.count(tag.id) == 0; });
  if (missed.empty()) return detected;
  const TagMap map_of_missed(map.family(), std::move(missed));
  const GuidedDetector anywhere(camera, Pose(), map, border_px);
  std::vector<Pose> poses = found.alternatives;
  poses.insert(poses.begin(), found.world_from_body);
  std::vector<TagDetection> fresh;
  for (const Pose& pose : poses) {
    const auto prediction = PredictionBy(pose, found, detected, map, anywhere);
    if (!prediction) continue;
    GuidedDetector guided(camera, Pose(), map_of_missed, border_px);
    std::vector<TagDetection> tags = guided.Find(gray, refiner, *prediction).found;
    if (tags.size() > fresh.size()) fresh = std::move(tags);
  }
  return Merged(std::move(fresh), detected);
}

}  // namespace tagtwist::internal

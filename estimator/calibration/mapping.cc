#include "estimator/calibration/mapping.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <set>
#include <utility>

#include "estimator/calibration/options.h"
#include "estimator/calibration/solver.h"
#include "frontend/geometry/frame_pose.h"

namespace tagtwist::internal {
namespace {

constexpr size_t kMostVotingFrames = 60;    // that vote for a tag's place
constexpr double kAgreeTags = 0.25;         // places agree within this many tag sides
constexpr double kAgreeRad = 0.2;           // and this angle
constexpr double kFreeM = 1, kFreeRad = 1;  // priors that hold nothing

using Placed = std::map<int, Tag>;  // by id

// Both minima of one tag's pose, cam_from_tag; empty where its corners give none.
std::vector<Pose> TagMinima(const TagDetection& tag, const Camera& camera,
                            const MappingOptions& options) {
  const TagMap alone(options.family, {Tag{tag.id, Pose(), options.tag_size_m}});
  const FramePose found = FindFramePose({tag}, alone, camera, Pose());
  std::vector<Pose> out;
  if (found.status != FramePoseStatus::kOk) return out;
  out.push_back(Inverse(found.world_from_body));
  for (const Pose& other : found.alternatives) out.push_back(Inverse(other));
  return out;
}

// What one frame proposes for a tag, world_from_tag: all combinations of minima.
using Proposal = std::vector<Pose>;

bool Agree(const Pose& a, const Pose& b, const MappingOptions& options) {
  return (a.translation() - b.translation()).norm() < kAgreeTags * options.tag_size_m &&
         AngleBetween(a, b) < kAgreeRad;
}

struct Vote {
  Pose world_from_tag;
  int frames = 0;  // that agree
};

// The proposal that most frames have one like.
Vote CountVotes(const std::vector<Proposal>& proposals, const MappingOptions& options) {
  Vote best;
  for (const Proposal& from : proposals) {
    for (const Pose& candidate : from) {
      const auto agrees = [&](const Proposal& other) {
        return std::any_of(other.begin(), other.end(),
                           [&](const Pose& pose) { return Agree(pose, candidate, options); });
      };
      const auto frames =
          static_cast<int>(std::count_if(proposals.begin(), proposals.end(), agrees));
      if (frames > best.frames) best = {candidate, frames};
    }
  }
  return best;
}

class Mapper {
 public:
  // The measurements, which may be large, must outlive it; what is small is its own.
  Mapper(const Camera& camera, const std::vector<FrameMeasurements>* measurements,
         const MappingOptions& options)
      : camera_(camera), measurements_(measurements), options_(options) {
    std::set<int> known;
    for (const Tag& tag : options.known) known.insert(tag.id);
    for (const FrameMeasurements& frame : *measurements) {
      minima_.emplace_back();
      for (const TagDetection& tag : frame.tags) {
        minima_.back().push_back(known.count(tag.id) > 0 ? std::vector<Pose>()
                                                         : TagMinima(tag, camera, options));
        ++seen_[tag.id];
      }
    }
  }

  const std::map<int, int>& seen() const { return seen_; }

  // Proposals for every tag that is not placed, from frames that see placed ones.
  std::map<int, std::vector<Proposal>> Propose(const Placed& placed) const {
    std::map<int, std::vector<Proposal>> out;
    for (size_t i = 0; i < measurements_->size(); ++i) {
      const std::vector<Pose> poses = WorldFromCam(i, placed);
      const std::vector<TagDetection>& tags = (*measurements_)[i].tags;
      for (size_t k = 0; k < tags.size() && !poses.empty(); ++k) {
        if (placed.count(tags[k].id) > 0 || minima_[i][k].empty()) continue;
        Proposal proposal;
        for (const Pose& world_from_cam : poses) {
          for (const Pose& cam_from_tag : minima_[i][k]) {
            proposal.push_back(world_from_cam * cam_from_tag);
          }
        }
        out[tags[k].id].push_back(std::move(proposal));
      }
    }
    return out;
  }

  // The calibration problem of the placed tags: frames that see them.
  CalibrationProblem Problem(const Placed& placed, const std::set<int>& held) const {
    CalibrationProblem out;
    out.prior.camera = camera_;
    std::map<int, int> index;
    for (const auto& [id, tag] : placed) {
      index.emplace(id, static_cast<int>(index.size()));
      out.prior.tags.push_back(tag);
    }
    const CalibrationLayout layout = LayoutOf(out.prior);
    out.prior_sigmas.setZero(layout.size());
    for (const auto& [id, k] : index) {
      if (held.count(id) > 0) continue;
      out.prior_sigmas.segment<3>(layout.tag(k)).setConstant(kFreeRad);
      out.prior_sigmas.segment<3>(layout.tag(k) + 3).setConstant(kFreeM);
    }
    for (size_t i = 0; i < measurements_->size(); ++i) AddFrame(i, placed, index, &out.frames);
    return out;
  }

 private:
  TagMap MapOf(const Placed& placed) const {
    std::vector<Tag> tags;
    for (const auto& [id, tag] : placed) tags.push_back(tag);
    return {options_.family, std::move(tags)};
  }

  FramePose PoseOfFrame(size_t frame, const Placed& placed,
                        std::vector<TagDetection>* known) const {
    for (const TagDetection& tag : (*measurements_)[frame].tags) {
      if (placed.count(tag.id) > 0) known->push_back(tag);
    }
    if (known->empty()) return {};
    return FindFramePose(*known, MapOf(placed), camera_, Pose());
  }

  // All minima of the camera's pose.
  std::vector<Pose> WorldFromCam(size_t frame, const Placed& placed) const {
    std::vector<TagDetection> known;
    const FramePose found = PoseOfFrame(frame, placed, &known);
    if (found.status != FramePoseStatus::kOk) return {};
    std::vector<Pose> out = {found.world_from_body};
    out.insert(out.end(), found.alternatives.begin(), found.alternatives.end());
    return out;
  }

  // Frames whose pose is left open, or that see a single tag, say nothing about the map.
  void AddFrame(size_t i, const Placed& placed, const std::map<int, int>& index,
                std::vector<CalibrationFrame>* frames) const {
    std::vector<TagDetection> known;
    const FramePose found = PoseOfFrame(i, placed, &known);
    if (found.status != FramePoseStatus::kOk || !found.alternatives.empty()) return;
    CalibrationFrame frame;
    frame.t_ns = (*measurements_)[i].t_ns;
    frame.world_from_cam = found.world_from_body;
    std::vector<CalibrationView> views;
    for (size_t k = 0; k < known.size(); ++k) {
      if (!found.tag_inlier[k]) continue;
      CalibrationView view;
      view.tag = index.at(known[k].id);
      view.pixels = known[k].corners;
      view.covariance = known[k].covariance;
      views.push_back(view);
    }
    if (views.size() < 2) return;
    frame.shared_views = std::make_shared<const std::vector<CalibrationView>>(std::move(views));
    frames->push_back(std::move(frame));
  }

  Camera camera_;
  const std::vector<FrameMeasurements>* measurements_;
  MappingOptions options_;
  std::vector<std::vector<std::vector<Pose>>> minima_;  // of each frame's tags
  std::map<int, int> seen_;                             // frames, by id
};

// At most kMostVotingFrames of them, evenly spread.
std::vector<Proposal> Thin(std::vector<Proposal> proposals) {
  if (proposals.size() <= kMostVotingFrames) return proposals;
  std::vector<Proposal> out;
  for (size_t k = 0; k < kMostVotingFrames; ++k) {
    out.push_back(std::move(proposals[k * proposals.size() / kMostVotingFrames]));
  }
  return out;
}

// Places the tags that have at least half as many votes as the best one; false when there is none.
bool PlaceMore(const Mapper& mapper, const MappingOptions& options, Placed* placed) {
  std::map<int, Vote> votes;
  int most = 0;
  for (auto& [id, proposals] : mapper.Propose(*placed)) {
    votes[id] = CountVotes(Thin(std::move(proposals)), options);
    most = std::max(most, votes[id].frames);
  }
  if (most < options.least_frames) return false;
  for (const auto& [id, vote] : votes) {
    if (2 * vote.frames >= most && vote.frames >= options.least_frames) {
      placed->emplace(id, Tag{id, vote.world_from_tag, options.tag_size_m});
    }
  }
  return true;
}

Placed ByIds(const std::vector<Tag>& tags) {
  Placed out;
  for (const Tag& tag : tags) out.emplace(tag.id, tag);
  return out;
}

// The tags that fix the world.
Result<Placed> FirstPlaced(const Mapper& mapper, const MappingOptions& options) {
  if (mapper.seen().empty()) return Error{"no frame shows a tag"};
  if (!options.known.empty()) return ByIds(options.known);
  const auto often =
      std::max_element(mapper.seen().begin(), mapper.seen().end(),
                       [](const auto& a, const auto& b) { return a.second < b.second; });
  const int root = options.root.value_or(often->first);
  if (mapper.seen().count(root) == 0) {
    return Error{"tag " + std::to_string(root) + ", which is to fix the world, is never seen"};
  }
  return ByIds({{root, Pose(), options.tag_size_m}});
}

// Known tags in their order, then the others by id.
Mapping ToMapping(const CalibrationSolution& solution, const Mapper& mapper,
                  const MappingOptions& options) {
  Mapping out;
  out.corner_sigma_px = solution.noise.corner_sigma_px;
  std::vector<Tag> tags = options.known;
  out.covariances.assign(tags.size(), Eigen::Matrix<double, 6, 6>::Zero());
  const Placed known = ByIds(options.known);
  std::set<int> placed;
  const CalibrationLayout layout = LayoutOf(solution.state);
  for (int i = 0; i < layout.n_tags; ++i) {
    const Tag& tag = solution.state.tags[static_cast<size_t>(i)];
    placed.insert(tag.id);
    if (known.count(tag.id) > 0) continue;
    tags.push_back(tag);
    out.covariances.emplace_back(solution.covariance.block<6, 6>(layout.tag(i), layout.tag(i)));
  }
  out.map = TagMap(options.family, std::move(tags));
  for (const auto& [id, frames] : mapper.seen()) {
    if (placed.count(id) == 0) out.left_out.push_back(id);
  }
  return out;
}

}  // namespace

Result<Mapping> MapTags(const Camera& camera, const std::vector<FrameMeasurements>& measurements,
                        const MappingOptions& options) {
  const Mapper mapper(camera, &measurements, options);
  auto first = FirstPlaced(mapper, options);
  if (!first) return first.error();
  Placed placed = std::move(*first);
  std::set<int> held;
  for (const auto& [id, tag] : placed) held.insert(id);
  CalibrationSolution solution;
  const auto adjust = [&]() {
    const CalibrationProblem problem = mapper.Problem(placed, held);
    solution = SolveAndLearnNoise(problem, problem.prior, solution.noise, true);
    return solution.usable;
  };
  const Error no_solution{"the map has no solution"};
  while (PlaceMore(mapper, options, &placed)) {
    if (!adjust()) return no_solution;
    placed = ByIds(solution.state.tags);
  }
  if (options.known.empty() && placed.size() < 2) {
    return Error{"no tag is seen together with tag " + std::to_string(*held.begin())};
  }
  // Once more: frames that were left open may now be told apart.
  if (!adjust()) return no_solution;
  return ToMapping(solution, mapper, options);
}

}  // namespace tagtwist::internal

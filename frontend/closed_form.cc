#include "frontend/closed_form.h"

#include <algorithm>
#include <iterator>

#include "frontend/geometry/homography.h"
#include "frontend/geometry/tag_outline.h"
#include "frontend/types/lens/lens.h"

namespace tagtwist::internal {
namespace {

// A point seen in the last frame and in this one.
struct PointPair {
  Eigen::Vector2d last_pixel, pixel;
};

std::vector<PointPair> MatchTracks(const std::vector<TrackObservation>& last,
                                   const std::vector<TrackObservation>& now) {
  std::vector<PointPair> pairs;
  auto it = last.begin();
  for (const TrackObservation& track : now) {
    while (it != last.end() && it->track_id < track.track_id) ++it;
    if (it != last.end() && it->track_id == track.track_id) {
      pairs.push_back({it->pixel, track.pixel});
    } else if (track.pixel_before) {
      pairs.push_back({*track.pixel_before, track.pixel});
    }
  }
  return pairs;
}

std::vector<PointPair> MatchCorners(const std::vector<TagDetection>& last,
                                    const std::vector<TagDetection>& now) {
  std::vector<PointPair> pairs;
  for (const TagDetection& tag : now) {
    for (const TagDetection& candidate : last) {
      if (candidate.id != tag.id) continue;
      for (size_t c = 0; c < 4; ++c) pairs.push_back({candidate.corners[c], tag.corners[c]});
    }
  }
  return pairs;
}

std::vector<TagDetection> TagsOnPlane(const std::vector<TagDetection>& tags,
                                      const TagPlanes& planes, size_t plane) {
  std::vector<TagDetection> on_plane;
  std::copy_if(tags.begin(), tags.end(), std::back_inserter(on_plane),
               [&](const TagDetection& tag) { return planes.plane_of_tag.at(tag.id) == plane; });
  return on_plane;
}

}  // namespace

ClosedFormEstimator::ClosedFormEstimator(const Camera& camera, const Pose& cam_from_body,
                                         const TagMap& map, const ClosedFormOptions& options,
                                         MountedOn mounted_on)
    : camera_(camera),
      cam_from_body_(cam_from_body),
      mounted_on_(mounted_on),
      map_(map),
      options_(options),
      planes_(FindTagPlanes(map.tags())) {}

ClosedForm ClosedFormEstimator::Update(int64_t t_ns, const std::vector<TagDetection>& tags,
                                       const std::vector<TrackObservation>& tracks) {
  ClosedForm closed_form;
  std::optional<Pose> world_from_cam;
  if (!tags.empty()) {
    const size_t plane = MainPlane(planes_, tags);
    world_from_cam =
        PoseFromTags(TagsOnPlane(tags, planes_, plane), map_, planes_.world_from_plane[plane],
                     camera_, {options_.normalise_points, options_.seed_scale});
  }
  if (world_from_cam) {
    closed_form.world_from_body = mounted_on_ == MountedOn::kBody
                                      ? *world_from_cam * cam_from_body_
                                      : Inverse(*world_from_cam * cam_from_body_);
  }

  const double measured_dt_s = last_t_ns_ ? ToSeconds(t_ns - *last_t_ns_) : 0;
  if (measured_dt_s > 0 && measured_dt_s <= options_.max_gap_s) {
    sum_dt_s_ += measured_dt_s;
    ++n_dt_;
    const double dt_s = options_.mean_dt ? sum_dt_s_ / n_dt_ : measured_dt_s;
    if (world_from_cam) {
      UpdateTwists(t_ns, Flow(*world_from_cam, dt_s, tags, tracks), dt_s, &closed_form);
    }
  }
  last_t_ns_ = t_ns;
  last_tags_ = tags;
  last_tracks_ = tracks;
  return closed_form;
}

std::vector<FlowPoint> ClosedFormEstimator::Flow(
    const Pose& world_from_cam, double dt_s, const std::vector<TagDetection>& tags,
    const std::vector<TrackObservation>& tracks) const {
  std::vector<PointPair> pairs = MatchTracks(last_tracks_, tracks);
  if (pairs.size() < 3) pairs = MatchCorners(last_tags_, tags);
  const Pose cam_from_world = Inverse(world_from_cam);
  std::vector<Pose> cam_from_plane;
  for (const Pose& world_from_plane : planes_.world_from_plane) {
    cam_from_plane.push_back(cam_from_world * world_from_plane);
  }
  const size_t main_plane = MainPlane(planes_, tags);
  const auto plane_under = [&](const Eigen::Vector2d& pixel) {
    if (cam_from_plane.size() == 1) return main_plane;
    const TagDetection* tag = TagUnder(pixel, tags, kWhiteMarginOfSide);
    return tag == nullptr ? main_plane : planes_.plane_of_tag.at(tag->id);
  };
  std::vector<FlowPoint> flow;
  for (const PointPair& pair : pairs) {
    const auto last = camera_.Unproject(pair.last_pixel), now = camera_.Unproject(pair.pixel);
    if (!last || !now) continue;
    const auto depth_m = DepthOnPlane(*now, cam_from_plane[plane_under(pair.pixel)]);
    if (depth_m) flow.push_back({*now, (*now - *last) / dt_s, *depth_m});  // seed Eq. 8
  }
  return flow;
}

void ClosedFormEstimator::UpdateTwists(int64_t t_ns, const std::vector<FlowPoint>& flow,
                                       double dt_s, ClosedForm* closed_form) {
  const auto in_body = [&](const CameraTwist& twist_of_cam_in_cam) {
    return mounted_on_ == MountedOn::kBody
               ? BodyTwist(twist_of_cam_in_cam, cam_from_body_, *closed_form->world_from_body)
               : TwistSeenFrom(twist_of_cam_in_cam, cam_from_body_, *closed_form->world_from_body);
  };
  if (const auto twist = SolveTwist(flow)) closed_form->twist_plain = in_body(*twist);

  TwistRansacOptions ransac;
  ransac.threshold = options_.ransac_threshold_px / (FocalLengthOnAxis(camera_) * dt_s);
  ransac.success = options_.ransac_success;
  ransac.inlier_ratio = options_.ransac_inlier_ratio;
  ransac.enough_inliers = options_.ransac_enough_inliers;
  ransac.random_seed = static_cast<uint64_t>(options_.ransac_seed) + static_cast<uint64_t>(t_ns);
  const TwistRansacResult robust = EstimateTwistRansac(flow, ransac);
  if (!robust.twist_of_cam_in_cam) return;
  closed_form->twist_ransac = in_body(*robust.twist_of_cam_in_cam);

  const bool continues = low_pass_ && ToSeconds(t_ns - low_pass_t_ns_) <= options_.max_gap_s;
  low_pass_ = continues ? LowPass(*low_pass_, *closed_form->twist_ransac, options_.low_pass_alpha)
                        : *closed_form->twist_ransac;
  low_pass_t_ns_ = t_ns;
  closed_form->twist_low_pass = low_pass_;
}

}  // namespace tagtwist::internal

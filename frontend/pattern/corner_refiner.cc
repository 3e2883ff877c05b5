#include "frontend/pattern/corner_refiner.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <unordered_map>
#include <utility>

#include "frontend/pattern/pattern_fit.h"
#include "frontend/pattern/pattern_search.h"
#include "frontend/types/tag_family.h"

namespace tagtwist::internal {
namespace {

constexpr double kMostMovePx = 1.0;
constexpr double kLeastInlierShare = 0.6, kMostContradictedShare = 0.06;
constexpr double kMostNoiseOfContrast = 0.15;
constexpr double kFloorPx = 0.0015;  // of a corner's standard deviation: what the model leaves out
constexpr double kLeastCellPx = 1.2;
// In sigmas of the blur's two axes together, 2 of one: what an edge tells lies within.
constexpr double kEdgeSigmas = 1.45;
constexpr double kRoughPx = 0.15, kMostSidePx = 400;
constexpr double kMostSearchPx = 10, kFollowPx = 0.5;  // off by no more after a search
constexpr double kFarPx = 1e5;
constexpr double kUnrefinedPx = 1.0;  // corners whose refinement fails are often far off

using Corners = std::array<Eigen::Vector2d, 4>;

// Where a tag's straight sides are straight: a picture without the lens's distortion that near the
// tag's centre is the image itself, in place, scale and shape. Without distortion, the image.
struct StraightTag {
  Corners corners;                                                                 // of the tag
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero(), ray = Eigen::Vector2d::Zero();  // its centre
  Eigen::Matrix2d d_pixel_d_ray = Eigen::Matrix2d::Identity();

  Eigen::Vector2d FromRay(const Eigen::Vector2d& other) const {
    return pixel + d_pixel_d_ray * (other - ray);
  }
};

// Where a row of the image may meet a convex region: the region's half planes are a x + b < 0.
struct Interval {
  double first, last;  // empty when last < first

  void Cut(double a, double b) {
    if (a > 0) last = std::min(last, std::ceil(-b / a) - 1);
    if (a < 0) first = std::max(first, std::floor(-b / a) + 1);
    if (a == 0 && !(b < 0)) last = first - 1;
  }
};

double QuadArea(const Corners& c) {
  const Eigen::Vector2d a = c[2] - c[0], b = c[3] - c[1];
  return 0.5 * std::abs(a.x() * b.y() - a.y() * b.x());
}

// The square |u| < most, |v| < most of tag coordinates.
void CutToSquare(const Eigen::Matrix3d& tag_from_pixel, double most, int y, Interval* row) {
  const Eigen::Vector3d slope = tag_from_pixel.col(0);
  const Eigen::Vector3d start = tag_from_pixel.col(1) * y + tag_from_pixel.col(2);
  for (const double sign : {-1.0, 1.0}) {
    for (int axis = 0; axis < 2; ++axis) {
      row->Cut(sign * slope[axis] - most * slope.z(), sign * start[axis] - most * start.z());
    }
  }
}
bool IsInSquare(const Eigen::Matrix3d& tag_from_pixel, double most, const Eigen::Vector2d& at) {
  const Eigen::Vector3d q = tag_from_pixel * at.homogeneous();
  return std::abs(q.x()) < most * q.z() && std::abs(q.y()) < most * q.z();
}

}  // namespace

struct CornerRefiner::Impl {
  Camera camera;
  std::unordered_map<int, PatternModel> models;  // by id
  NormalTable normal;
  std::vector<Eigen::Vector2d> rays;  // of every pixel, where the lens distorts

  // nullopt where the lens has no ray.
  std::optional<StraightTag> Straighten(const Corners& in_image) const {
    StraightTag out;
    out.corners = in_image;
    if (!rays.empty()) {
      for (Eigen::Vector2d& corner : out.corners) {
        const auto ray = camera.Unproject(corner);
        if (!ray) return std::nullopt;
        corner = *ray;
        out.ray += 0.25 * corner;
      }
      Eigen::Matrix<double, 2, 3> d_pixel;
      if (!camera.Project(out.ray.homogeneous(), &out.pixel, &d_pixel)) return std::nullopt;
      out.d_pixel_d_ray = d_pixel.leftCols<2>();
      for (Eigen::Vector2d& corner : out.corners) corner = out.FromRay(corner);
    }
    const bool is_near = std::all_of(
        out.corners.begin(), out.corners.end(),
        [](const auto& corner) { return corner.allFinite() && corner.norm() < kFarPx; });
    return is_near ? std::optional(out) : std::nullopt;
  }

  // From the view back into the image, with the covariance.
  bool Distort(const StraightTag& view, RefinedTag* tag) const {
    Eigen::Matrix<double, 8, 8> jacobian = Eigen::Matrix<double, 8, 8>::Zero();
    const Eigen::Matrix2d d_ray = view.d_pixel_d_ray.inverse();
    for (size_t c = 0; c < 4; ++c) {
      const Eigen::Vector2d ray = view.ray + d_ray * (tag->corners[c] - view.pixel);
      Eigen::Matrix<double, 2, 3> d_pixel;
      if (!camera.Project(ray.homogeneous(), &tag->corners[c], &d_pixel)) return false;
      const int at = 2 * static_cast<int>(c);
      jacobian.block<2, 2>(at, at) = d_pixel.leftCols<2>() * d_ray;
    }
    tag->covariance = jacobian * tag->covariance * jacobian.transpose();
    return true;
  }

  std::vector<PatternPlace> FindPlaces(const cv::Mat& gray, const Corners& in_image,
                                       const StraightTag& view, const PatternModel& model) const;
  PatternMatch Search(const cv::Mat& gray, const Corners& in_image, const PatternModel& model,
                      int reach) const;
  Corners Shifted(const cv::Mat& gray, Corners in_image, const PatternModel& model,
                  double search_px) const;
  std::optional<RefinedTag> Fit(const cv::Mat& gray, const Corners& in_image,
                                const PatternModel& model, double most_move_px,
                                const std::optional<PatternLook>& look, double off_px) const;
  const PatternModel* ModelFor(const cv::Mat& gray, int id) const;
};

// The pixels of the pattern but for the rim where its surroundings show through the blur; half a
// cell around the square at least.
std::vector<PatternPlace> CornerRefiner::Impl::FindPlaces(const cv::Mat& gray,
                                                          const Corners& in_image,
                                                          const StraightTag& view,
                                                          const PatternModel& model) const {
  std::vector<PatternPlace> out;
  const auto tag_from_pixel = TagFromPixel(view.corners);
  const double cell_px = std::sqrt(QuadArea(view.corners)) / (2 * model.square_half());
  if (!tag_from_pixel || !(cell_px > kLeastCellPx)) return out;
  const double rim = model.pattern_half() - std::min(0.5, 1.5 / cell_px);
  const double most = rim / model.square_half();
  Eigen::AlignedBox2d box;
  for (const auto& corner : in_image) box.extend(corner);
  const double side = box.sizes().maxCoeff();
  if (!(side < kMostSidePx)) return out;
  const Eigen::Vector2d margin = Eigen::Vector2d::Constant(0.75 * (most - 1) * side + 1);
  const Eigen::Vector2d end(gray.cols - 1, gray.rows - 1);
  const Eigen::Vector2d first = (box.min() - margin).array().floor().cwiseMax(0.0);
  const Eigen::Vector2d last = (box.max() + margin).cwiseMin(end).array().ceil();
  out.reserve(static_cast<size_t>(1.6 * QuadArea(view.corners) * most * most));
  for (int y = static_cast<int>(first.y()); y <= last.y(); ++y) {
    Interval row{first.x(), last.x()};
    if (rays.empty()) CutToSquare(*tag_from_pixel, most, y, &row);
    for (int x = static_cast<int>(row.first); x <= row.last; ++x) {
      Eigen::Vector2d at(x, y);
      if (!rays.empty()) {
        at = view.FromRay(rays[static_cast<size_t>(y * gray.cols + x)]);
        if (!IsInSquare(*tag_from_pixel, most, at)) continue;
      }
      out.push_back({x, y, at});
    }
  }
  return out;
}

PatternMatch CornerRefiner::Impl::Search(const cv::Mat& gray, const Corners& in_image,
                                         const PatternModel& model, int reach) const {
  const auto view = Straighten(in_image);
  if (!view) return {};
  const auto places = FindPlaces(gray, in_image, *view, model);
  return SearchPattern(gray, model, normal, view->corners, places, reach);
}

// The corners moved to where the pattern fits best, to a pixel, at most so far; 0: not at all.
Corners CornerRefiner::Impl::Shifted(const cv::Mat& gray, Corners in_image,
                                     const PatternModel& model, double search_px) const {
  if (!(search_px > 0)) return in_image;
  const int reach = static_cast<int>(std::ceil(std::min(search_px, kMostSearchPx)));
  const PatternMatch match = Search(gray, in_image, model, reach);
  for (Eigen::Vector2d& corner : in_image) corner += match.shift_px;
  return in_image;
}

// The model of the tag, or nullptr where the image or the id cannot be worked with.
const PatternModel* CornerRefiner::Impl::ModelFor(const cv::Mat& gray, int id) const {
  const auto found = models.find(id);
  const bool fits = rays.empty() || (gray.cols == camera.width && gray.rows == camera.height);
  return gray.type() == CV_8UC1 && fits && found != models.end() ? &found->second : nullptr;
}

CornerRefiner::CornerRefiner(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
CornerRefiner::CornerRefiner(CornerRefiner&&) noexcept = default;
CornerRefiner& CornerRefiner::operator=(CornerRefiner&&) noexcept = default;
CornerRefiner::~CornerRefiner() = default;

Result<CornerRefiner> CornerRefiner::Create(const TagMap& map, const Camera& camera) {
  std::vector<int> ids;
  for (const Tag& tag : map.tags()) ids.push_back(tag.id);
  const auto patterns = MakeTagPatterns(map.family(), ids);
  if (!patterns) return patterns.error();
  auto impl = std::make_unique<Impl>();
  impl->camera = camera;
  for (size_t i = 0; i < ids.size(); ++i) {
    impl->models.emplace(ids[i], PatternModel((*patterns)[i]));
  }
  if (camera.IsDistorted()) {
    for (int y = 0; y < camera.height; ++y) {
      for (int x = 0; x < camera.width; ++x) {
        const auto ray = camera.Unproject(Eigen::Vector2d(x, y));
        impl->rays.push_back(ray.value_or(Eigen::Vector2d::Constant(NAN)));
      }
    }
  }
  return CornerRefiner(std::move(impl));
}

std::optional<RefinedTag> CornerRefiner::Impl::Fit(const cv::Mat& gray, const Corners& in_image,
                                                   const PatternModel& model, double most_move_px,
                                                   const std::optional<PatternLook>& look,
                                                   double off_px) const {
  const auto view = Straighten(in_image);
  if (!view) return std::nullopt;
  const Corners& start = view->corners;
  PatternPixels pixels;
  pixels.origin = 0.25 * (start[0] + start[1] + start[2] + start[3]);
  auto places = FindPlaces(gray, in_image, *view, model);
  if (look) {
    const double sigma_px = std::sqrt(look->blur_px2[0] + look->blur_px2[2]);
    places = ThinPlaces(model, start, places, kEdgeSigmas * sigma_px + off_px);
  }
  pixels.Reserve(places.size());
  for (const PatternPlace& place : places) {
    pixels.Add(place.at.x(), place.at.y(), gray.at<uint8_t>(place.y, place.x));
  }
  const auto fit = FitPattern(model, normal, pixels, {start, look, off_px > kRoughPx});
  if (!fit) return std::nullopt;
  for (size_t c = 0; c < 4; ++c) {
    if (!((fit->corners[c] - start[c]).norm() < most_move_px)) return std::nullopt;
  }
  RefinedTag out;
  out.corners = fit->corners;
  out.covariance = fit->covariance;
  out.covariance.diagonal().array() += kFloorPx * kFloorPx;
  const PatternState& state = fit->state;
  out.blur_px2 << state.blur_px2[0], state.blur_px2[1], state.blur_px2[1], state.blur_px2[2];
  out.contrast_grey = state.gain;
  out.noise_grey = fit->noise_grey;
  out.inlier_share = fit->inlier_share;
  out.contradicted_share = fit->contradicted_share;
  out.look = {state.blur_px2, state.light, state.black, state.gain, fit->noise_grey};
  if (!(out.inlier_share > kLeastInlierShare) ||
      !(out.contradicted_share < kMostContradictedShare) ||
      !(out.noise_grey < kMostNoiseOfContrast * out.contrast_grey)) {
    return std::nullopt;
  }
  if (!rays.empty() && !Distort(*view, &out)) return std::nullopt;
  return out;
}

std::optional<RefinedTag> CornerRefiner::Refine(const cv::Mat& gray, const TagDetection& tag,
                                                double search_px) const {
  const PatternModel* model = impl_->ModelFor(gray, tag.id);
  if (model == nullptr) return std::nullopt;
  return impl_->Fit(gray, impl_->Shifted(gray, tag.corners, *model, search_px), *model,
                    kMostMovePx + search_px, {}, 0);
}

std::optional<RefinedTag> CornerRefiner::Follow(const cv::Mat& gray, const TagDetection& tag,
                                                const PatternLook& look, double off_px) const {
  const PatternModel* model = impl_->ModelFor(gray, tag.id);
  if (model == nullptr) return std::nullopt;
  const double search_px = off_px > kFollowPx ? off_px : 0;
  return impl_->Fit(gray, impl_->Shifted(gray, tag.corners, *model, search_px), *model,
                    kMostMovePx + search_px, look, std::min(off_px, kFollowPx));
}

double CornerRefiner::Correlation(const cv::Mat& gray, const TagDetection& tag) const {
  const PatternModel* model = impl_->ModelFor(gray, tag.id);
  return model == nullptr ? -1 : impl_->Search(gray, tag.corners, *model, 0).correlation;
}

RefinedTags CornerRefiner::RefineAll(const cv::Mat& gray,
                                     const std::vector<TagDetection>& tags) const {
  RefinedTags out;
  for (TagDetection tag : tags) {
    if (const auto refined = Refine(gray, tag)) {
      tag.corners = refined->corners;
      tag.covariance = refined->covariance;
      out.looks.insert_or_assign(tag.id, refined->look);
    } else {
      tag.covariance = Eigen::Matrix<double, 8, 8>::Identity() * (kUnrefinedPx * kUnrefinedPx);
    }
    out.tags.push_back(tag);
  }
  return out;
}

}  // namespace tagtwist::internal

#include "frontend/pattern/pattern_search.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>

#include "frontend/pattern/pattern_state.h"

namespace tagtwist::internal {
namespace {

constexpr size_t kPixels = 250;  // are enough

double Correlate(const cv::Mat& gray, const std::vector<PatternPlace>& places,
                 const std::vector<double>& white, int dx, int dy) {
  double n = 0, a = 0, b = 0, aa = 0, ab = 0, bb = 0;
  for (size_t i = 0; i < places.size(); ++i) {
    const int x = places[i].x + dx, y = places[i].y + dy;
    if (x < 0 || y < 0 || x >= gray.cols || y >= gray.rows) continue;
    const double grey = gray.at<uint8_t>(y, x);
    n += 1;
    a += white[i];
    b += grey;
    aa += white[i] * white[i];
    ab += white[i] * grey;
    bb += grey * grey;
  }
  const double spread = (n * aa - a * a) * (n * bb - b * b);
  return spread > 0 ? (n * ab - a * b) / std::sqrt(spread) : -1;
}

// Which points [cells, from the pattern's first corner] have a cell that differs from a neighbour
// within reach. Sides and neighbours are bits, for what a pixel is near to no processor foresees.
class EdgeFinder {
 public:
  EdgeFinder(const PatternModel& model, float reach)
      : cells_(model.cells()), reach_(reach), differs_(static_cast<size_t>(cells_ * cells_)) {
    for (size_t i = 0; i < differs_.size(); ++i) {
      const auto& around = model.Around(static_cast<int>(i) % cells_, static_cast<int>(i) / cells_);
      for (size_t k = 1; k < around.size(); ++k) differs_[i] |= (around[k] != 0 ? 1U : 0U) << k;
    }
    for (unsigned sides = 0; sides < within_.size(); ++sides) {
      const bool left = sides & 1U, right = sides & 2U, above = sides & 4U, below = sides & 8U;
      const std::array<bool, 9> near = {false, left,          right,
                                        above, above && left, above && right,
                                        below, below && left, below && right};
      for (size_t k = 1; k < near.size(); ++k) within_[sides] |= (near[k] ? 1U : 0U) << k;
    }
  }

  bool IsNear(float u, float v) const {
    const int column = std::clamp(static_cast<int>(u), 0, cells_ - 1);
    const int row = std::clamp(static_cast<int>(v), 0, cells_ - 1);
    const float du = u - static_cast<float>(column), dv = v - static_cast<float>(row);
    const auto bit = [](bool is, unsigned at) { return (is ? 1U : 0U) << at; };
    const unsigned sides = bit(du < reach_, 0) | bit(du > 1 - reach_, 1) | bit(dv < reach_, 2) |
                           bit(dv > 1 - reach_, 3);
    return (differs_[static_cast<size_t>(row * cells_ + column)] & within_[sides]) != 0;
  }

 private:
  int cells_;
  float reach_;
  std::vector<unsigned> differs_;         // of each cell: neighbour k of PatternModel::Around
  std::array<unsigned, 16> within_ = {};  // of sides that are within reach: those neighbours
};

}  // namespace

std::vector<PatternPlace> ThinPlaces(const PatternModel& model,
                                     const std::array<Eigen::Vector2d, 4>& corners,
                                     const std::vector<PatternPlace>& places, double reach_px) {
  constexpr unsigned kOthersPerKept = 4;
  const auto tag_from_pixel = TagFromPixel(corners);
  if (!tag_from_pixel) return places;
  const Eigen::Matrix3f g = tag_from_pixel->cast<float>();
  const auto h = static_cast<float>(model.square_half());
  const auto half = static_cast<float>(model.pattern_half());
  const double side_px =
      0.5 * ((corners[2] - corners[0]).norm() + (corners[3] - corners[1]).norm()) * std::sqrt(0.5);
  const auto reach = static_cast<float>(reach_px * 2 * model.square_half() / side_px);
  const EdgeFinder edges(model, reach);
  std::vector<PatternPlace> out(places.size());
  size_t kept = 0;
  unsigned others = 0;
  for (const PatternPlace& place : places) {
    const Eigen::Vector3f q = g * place.at.cast<float>().homogeneous();
    const float scale = h / q.z();
    const bool is_near = edges.IsNear(q.x() * scale + half, q.y() * scale + half);
    out[kept] = place;  // stays where it counts, else the next one takes its place
    kept += (is_near || others % kOthersPerKept == 0) ? 1 : 0;
    others += is_near ? 0 : 1;
  }
  out.resize(kept);
  return out;
}

PatternMatch SearchPattern(const cv::Mat& gray, const PatternModel& model,
                           const NormalTable& normal, const std::array<Eigen::Vector2d, 4>& corners,
                           const std::vector<PatternPlace>& places, int reach) {
  PatternMatch best;
  const auto tag_from_pixel = TagFromPixel(corners);
  if (!tag_from_pixel) return best;
  PatternState state;
  state.tag_from_pixel = *tag_from_pixel;
  state.gain = 1;
  std::vector<PatternPlace> some;
  std::vector<double> white;
  const size_t stride = std::max<size_t>(places.size() / kPixels, 1);
  for (size_t i = 0; i < places.size(); i += stride) {
    some.push_back(places[i]);
    white.push_back(PredictGrey(model, state, normal, places[i].at, nullptr));
  }
  for (int dy = -reach; dy <= reach; ++dy) {
    for (int dx = -reach; dx <= reach; ++dx) {
      const double correlation = Correlate(gray, some, white, dx, dy);
      if (correlation > best.correlation) best = {Eigen::Vector2d(dx, dy), correlation};
    }
  }
  return best;
}

}  // namespace tagtwist::internal

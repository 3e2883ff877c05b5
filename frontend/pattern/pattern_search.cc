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

// A point [cells, from the pattern's first corner] whose cell differs from a neighbour that is
// within reach.
bool IsNearEdge(const PatternModel& model, float u, float v, float reach) {
  const int column = std::clamp(static_cast<int>(u), 0, model.cells() - 1);
  const int row = std::clamp(static_cast<int>(v), 0, model.cells() - 1);
  const auto& c = model.Around(column, row);
  const float du = u - static_cast<float>(column), dv = v - static_cast<float>(row);
  const bool left = du<reach, right = du> 1 - reach, above = dv<reach, below = dv> 1 - reach;
  return (left && c[1] != 0) || (right && c[2] != 0) ||
         (above && (c[3] != 0 || (left && c[4] != 0) || (right && c[5] != 0))) ||
         (below && (c[6] != 0 || (left && c[7] != 0) || (right && c[8] != 0)));
}

}  // namespace

std::vector<PatternPlace> ThinPlaces(const PatternModel& model,
                                     const std::array<Eigen::Vector2d, 4>& corners,
                                     const std::vector<PatternPlace>& places, double reach_px) {
  constexpr int kOthersPerKept = 4;
  const auto tag_from_pixel = TagFromPixel(corners);
  if (!tag_from_pixel) return places;
  const Eigen::Matrix3f g = tag_from_pixel->cast<float>();
  const auto h = static_cast<float>(model.square_half());
  const auto half = static_cast<float>(model.pattern_half());
  const double side_px =
      0.5 * ((corners[2] - corners[0]).norm() + (corners[3] - corners[1]).norm()) * std::sqrt(0.5);
  const auto reach = static_cast<float>(reach_px * 2 * model.square_half() / side_px);
  std::vector<PatternPlace> out;
  out.reserve(places.size());
  int others = 0;
  for (const PatternPlace& place : places) {
    const Eigen::Vector3f q = g * place.at.cast<float>().homogeneous();
    const float scale = h / q.z();
    if (IsNearEdge(model, q.x() * scale + half, q.y() * scale + half, reach) ||
        others++ % kOthersPerKept == 0) {
      out.push_back(place);
    }
  }
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

#include "frontend/pattern_search.h"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>

#include "frontend/pattern_state.h"

namespace tagtwist {
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

}  // namespace

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

}  // namespace tagtwist

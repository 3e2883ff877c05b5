#pragma once
#include <optional>
#include <string>

namespace tagtwist {

/// Field names are the YAML keys of the section `klt`.
struct KltOptions {
  int max_points = 250;        // open tracks, >= 0; the seed's RANSAC stops at 200 inliers
  double min_distance_px = 6;  // between tracks where they begin, >= 1
  int fast_threshold = 20;     // FAST's contrast [gray], in [1, 254]
  int min_fast_threshold = 5;  // down to which it falls where corners are few, or to 6 sigma of the
                               // image's noise if that is more [gray], same range
  int window_px = 15;          // side of the Lucas-Kanade window, odd, in [5, 61]
  int pyramid_levels = 3;      // above the full image, in [0, 8]
  int max_iterations = 15;     // per level, in [1, 100]
  double convergence_px = 0.02;      // a step below this ends a level, > 0
  double forward_backward_px = 0.5;  // the way back may miss the start by this, > 0
  double max_difference = 25;        // mean difference of the two windows [gray], > 0
  double border_px = 3;              // tracks nearer to the image's border end, >= 0
  int enough_tags = 0;         // with that many tags in view nothing is tracked; 0: always, >= 0
  double tag_margin = 0.1875;  // on_tag reaches out by this fraction of a tag's side, >= 0

  std::optional<std::string> Problem() const;

  template <typename Self, typename Visitor>
  static void VisitFields(Self& self, Visitor&& visit) {
    visit("max_points", self.max_points);
    visit("min_distance_px", self.min_distance_px);
    visit("fast_threshold", self.fast_threshold);
    visit("min_fast_threshold", self.min_fast_threshold);
    visit("window_px", self.window_px);
    visit("pyramid_levels", self.pyramid_levels);
    visit("max_iterations", self.max_iterations);
    visit("convergence_px", self.convergence_px);
    visit("forward_backward_px", self.forward_backward_px);
    visit("max_difference", self.max_difference);
    visit("border_px", self.border_px);
    visit("enough_tags", self.enough_tags);
    visit("tag_margin", self.tag_margin);
  }
};

}  // namespace tagtwist

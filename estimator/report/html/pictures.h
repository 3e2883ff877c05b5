#pragma once
#include <map>
#include <string>
#include <vector>

#include "estimator/evaluation/pose_series.h"
#include "frontend/types/tag_map.h"

namespace tagtwist::internal {

/// A trajectory in the picture from above; `slot` as in PlotSeries.
struct PicturePath {
  size_t slot = 0;
  PoseSeries series;
  bool sets_extent = true;  // false: cut at the border, so that outliers do not shrink the rest
};

/// What a tag's square shows instead of its id, and its colour (CSS).
struct TagMark {
  std::string label, colour;
};

/// The plane z = 0 seen from above as SVG: x of W runs down, y to the right, with a grid in metres,
/// the tags of the map (which may be empty) and the paths over them. `marks`: by tag id.
std::string MapPictureSvg(const TagMap& map, const std::vector<PicturePath>& paths,
                          const std::map<int, TagMark>& marks = {});

/// Step of an axis: 1, 2 or 5 times a power of ten, at most `most` steps over the span > 0.
double NiceStep(double span, int most);

/// Histogram as SVG; the last bar holds all values above the 99th percentile. Empty for no values.
std::string HistogramSvg(std::vector<double> values, const std::string& unit);

}  // namespace tagtwist::internal

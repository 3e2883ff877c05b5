#pragma once
#include <string>
#include <vector>

#include "frontend/base/result.h"
#include "frontend/simulation/spline_trajectory.h"
#include "frontend/types/body_state.h"
#include "frontend/types/tag_map.h"

namespace tagtwist {

struct FlightOptions {
  double duration_s = 20.0;  // [s], >= 1
  double height_m = 1.2;     // of the body's origin above z = 0 [m], > 0
  std::optional<std::string> Problem() const;

  template <typename Self, typename Visitor>
  static void VisitFields(Self& self, Visitor&& visit) {
    visit("duration_s", self.duration_s);
    visit("height_m", self.height_m);
  }
};

/// "figure8", "hover", "circle", "agile", "straight".
std::vector<std::string> FlightNames();

/// Poses at 100 Hz of a flight over the map, from t = 0, start and end at rest. The body's z leans
/// as thrust must: along the acceleration plus 1 g upwards. Widths follow the extent of the map
/// in x and y; "straight" does not turn at all.
Result<std::vector<TruthSample>> MakeFlight(const std::string& name, const TagMap& map,
                                            const FlightOptions& options);

/// A named flight as a smooth path, whose twists are exact.
Result<SplineTrajectory> FlightPath(const std::string& name, const TagMap& map,
                                    const FlightOptions& options);

}  // namespace tagtwist

#include "frontend/simulation/named_flights.h"

#include <algorithm>
#include <cmath>

#include "frontend/base/option_check.h"
#include "frontend/base/units.h"

namespace tagtwist {

using namespace internal;
namespace {

constexpr double kGravity = 9.81;      // [m/s^2]
constexpr double kSampleStepS = 0.01;  // 100 Hz
constexpr double kDerivativeStepS = 2e-3;

// Where the flight is after s seconds of cruising out of a total, relative to the map's centre.
// Unit of x and y: half the map's extent; z in units of the height.
struct Point {
  Eigen::Vector3d position;
  double yaw = 0;  // [rad]
};

Point Figure8(double s, double /*total*/) {
  const double a = 2 * kPi * s / 9.0;
  return {{0.45 * std::sin(a), 0.4 * std::sin(2 * a), 0.06 * std::sin(1.3 * a)},
          0.6 * std::sin(0.5 * a)};
}
Point Hover(double s, double /*total*/) {
  return {{0.02 * std::sin(1.1 * s), 0.02 * std::sin(1.7 * s), 0.015 * std::sin(0.8 * s)},
          0.1 * std::sin(0.6 * s)};
}
Point Circle(double s, double /*total*/) {
  const double a = 2 * kPi * s / 8.0;
  return {{0.4 * (std::cos(a) - 0.3), 0.4 * std::sin(a), 0}, a};
}
Point Agile(double s, double /*total*/) {
  return {{0.36 * std::sin(2.6 * s), 0.32 * std::sin(3.1 * s), 0.1 * std::sin(1.9 * s)},
          0.7 * std::sin(1.3 * s)};
}
Point Straight(double s, double total) { return {{0.9 * (s / total - 0.5), 0, 0}, 0}; }

struct Flight {
  const char* name;
  Point (*path)(double s, double total);
  bool leans;
};
constexpr Flight kFlights[] = {{"figure8", Figure8, true},
                               {"hover", Hover, true},
                               {"circle", Circle, true},
                               {"agile", Agile, true},
                               {"straight", Straight, false}};

// Seconds of cruising done at time t: speed 0 to 1 within the ramp, 1 in the middle, 1 to 0 at the
// end. The speed rises as the smootherstep 10 u^3 - 15 u^4 + 6 u^5, whose integral is below.
struct Cruise {
  double done_s = 0, total_s = 0;
};
Cruise CruiseAt(double t, double duration_s) {
  const double ramp_s = std::min(2.0, 0.25 * duration_s);
  const auto risen = [ramp_s](double s) {
    const double u = std::clamp(s / ramp_s, 0.0, 1.0), u4 = u * u * u * u;
    return ramp_s * u4 * (2.5 - 3 * u + u * u) + std::max(0.0, s - ramp_s);
  };
  const double total = 2 * risen(0.5 * duration_s);
  return {t < 0.5 * duration_s ? risen(t) : total - risen(duration_s - t), total};
}

struct Area {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero(), half_extent = Eigen::Vector3d::Zero();
};
Area FindArea(const TagMap& map, double height_m) {
  Eigen::AlignedBox3d box;
  for (const Tag& tag : map.tags()) {
    for (const Eigen::Vector3d& corner : map.CornersInWorld(tag.id)) box.extend(corner);
  }
  return {{box.center().x(), box.center().y(), height_m},
          {0.5 * box.sizes().x(), 0.5 * box.sizes().y(), height_m}};
}

// Attitude of a body that turns by yaw about the vertical and leans so that its z is along up.
Eigen::Quaterniond Lean(const Eigen::Vector3d& up, double yaw) {
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()));
  return Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), up) * turn;
}

Pose PoseAt(const Flight& flight, const Area& area, double duration_s, double t) {
  const auto point = [&](double time) {
    const Cruise cruise = CruiseAt(time, duration_s);
    return flight.path(cruise.done_s, cruise.total_s);
  };
  const auto position = [&](double time) -> Eigen::Vector3d {
    return area.centre + area.half_extent.cwiseProduct(point(time).position);
  };
  const double h = kDerivativeStepS;
  const Eigen::Vector3d acceleration =
      (position(t + h) - 2 * position(t) + position(t - h)) / (h * h);
  const Eigen::Vector3d up =
      Eigen::Vector3d::UnitZ() * kGravity + (flight.leans ? 1.0 : 0.0) * acceleration;
  return MakePose(Lean(up, point(t).yaw), position(t));
}

}  // namespace

std::optional<std::string> FlightOptions::Problem() const {
  if (auto problem = CheckRange("duration_s", duration_s, 1, 3600)) return problem;
  return CheckPositive("height_m", height_m);
}

std::vector<std::string> FlightNames() {
  std::vector<std::string> out;
  for (const Flight& flight : kFlights) out.emplace_back(flight.name);
  return out;
}

Result<std::vector<TruthSample>> MakeFlight(const std::string& name, const TagMap& map,
                                            const FlightOptions& options) {
  if (const auto problem = options.Problem()) return Error{*problem};
  const Flight* flight =
      std::find_if(std::begin(kFlights), std::end(kFlights),
                   [&](const Flight& candidate) { return name == candidate.name; });
  if (flight == std::end(kFlights)) {
    std::string known;
    for (const Flight& f : kFlights) known += (known.empty() ? "" : ", ") + std::string(f.name);
    return Error{"trajectory: expected a file or one of " + known + ", got '" + name + "'"};
  }
  const Area area = FindArea(map, options.height_m);
  const auto steps = static_cast<int>(std::lround(options.duration_s / kSampleStepS));
  std::vector<TruthSample> out;
  for (int i = 0; i <= steps; ++i) {
    const double t = options.duration_s * i / steps;
    TruthSample sample;
    sample.t_ns = std::llround(1e9 * t);
    sample.world_from_body = PoseAt(*flight, area, options.duration_s, t);
    out.push_back(sample);
  }
  return out;
}

Result<SplineTrajectory> FlightPath(const std::string& name, const TagMap& map,
                                    const FlightOptions& options) {
  const auto poses = MakeFlight(name, map, options);
  if (!poses) return poses.error();
  return SplineTrajectory::Fit(*poses, {});
}

}  // namespace tagtwist

#include "estimator/report/html/plots.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "estimator/evaluation/alignment.h"
#include "estimator/evaluation/truth_match.h"
#include "frontend/base/units.h"
#include "frontend/io/trajectories/vicon.h"
#include "frontend/types/so3.h"
#include "frontend/types/truth.h"

namespace tagtwist::internal {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kBand = 3;
constexpr size_t kTruthSlot = 0;

// The twelve values of a plot row, [position m, roll pitch yaw deg, velocity m/s, rate rad/s], and
// three times their standard deviations; NaN where there is nothing.
struct Shown {
  StateVector value = StateVector::Constant(kNan);
  StateVector band = StateVector::Constant(kNan);
};

// One column of values over all stamps.
using Column = std::vector<Shown>;

Shown Show(const PoseSample& sample) {
  Shown out;
  const Eigen::Vector3d angles =
      ZxyFromRotation(Eigen::Quaterniond(sample.world_from_body.rotation()));
  out.value.head<3>() = sample.world_from_body.translation();
  out.value.segment<3>(3) = kDegreesPerRadian * angles;
  if (sample.twist) out.value.tail<6>() << sample.twist->v_world, sample.twist->omega_body;
  if (!sample.covariance) return out;
  const StateCovariance& p = *sample.covariance;
  const Eigen::Matrix3d rates = ZxyRatesFromBodyRates(angles);
  out.band.head<3>() = p.diagonal().segment<3>(3).cwiseSqrt();
  out.band.segment<3>(3) =
      kDegreesPerRadian *
      (rates * p.topLeftCorner<3, 3>() * rates.transpose()).diagonal().cwiseSqrt();
  out.band.tail<6>() = p.diagonal().tail<6>().cwiseSqrt();
  out.band *= kBand;
  return out;
}

// Error of an estimate, [position mm, rotation vector in B deg, velocity m/s, rate rad/s].
Shown ShowError(const PoseSample& estimate, const TruthSample& truth) {
  Shown out;
  const bool twist = estimate.twist && truth.twist;
  const StateVector error =
      Difference(BodyState{estimate.world_from_body, estimate.twist.value_or(Twist())},
                 {truth.world_from_body, truth.twist.value_or(Twist())});
  const auto arrange = [](const StateVector& e) {
    StateVector shown;
    shown << 1e3 * e.segment<3>(3), kDegreesPerRadian * e.head<3>(), e.tail<6>();
    return shown;
  };
  out.value = arrange(error);
  if (!twist) out.value.tail<6>().setConstant(kNan);
  if (estimate.covariance) {
    out.band = kBand * arrange(estimate.covariance->diagonal().cwiseSqrt());
  }
  return out;
}

size_t IndexOf(const std::vector<int64_t>& stamps_ns, int64_t t_ns) {
  return static_cast<size_t>(std::lower_bound(stamps_ns.begin(), stamps_ns.end(), t_ns) -
                             stamps_ns.begin());
}

// Angles run on through +-180 degrees, and all columns take the turn that the first one has.
void Unwrap(std::vector<Column>* columns) {
  for (int i = 3; i < 6; ++i) {
    double last = kNan;
    for (size_t row = 0; !columns->empty() && row < columns->front().size(); ++row) {
      for (Column& column : *columns) {
        double& angle = column[row].value(i);
        if (!std::isfinite(angle)) continue;
        if (std::isfinite(last)) angle -= 360 * std::round((angle - last) / 360);
        last = angle;
      }
    }
  }
}

bool AnyFinite(const Column& column, int i, bool band) {
  return std::any_of(column.begin(), column.end(), [i, band](const Shown& s) {
    return std::isfinite(band ? s.band(i) : s.value(i));
  });
}

PlotSeries MakeSeries(size_t slot, const Column& column, int i, bool with_values, bool with_bands) {
  PlotSeries out;
  out.slot = slot;
  for (const Shown& s : column) {
    out.values.push_back(with_values ? s.value(i) : std::isfinite(s.band(i)) ? 0.0 : kNan);
    if (with_bands) out.half_widths.push_back(s.band(i));
  }
  return out;
}

struct Quantity {
  const char* section;
  const char* error_section;
  const char* text;
  const char* error_text;
  std::array<const char*, 3> titles, error_titles;
  int decimals, error_decimals;
};

const std::array<Quantity, 4> kQuantities = {{
    {"Position",
     "Position error",
     "Body origin in W, with 3-sigma bands.",
     "Estimate minus truth, in W. The band is ±3 sigma around zero: the error should stay in it.",
     {"x [m]", "y [m]", "z [m]"},
     {"x error [mm]", "y error [mm]", "z error [mm]"},
     5,
     3},
    {"Attitude",
     "Attitude error",
     "Body in W, Euler angles in the order Z-X-Y: rotation = Rz(yaw) Rx(roll) Ry(pitch).",
     "Rotation vector from true to estimated attitude, in B.",
     {"roll [deg]", "pitch [deg]", "yaw [deg]"},
     {"about body x [deg]", "about body y [deg]", "about body z [deg]"},
     4,
     4},
    {"Velocity",
     "Velocity error",
     "Of the body origin, in W.",
     "Estimate minus truth, in W.",
     {"vx [m/s]", "vy [m/s]", "vz [m/s]"},
     {"vx error [m/s]", "vy error [m/s]", "vz error [m/s]"},
     5,
     5},
    {"Rates",
     "Rate error",
     "Angular rate of the body, in B.",
     "Estimate minus truth, in B.",
     {"wx [rad/s]", "wy [rad/s]", "wz [rad/s]"},
     {"wx error [rad/s]", "wy error [rad/s]", "wz error [rad/s]"},
     5,
     5},
}};

// The columns of all series (and their slots) drawn as values, or as errors with bands around zero.
ReportSection MakeSection(int quantity, bool errors, const PlotInput& input,
                          const std::vector<size_t>& slots, const std::vector<Column>& columns) {
  const Quantity& q = kQuantities[static_cast<size_t>(quantity)];
  ReportSection out;
  out.title = errors ? q.error_section : q.section;
  out.html = ParagraphHtml(errors ? q.error_text : q.text, "note");
  for (int axis = 0; axis < 3; ++axis) {
    const int i = 3 * quantity + axis;
    Plot plot;
    plot.title = (errors ? q.error_titles : q.titles)[static_cast<size_t>(axis)];
    plot.decimals = errors ? q.error_decimals : q.decimals;
    plot.connect = input.connect;
    for (const int64_t t_ns : input.stamps_ns) plot.t_s.push_back(ToSeconds(t_ns - input.t0_ns));
    for (size_t c = 0; c < columns.size(); ++c) {
      if (!AnyFinite(columns[c], i, false)) continue;
      const bool band = AnyFinite(columns[c], i, true);
      if (errors && band) plot.series.push_back(MakeSeries(slots[c], columns[c], i, false, true));
      plot.series.push_back(MakeSeries(slots[c], columns[c], i, true, band && !errors));
    }
    if (!plot.series.empty()) out.plots.push_back(std::move(plot));
  }
  return out;
}

Column TruthColumn(const PlotInput& input) {
  Column out(input.stamps_ns.size());
  for (size_t i = 0; i < out.size(); ++i) {
    const auto at = InterpolateTruth(input.truth, input.stamps_ns[i], input.max_truth_gap_s);
    if (at) out[i] = Show({at->t_ns, at->world_from_body, at->twist, std::nullopt});
  }
  return out;
}

Column ValueColumn(const PlotInput& input, const PlottedSeries& series) {
  Column out(input.stamps_ns.size());
  for (const PoseSample& s : series.series) {
    out[IndexOf(input.stamps_ns, s.t_ns)] =
        Show(Transform(s, series.alignment.truth_from_world, series.alignment.body_from_marker));
  }
  return out;
}

Column ErrorColumn(const PlotInput& input, const PlottedSeries& series) {
  Column out(input.stamps_ns.size());
  for (const TruthMatch& m :
       AlignedMatches(series.series, input.truth, series.alignment, input.max_truth_gap_s)) {
    out[IndexOf(input.stamps_ns, m.estimate.t_ns)] = ShowError(m.estimate, m.truth);
  }
  return out;
}

}  // namespace

// The columns of the inverse are the axes of the three turns, in B.
Eigen::Matrix3d ZxyRatesFromBodyRates(const Eigen::Vector3d& roll_pitch_yaw) {
  const double sr = std::sin(roll_pitch_yaw.x()), cr = std::cos(roll_pitch_yaw.x());
  const double sp = std::sin(roll_pitch_yaw.y()), cp = std::cos(roll_pitch_yaw.y());
  Eigen::Matrix3d body_rates_from_angle_rates;
  body_rates_from_angle_rates << cp, 0, -sp * cr, 0, 1, sr, sp, 0, cp * cr;
  if (std::abs(cr) < 1e-9) return Eigen::Matrix3d::Constant(kNan);
  return body_rates_from_angle_rates.inverse();
}

std::vector<ReportSection> TrajectorySections(const PlotInput& input) {
  std::vector<size_t> slots, error_slots;
  std::vector<Column> columns, error_columns;
  for (const PlottedSeries& series : input.series) {
    slots.push_back(series.slot);
    columns.push_back(ValueColumn(input, series));
    if (input.truth.empty()) continue;
    error_slots.push_back(series.slot);
    error_columns.push_back(ErrorColumn(input, series));
  }
  if (!input.truth.empty() && !slots.empty()) {  // under the estimate, above the closed form
    slots.insert(slots.end() - 1, kTruthSlot);
    columns.insert(columns.end() - 1, TruthColumn(input));
  }
  Unwrap(&columns);
  std::vector<ReportSection> out;
  for (int quantity = 0; quantity < 4; ++quantity) {
    for (const bool errors : {false, true}) {
      ReportSection section = MakeSection(quantity, errors, input, errors ? error_slots : slots,
                                          errors ? error_columns : columns);
      if (!section.plots.empty()) out.push_back(std::move(section));
    }
  }
  return out;
}

}  // namespace tagtwist::internal

#include "estimator/fleet/fleet_plots.h"

#include <algorithm>
#include <cmath>

#include "estimator/report/html/page.h"
#include "frontend/base/format_text.h"

namespace tagtwist::internal {
namespace {

constexpr double kWidth = 420, kHeight = 260, kLeft = 56, kRight = 12, kTop = 10, kBottom = 40;

// Decades of an axis, and where a value lies on it.
struct LogAxis {
  double low = 0, high = 1, begin = 0, end = 1;
  double At(double value) const {
    return begin + (end - begin) * (std::log10(value) - low) / (high - low);
  }
};

LogAxis AxisOf(const std::vector<double>& values, double begin, double end) {
  const auto [least, most] = std::minmax_element(values.begin(), values.end());
  double low = std::log10(*least), high = std::log10(*most);
  const double margin = 0.05 * std::max(high - low, 1.0);
  low -= margin;
  high += margin;
  return {low, high, begin, end};
}

// 1, 2 and 5 times the powers of ten; where there are many, the powers alone.
std::vector<double> TicksOf(const LogAxis& axis) {
  std::vector<double> out;
  const bool is_wide = axis.high - axis.low > 2.5;
  for (int decade = static_cast<int>(std::floor(axis.low)); decade <= axis.high; ++decade) {
    for (const double digit : {1.0, 2.0, 5.0}) {
      if (is_wide && digit != 1) continue;
      const double tick = digit * std::pow(10, decade);
      if (std::log10(tick) >= axis.low && std::log10(tick) <= axis.high) out.push_back(tick);
    }
  }
  return out;
}

std::string LineSvg(const char* css, double x1, double y1, double x2, double y2) {
  return Format("<line class=\"%s\" x1=\"%.1f\" y1=\"%.1f\" x2=\"%.1f\" y2=\"%.1f\"/>\n", css, x1,
                y1, x2, y2);
}

std::string AxesSvg(const LogAxis& x, const LogAxis& y, const std::string& x_title,
                    const std::string& y_title) {
  std::string out;
  for (const double tick : TicksOf(x)) {
    out += LineSvg("grid", x.At(tick), kTop, x.At(tick), kHeight - kBottom);
    out += Format("<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"middle\">%.3g</text>\n", x.At(tick),
                  kHeight - kBottom + 14, tick);
  }
  for (const double tick : TicksOf(y)) {
    out += LineSvg("grid", kLeft, y.At(tick), kWidth - kRight, y.At(tick));
    out += Format("<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"end\">%.3g</text>\n", kLeft - 6,
                  y.At(tick) + 4, tick);
  }
  out += Format("<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"middle\">", kWidth / 2, kHeight - 6) +
         EscapeHtml(x_title) + "</text>\n";
  return out +
         Format("<text transform=\"translate(12 %.1f) rotate(-90)\" text-anchor=\"middle\">",
                kHeight / 2) +
         EscapeHtml(y_title) + "</text>\n";
}

}  // namespace

std::string ScatterSvg(const std::vector<ScatterPoint>& points, const std::string& x_title,
                       const std::string& y_title, bool diagonal) {
  std::vector<ScatterPoint> drawn;
  std::vector<double> xs, ys;
  for (const ScatterPoint& point : points) {
    if (!(point.x > 0) || !(point.y > 0) || !std::isfinite(point.x * point.y)) continue;
    drawn.push_back(point);
    xs.push_back(point.x);
    ys.push_back(point.y);
  }
  if (drawn.size() < 2) return "";
  const LogAxis x = AxisOf(xs, kLeft, kWidth - kRight);
  const LogAxis y = AxisOf(ys, kHeight - kBottom, kTop);
  std::string out =
      Format("<svg class=\"scatter\" viewBox=\"0 0 %.0f %.0f\" role=\"img\">\n", kWidth, kHeight) +
      AxesSvg(x, y, x_title, y_title);
  const double low = std::max(x.low, y.low), high = std::min(x.high, y.high);
  if (diagonal && low < high) {
    const double from = std::pow(10, low), to = std::pow(10, high);
    out += LineSvg("diagonal", x.At(from), y.At(from), x.At(to), y.At(to));
  }
  for (const ScatterPoint& point : drawn) {
    out += "<a href=\"#row-" + std::to_string(point.row) + "\">" +
           Format("<circle class=\"point\" cx=\"%.1f\" cy=\"%.1f\" r=\"4\"><title>", x.At(point.x),
                  y.At(point.y)) +
           EscapeHtml(point.title) + "</title></circle></a>\n";
  }
  return out + "</svg>\n";
}

}  // namespace tagtwist::internal

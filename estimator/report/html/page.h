#pragma once
#include <cstddef>
#include <string>
#include <vector>

#include "estimator/report/findings/comparison_table.h"

namespace tagtwist::internal {

/// A line of a plot. Values that are not finite are gaps.
struct PlotSeries {
  size_t slot = 0;                  // into ReportPage::slots: name, colour, and what hides together
  std::vector<double> values;       // one a time
  std::vector<double> half_widths;  // of the band around them, or empty
};

/// A plot over time; all its series share the times.
struct Plot {
  std::string title;        // with the unit: "x [m]"
  int decimals = 4;         // that values are rounded to
  bool connect = false;     // gaps are bridged: the series have stamps of their own
  bool trim = false;        // the highest twentieth of the values may lie outside at first
  std::vector<double> t_s;  // growing
  std::vector<PlotSeries> series;
};

/// A part of the page: heading, text (HTML, from the functions below), plots side by side, notes.
struct ReportSection {
  std::string title;
  std::string html;
  std::vector<Plot> plots;
};

/// A page that explains itself and opens without a network.
struct ReportPage {
  std::string title;
  std::string html;                // below the title
  std::vector<std::string> slots;  // names of the series; slot 0 has the colour of the text
  std::vector<ReportSection> sections;
};

/// Plots longer than this are thinned: of each stretch of time the least and the greatest value of
/// every series stay, so that no peak is lost.
constexpr size_t kMaxPlotPoints = 4000;
std::vector<size_t> ThinnedIndices(const Plot& plot, size_t max_points);

std::string EscapeHtml(const std::string& text);
std::string ParagraphHtml(const std::string& text, const std::string& css_class = "");
std::string TableHtml(const TextTable& table);

/// Buttons that hide and show the series of these slots everywhere on the page.
std::string LegendHtml(const std::vector<size_t>& slots, const std::vector<std::string>& names);

/// The whole file.
std::string FormatReportPage(const ReportPage& page);

}  // namespace tagtwist::internal

#include "estimator/report/html/page.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>
#include <string_view>

namespace tagtwist::internal {

// Embedded by CMake.
std::string_view ReportCss();
std::string_view ReportJs();
std::string_view DygraphsJs();
std::string_view DygraphsLicence();

namespace {

// "12.5" for 12.5000; "null" for what is not finite.
void AppendRounded(std::string* out, double value, int decimals) {
  if (!std::isfinite(value)) {
    *out += "null";
    return;
  }
  std::array<char, 400> text;
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value,
                                 std::chars_format::fixed, decimals);
  std::string_view digits(text.data(), static_cast<size_t>(end.ptr - text.data()));
  if (decimals > 0) {
    digits = digits.substr(0, digits.find_last_not_of('0') + 1);
    if (digits.back() == '.') digits.remove_suffix(1);
  }
  *out += digits == "-0" ? "0" : digits;
}

std::string ArrayJson(const std::vector<double>& values, const std::vector<size_t>& indices,
                      int decimals) {
  std::string out = "[";
  for (const size_t i : indices) {
    if (out.size() > 1) out += ',';
    AppendRounded(&out, values[i], decimals);
  }
  return out + "]";
}

// A JSON text that may stand inside a script element.
std::string StringJson(const std::string& text) {
  std::string out;
  for (const char c : nlohmann::json(text).dump(-1, ' ', /*ensure_ascii=*/true,
                                                nlohmann::json::error_handler_t::replace)) {
    out += c == '<' ? std::string("\\u003c") : std::string(1, c);
  }
  return out;
}

std::string PlotJson(const Plot& plot) {
  const std::vector<size_t> indices = ThinnedIndices(plot, kMaxPlotPoints);
  std::string out = "{\"connect\":";
  out += plot.connect ? "true" : "false";
  if (plot.trim) out += ",\"trim\":true";
  out += ",\"t\":" + ArrayJson(plot.t_s, indices, 4) + ",\"series\":[";
  for (size_t k = 0; k < plot.series.size(); ++k) {
    const PlotSeries& s = plot.series[k];
    out += (k == 0 ? "{\"slot\":" : ",{\"slot\":") + std::to_string(s.slot);
    out += ",\"v\":" + ArrayJson(s.values, indices, plot.decimals);
    if (!s.half_widths.empty()) out += ",\"w\":" + ArrayJson(s.half_widths, indices, plot.decimals);
    out += "}";
  }
  return out + "]}";
}

std::string DataJson(const ReportPage& page) {
  std::string out = "{\"slots\":[";
  for (size_t i = 0; i < page.slots.size(); ++i) out += (i ? "," : "") + StringJson(page.slots[i]);
  out += "],\"plots\":[";
  bool first = true;
  for (const ReportSection& section : page.sections) {
    for (const Plot& plot : section.plots) {
      out += (first ? "\n" : ",\n") + PlotJson(plot);
      first = false;
    }
  }
  return out + "]}";
}

std::string SectionHtml(const ReportSection& section, const std::vector<std::string>& slots,
                        size_t* plot_number) {
  std::string out = "<section>\n<h2>" + EscapeHtml(section.title) + "</h2>\n" + section.html;
  if (section.plots.empty()) return out + "</section>\n";
  std::set<size_t> used;
  for (const Plot& plot : section.plots) {
    for (const PlotSeries& s : plot.series) used.insert(s.slot);
  }
  out += LegendHtml({used.begin(), used.end()}, slots) + "<div class=\"plots\">\n";
  for (const Plot& plot : section.plots) {
    out += "<div class=\"plot\" data-plot=\"" + std::to_string((*plot_number)++) +
           "\"><div class=\"plot-head\"><b>" + EscapeHtml(plot.title) +
           "</b><span class=\"values\"></span></div><div class=\"canvas\"></div></div>\n";
  }
  return out + "</div>\n</section>\n";
}

// The library without its last line, which would make a debugger ask for a file.
std::string_view WithoutSourceMap(std::string_view script) {
  return script.substr(0, script.find("//# sourceMappingURL"));
}

// Bytes of the character that a text begins with; 0 where that is no UTF-8 (RFC 3629, table 3).
size_t Utf8Length(std::string_view text) {
  const auto byte = [&](size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned first = byte(0);
  if (first < 0x80) return 1;
  const size_t length = first >= 0xC2 && first <= 0xDF   ? 2
                        : first >= 0xE0 && first <= 0xEF ? 3
                        : first >= 0xF0 && first <= 0xF4 ? 4
                                                         : 0;
  if (length == 0 || text.size() < length) return 0;
  const unsigned least = first == 0xE0 ? 0xA0 : first == 0xF0 ? 0x90 : 0x80;
  const unsigned most = first == 0xED ? 0x9F : first == 0xF4 ? 0x8F : 0xBF;
  if (byte(1) < least || byte(1) > most) return 0;
  for (size_t i = 2; i < length; ++i) {
    if (byte(i) < 0x80 || byte(i) > 0xBF) return 0;
  }
  return length;
}

}  // namespace

std::vector<size_t> ThinnedIndices(const Plot& plot, size_t max_points) {
  const size_t n = plot.t_s.size();
  std::vector<size_t> out;
  if (n <= max_points || plot.series.empty()) {
    for (size_t i = 0; i < n; ++i) out.push_back(i);
    return out;
  }
  const size_t stretches = std::max<size_t>(1, max_points / (2 * plot.series.size() + 1));
  for (size_t k = 0; k < stretches; ++k) {
    const size_t first = k * n / stretches, last = (k + 1) * n / stretches;
    std::set<size_t> keep = {k + 1 == stretches ? last - 1 : first};
    for (const PlotSeries& s : plot.series) {
      size_t low = last, high = last;
      for (size_t i = first; i < last; ++i) {
        if (!std::isfinite(s.values[i])) continue;
        if (low == last || s.values[i] < s.values[low]) low = i;
        if (high == last || s.values[i] > s.values[high]) high = i;
      }
      if (low != last) keep.insert({low, high});
    }
    out.insert(out.end(), keep.begin(), keep.end());
  }
  return out;
}

std::string EscapeHtml(const std::string& text) {
  std::string out;
  for (size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    const size_t length = Utf8Length(std::string_view(text).substr(i));
    if (length == 0) {
      out += "\xEF\xBF\xBD";  // the sign for what is no character
    } else if (length > 1) {
      out += text.substr(i, length);
      i += length - 1;
    } else if (c == '&') {
      out += "&amp;";
    } else if (c == '<') {
      out += "&lt;";
    } else if (c == '>') {
      out += "&gt;";
    } else if (c == '"') {
      out += "&quot;";
    } else {
      out += c;
    }
  }
  return out;
}

std::string ParagraphHtml(const std::string& text, const std::string& css_class) {
  return (css_class.empty() ? "<p>" : "<p class=\"" + css_class + "\">") + EscapeHtml(text) +
         "</p>\n";
}

std::string TableHtml(const TextTable& table) {
  std::string out = "<div class=\"scroll\"><table>\n";
  for (size_t r = 0; r < table.size(); ++r) {
    const char *open = r == 0 ? "<th>" : "<td>", *close = r == 0 ? "</th>" : "</td>";
    if (r == 0) out += "<thead>";
    if (r == 1) out += "<tbody>\n";
    out += "<tr>";
    for (const std::string& cell : table[r]) {
      out += open;
      out += EscapeHtml(cell);
      out += close;
    }
    out += r == 0 ? "</tr></thead>\n" : "</tr>\n";
  }
  return out + (table.size() > 1 ? "</tbody></table></div>\n" : "</table></div>\n");
}

std::string LegendHtml(const std::vector<size_t>& slots, const std::vector<std::string>& names) {
  std::string out = "<div class=\"legend\">";
  for (const size_t slot : slots) {
    out += "<button type=\"button\" aria-pressed=\"true\" data-slot=\"" + std::to_string(slot) +
           "\">" + EscapeHtml(names[slot]) + "</button>";
  }
  return out + "</div>\n";
}

std::string FormatReportPage(const ReportPage& page) {
  std::string body;
  size_t plot_number = 0;
  for (const ReportSection& section : page.sections) {
    body += SectionHtml(section, page.slots, &plot_number);
  }
  std::string out = "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n";
  out +=
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; "
      "style-src 'unsafe-inline'; script-src 'unsafe-inline'\">\n";
  out += "<title>" + EscapeHtml(page.title) + "</title>\n<style>\n";
  out += ReportCss();
  out += "</style>\n</head>\n<body>\n<h1>" + EscapeHtml(page.title) + "</h1>\n" + page.html;
  out +=
      "<noscript><p class=\"warning\">The plots need JavaScript; all else is "
      "here.</p></noscript>\n";
  out += body;
  out += "<script type=\"application/json\" id=\"data\">" + DataJson(page) + "</script>\n";
  out += "<!--\n" + std::string(DygraphsLicence()) + "-->\n<script>\n";
  out += WithoutSourceMap(DygraphsJs());
  out += "\n</script>\n<script>\n";
  out += ReportJs();
  return out + "</script>\n</body>\n</html>\n";
}

}  // namespace tagtwist::internal

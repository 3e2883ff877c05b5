#include "frontend/base/nearest_name.h"

#include <algorithm>
#include <cctype>

namespace tagtwist::internal {
namespace {

constexpr size_t kLongest = 100;  // of a name that anyone means

std::string Folded(const std::string& name) {
  std::string out;
  for (const char c : name.substr(0, kLongest)) {
    out += c == '-' ? '_' : static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  }
  return out;
}

}  // namespace

// Damerau's distance of adjacent transpositions, row by row.
size_t EditDistance(const std::string& a, const std::string& b) {
  std::vector<size_t> before_last(b.size() + 1), last(b.size() + 1), row(b.size() + 1);
  for (size_t j = 0; j <= b.size(); ++j) last[j] = j;
  for (size_t i = 1; i <= a.size(); ++i) {
    row[0] = i;
    for (size_t j = 1; j <= b.size(); ++j) {
      const size_t replaced = last[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
      row[j] = std::min({last[j] + 1, row[j - 1] + 1, replaced});
      const bool exchanged = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
      if (exchanged) row[j] = std::min(row[j], before_last[j - 2] + 1);
    }
    std::swap(before_last, last);
    std::swap(last, row);
  }
  return last[b.size()];
}

std::optional<std::string> NearestName(const std::string& typed,
                                       const std::vector<std::string>& names) {
  const std::string folded = Folded(typed);
  size_t best = kLongest, second = kLongest;
  std::optional<std::string> out;
  for (const std::string& name : names) {
    const size_t distance = EditDistance(folded, Folded(name));
    if (distance < best) {
      second = best;
      best = distance;
      out = name;
    } else {
      second = std::min(second, distance);
    }
  }
  if (!out || best == second || 3 * best > std::max<size_t>(3, folded.size())) return std::nullopt;
  return out;
}

std::string DidYouMean(const std::string& typed, const std::vector<std::string>& names,
                       const std::string& prefix) {
  const auto nearest = NearestName(typed, names);
  return nearest ? ": did you mean " + prefix + *nearest + "?" : "";
}

}  // namespace tagtwist::internal

#include "frontend/io/tables/growing_stamps.h"

#include "frontend/base/number_text.h"

namespace tagtwist::internal {
namespace {

std::string CountText(size_t count, const char* one, const char* many) {
  return std::to_string(count) + (count == 1 ? one : many);
}

}  // namespace

Result<GrowingStamps> KeepGrowing(const std::vector<int64_t>& stamps_ns) {
  GrowingStamps out;
  for (size_t i = 0; i < stamps_ns.size(); ++i) {
    const bool first = out.kept.empty();
    if (first || stamps_ns[i] > stamps_ns[out.kept.back()]) {
      out.kept.push_back(i);
      continue;
    }
    if (out.All()) out.first_passed_over = i;
    (stamps_ns[i] == stamps_ns[out.kept.back()] ? out.repeated : out.backward) += 1;
  }
  if (stamps_ns.size() < 2 || 2 * out.kept.size() > stamps_ns.size()) return out;
  return Error{
      "stamp " + FormatSeconds(stamps_ns[out.first_passed_over]) +
      " s repeats or runs backwards, and so do others: no more than half is in order of time"};
}

std::string PassedOverText(const GrowingStamps& growing, const std::string& what,
                           const std::string& place) {
  return PassedOverText(growing, growing.kept.size(), what, place);
}

std::string PassedOverText(const GrowingStamps& growing, size_t kept, const std::string& what,
                           const std::string& place) {
  const size_t passed_over = growing.repeated + growing.backward;
  std::string out = "passed over " + std::to_string(passed_over) + " of " +
                    std::to_string(passed_over + kept) + " " + what + ": ";
  if (growing.repeated > 0) {
    out += CountText(growing.repeated, " stamp repeats", " stamps repeat");
  }
  if (growing.backward > 0) {
    if (growing.repeated > 0) out += ", ";
    out += CountText(growing.backward, " runs backwards", " run backwards");
  }
  return out + " (the first: " + place + ")";
}

}  // namespace tagtwist::internal

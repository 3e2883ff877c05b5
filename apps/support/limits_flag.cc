#include "apps/support/limits_flag.h"

#include <gflags/gflags.h>

#include <sstream>

#include "frontend/base/number_text.h"
#include "frontend/base/set_limit.h"

DEFINE_string(limits, "",
              "What the files that are read may ask for at most, as frame_pixels=4e8,file_bytes="
              "1e10, where the defaults refuse what you mean; SECURITY.md lists them.");

namespace tagtwist::internal {

Result<Limits> ParseLimits(const std::string& text) {
  Limits out;
  std::istringstream list(text);
  for (std::string item; std::getline(list, item, ',');) {
    const size_t equals = item.find('=');
    const auto value =
        equals == std::string::npos ? std::nullopt : ParseNumber(item.substr(equals + 1));
    if (!value) return Error{"--limits: expected KEY=NUMBER,..., got \"" + text + "\""};
    if (const Status set = SetLimit(item.substr(0, equals), *value, &out); !set) {
      return Error{"--limits: " + set.error().message};
    }
  }
  if (const auto problem = out.Problem()) return Error{"--limits: " + *problem};
  return out;
}

Result<Limits> LimitsFromFlag() { return ParseLimits(FLAGS_limits); }

}  // namespace tagtwist::internal

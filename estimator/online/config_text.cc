#include "estimator/online/config_text.h"

#include <type_traits>
#include <vector>

#include "frontend/base/named_enum.h"
#include "frontend/base/number_text.h"
#include "frontend/io/setup/tag_map_text.h"

namespace tagtwist::internal {
namespace {

// Visitor of an options struct: "  name: value" a field; a field that is not given is left out.
struct OptionLines {
  std::string text;
  template <typename T>
  void operator()(const char* name, const T& value) {
    if constexpr (std::is_same_v<T, std::string>) {
      Add(name, value);
    } else if constexpr (std::is_enum_v<T>) {
      Add(name, NameOf(value));
    } else if constexpr (std::is_same_v<T, bool>) {
      Add(name, value ? "true" : "false");
    } else if constexpr (std::is_integral_v<T>) {
      Add(name, std::to_string(value));
    } else if constexpr (std::is_floating_point_v<T>) {
      Add(name, FormatNumber(value));
    } else if (value) {
      (*this)(name, *value);
    }
  }
  void Add(const char* name, const std::string& value) {
    text += std::string("  ") + name + ": " + value + "\n";
  }
};

template <typename Options>
std::string SectionText(const char* section, const Options& options) {
  OptionLines lines;
  Options::VisitFields(options, lines);
  return std::string("\n") + section + ":\n" + lines.text;
}

}  // namespace

std::string OptionsText(const Config& config) {
  std::string out;
  if (!config.movable_tags.empty()) {
    const std::vector<double> ids(config.movable_tags.begin(), config.movable_tags.end());
    const auto n = static_cast<Eigen::Index>(ids.size());
    out += "\nmovable_tags: " + FormatNumberList(Eigen::VectorXd::Map(ids.data(), n)) + "\n";
  }
  out += SectionText("detector", config.front_end.detector);
  out += SectionText("klt", config.front_end.klt);
  out += SectionText("closed_form", config.front_end.closed_form);
  out += SectionText("estimator", config.estimator);
  return out + SectionText("calibration", config.calibration);
}

}  // namespace tagtwist::internal

#pragma once
#include <optional>
#include <string>

namespace tagtwist {

/// The names that an enum's values have in files and flags: a specialisation beside the enum holds
///   static constexpr std::array<std::pair<Enum, const char*>, N> kAll.
template <typename Enum>
struct EnumNames;

template <typename Enum>
const char* NameOf(Enum value) {
  for (const auto& [candidate, name] : EnumNames<Enum>::kAll) {
    if (candidate == value) return name;
  }
  return "";
}

/// nullopt where no value has that name.
template <typename Enum>
std::optional<Enum> ValueOf(const std::string& name) {
  for (const auto& [value, candidate] : EnumNames<Enum>::kAll) {
    if (name == candidate) return value;
  }
  return std::nullopt;
}

/// All names, for a message: "auto, stamps or steady".
template <typename Enum>
std::string NamesOf() {
  std::string out;
  const size_t size = EnumNames<Enum>::kAll.size();
  for (size_t i = 0; i < size; ++i) {
    if (i > 0) out += i + 1 < size ? ", " : " or ";
    out += EnumNames<Enum>::kAll[i].second;
  }
  return out;
}

}  // namespace tagtwist

#include "frontend/io/setup/yaml_value.h"

#include "frontend/base/printable.h"

namespace tagtwist::internal {

std::string PrintableYaml(const std::string& text) {
  constexpr size_t kMaxLength = 60;
  std::string out;
  for (const char c : text.substr(0, kMaxLength)) out += (c >= ' ' && c <= '~') ? c : '?';
  return text.size() > kMaxLength ? out + "..." : out;
}

const YamlValue* Member(const YamlValue& mapping, const std::string& name) {
  for (const auto& [key, value] : mapping.members) {
    if (key == name) return &value;
  }
  return nullptr;
}

std::string YamlValue::Describe() const {
  switch (kind) {
    case Kind::kNothing:
      return "nothing";
    case Kind::kScalar:
      return quoted ? "the text \"" + PrintableYaml(scalar) + "\"" : PrintableYaml(scalar);
    case Kind::kList:
      return "a list of " + std::to_string(items.size());
    case Kind::kMapping:
      return "a mapping";
  }
  return "";
}

Error YamlValue::Refuse(const std::string& expected) const {
  std::string message = file + ":" + std::to_string(line) + ": ";
  if (!key.empty()) message += key + ": ";
  message += "expected " + Printable(expected);
  if (expected.find(", got ") == std::string::npos) message += ", got " + Describe();
  return Error{message};
}

}  // namespace tagtwist::internal

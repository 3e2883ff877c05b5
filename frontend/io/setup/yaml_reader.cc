#include "frontend/io/setup/yaml_reader.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <system_error>

#include "frontend/base/files/input_file.h"
#include "frontend/base/nearest_name.h"
#include "frontend/base/printable.h"
#include "frontend/io/setup/yaml_tree.h"

namespace tagtwist::internal {
namespace {

template <typename Number>
bool ParseWhole(const std::string& text, Number* value) {
  const char* begin = text.data();
  const char* end = begin + text.size();
  if (end - begin > 1 && *begin == '+' && begin[1] != '-') ++begin;
  const auto [stop, error] = std::from_chars(begin, end, *value);
  return error == std::errc() && stop == end;
}

bool IsPlain(const YamlValue& node) {
  return node.kind == YamlValue::Kind::kScalar && !node.quoted;
}

}  // namespace

Result<YamlValue> ReadYaml(const std::string& path, const Limits& limits) {
  auto text = ReadTextFile(path, limits);
  if (!text) return text.error();
  return ParseYaml(std::move(*text), path, limits);
}

Status ReadValue(const YamlValue& node, double* value) {
  double number = 0;
  if (!IsPlain(node) || !ParseWhole(node.scalar, &number) || !std::isfinite(number)) {
    const bool comma = IsPlain(node) && node.scalar.find(',') != std::string::npos;
    return node.Refuse(comma ? "a finite number with a decimal point" : "a finite number");
  }
  *value = number;
  return Ok();
}

template <typename Integer>
Status ReadInteger(const YamlValue& node, Integer* value) {
  Integer number = 0;
  if (!IsPlain(node) || !ParseWhole(node.scalar, &number)) {
    return node.Refuse(std::is_signed_v<Integer> ? "a whole number" : "a whole number >= 0");
  }
  *value = number;
  return Ok();
}
template Status ReadInteger(const YamlValue& node, int32_t* value);
template Status ReadInteger(const YamlValue& node, uint32_t* value);
template Status ReadInteger(const YamlValue& node, int64_t* value);
template Status ReadInteger(const YamlValue& node, uint64_t* value);

Status ReadValue(const YamlValue& node, int* value) { return ReadInteger(node, value); }

Status ReadValue(const YamlValue& node, bool* value) {
  if (!IsPlain(node) || (node.scalar != "true" && node.scalar != "false")) {
    return node.Refuse("true or false");
  }
  *value = node.scalar == "true";
  return Ok();
}

Status ReadValue(const YamlValue& node, std::string* value) {
  if (node.kind != YamlValue::Kind::kScalar) return node.Refuse("a text");
  *value = node.scalar;
  return Ok();
}

Status ReadNumbers(const YamlValue& node, size_t size, std::vector<double>* numbers) {
  if (node.kind != YamlValue::Kind::kList || (size != 0 && node.items.size() != size)) {
    return node.Refuse(size == 0 ? "a list of numbers"
                                 : "a list of " + std::to_string(size) + " numbers");
  }
  numbers->assign(node.items.size(), 0.0);
  for (size_t i = 0; i < node.items.size(); ++i) {
    if (Status status = ReadValue(node.items[i], &(*numbers)[i]); !status) return status;
  }
  return Ok();
}

YamlSection::YamlSection(const YamlValue& mapping) : mapping_(mapping) {
  if (mapping.kind != YamlValue::Kind::kMapping) Keep(mapping.Refuse("a mapping"));
}

const YamlValue* YamlSection::Find(const std::string& name) {
  if (std::find(known_.begin(), known_.end(), name) == known_.end()) known_.push_back(name);
  for (const auto& [key, value] : mapping_.members) {
    if (key == name) return &value;
  }
  return nullptr;
}

const YamlValue* YamlSection::Require(const std::string& name) {
  const YamlValue* node = Find(name);
  if (node == nullptr && mapping_.kind == YamlValue::Kind::kMapping) {
    YamlValue place = mapping_;
    place.key = (mapping_.key.empty() ? "" : mapping_.key + ".") + name;
    Keep(place.Refuse("a value, got none"));
  }
  return node;
}

void YamlSection::Keep(const Status& status) {
  if (!status && !fault_) fault_ = status.error();
}

void YamlSection::KeepProblem(const std::optional<std::string>& problem) {
  if (!problem) return;
  YamlValue place = mapping_;
  for (const auto& [name, value] : mapping_.members) {
    if (problem->compare(0, name.size() + 1, name + ":") == 0) place = value;
  }
  const std::string& prefix = mapping_.key;
  const bool has_name = problem->compare(0, 9, "expected ") != 0;
  const std::string separator = prefix.empty() ? "" : has_name ? "." : ": ";
  Keep(Error{place.file + ":" + std::to_string(place.line) + ": " + prefix + separator +
             Printable(*problem)});
}

Status YamlSection::Finish() {
  std::string names;
  for (const std::string& name : known_) names += (names.empty() ? "" : ", ") + name;
  // An unknown key comes first: a misspelt key also leaves a needed one missing.
  for (const auto& [name, value] : mapping_.members) {
    if (std::find(known_.begin(), known_.end(), name) == known_.end()) {
      return value.Refuse("one of " + names + ", got an unknown key" + DidYouMean(name, known_));
    }
  }
  return FirstFault();
}

Status YamlSection::FirstFault() const {
  if (fault_) return *fault_;
  return Ok();
}

Status ReadMatrix(const YamlValue& node, std::vector<double>* numbers) {
  if (node.kind == YamlValue::Kind::kMapping) {
    YamlSection section(node);
    const YamlValue* data = section.Require(std::string("data"));
    if (data == nullptr) return section.FirstFault();
    return ReadNumbers(*data, 0, numbers);
  }
  if (node.kind != YamlValue::Kind::kList || node.items.empty() ||
      node.items[0].kind != YamlValue::Kind::kList) {
    return ReadNumbers(node, 0, numbers);
  }
  numbers->clear();
  for (const YamlValue& row : node.items) {
    std::vector<double> of_row;
    if (Status status = ReadNumbers(row, 0, &of_row); !status) return status;
    numbers->insert(numbers->end(), of_row.begin(), of_row.end());
  }
  return Ok();
}

}  // namespace tagtwist::internal

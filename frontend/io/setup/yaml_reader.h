#pragma once
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "frontend/base/limits.h"
#include "frontend/base/named_enum.h"
#include "frontend/base/result.h"
#include "frontend/io/setup/yaml_value.h"

namespace tagtwist::internal {

/// The single document of a YAML file, see ParseYaml. Refused: a file that cannot be read, is empty
/// or larger than limits.text_bytes.
Result<YamlValue> ReadYaml(const std::string& path, const Limits& limits = {});

/// Values of one type; refused with the type that was expected. Numbers must be finite.
Status ReadValue(const YamlValue& node, double* value);
Status ReadValue(const YamlValue& node, int* value);
Status ReadValue(const YamlValue& node, bool* value);
Status ReadValue(const YamlValue& node, std::string* value);
/// A list of exactly `size` numbers, or of any number of them when size is 0.
Status ReadNumbers(const YamlValue& node, size_t size, std::vector<double>* numbers);
/// Numbers of a list, of a list of rows, or of a mapping {rows, cols, data}.
Status ReadMatrix(const YamlValue& node, std::vector<double>* numbers);
/// A whole number (32 or 64 bits, with sign or without).
template <typename Integer>
Status ReadInteger(const YamlValue& node, Integer* value);

/// Reads a mapping strictly: every member must be asked for, and Finish() tells an unknown member
/// or else the first fault. A member that is absent leaves its value alone, the default.
class YamlSection {
 public:
  explicit YamlSection(const YamlValue& mapping);

  /// The member of that name, or nullptr; it counts as known from here on.
  const YamlValue* Find(const std::string& name);
  /// Same, and its absence is a fault.
  const YamlValue* Require(const std::string& name);

  /// Visitor of an options struct: reads the member `name` into `value`.
  template <typename T>
  void operator()(const char* name, T& value) {
    if (const YamlValue* node = Find(name); node != nullptr) Keep(ReadField(*node, value));
  }
  template <typename T>
  void Require(const char* name, T* value) {
    if (const YamlValue* node = Require(std::string(name)); node != nullptr) {
      Keep(ReadField(*node, *value));
    }
  }

  const std::string& file() const { return mapping_.file; }

  /// Keeps the fault, if it is the first.
  void Keep(const Status& status);
  /// Keeps "name: expected ..., got ..." (what an options struct's Problem() says) with the line of
  /// the member it names.
  void KeepProblem(const std::optional<std::string>& problem);
  /// The fault, or Ok. Call it after everything was asked for.
  Status Finish();
  /// Finish for files of others, in which unknown members are none of our business.
  Status FirstFault() const;

 private:
  template <typename T>
  static Status ReadField(const YamlValue& node, T& value) {
    if constexpr (std::is_same_v<T, double> || std::is_same_v<T, int> || std::is_same_v<T, bool> ||
                  std::is_same_v<T, std::string>) {
      return ReadValue(node, &value);
    } else if constexpr (std::is_integral_v<T>) {
      return ReadInteger(node, &value);
    } else if constexpr (std::is_enum_v<T>) {
      const auto named = ValueOf<T>(node.scalar);
      if (node.kind != YamlValue::Kind::kScalar || !named) return node.Refuse(NamesOf<T>());
      value = *named;
      return Ok();
    } else {  // std::optional
      typename T::value_type inner{};
      Status status = ReadField(node, inner);
      if (status) value = inner;
      return status;
    }
  }

  const YamlValue& mapping_;
  std::vector<std::string> known_;
  std::optional<Error> fault_;
};

}  // namespace tagtwist::internal

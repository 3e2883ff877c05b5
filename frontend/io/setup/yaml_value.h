#pragma once
#include <string>
#include <utility>
#include <vector>

#include "frontend/base/result.h"

namespace tagtwist::internal {

/// A node of a YAML file with the place it came from. A tree of values: whoever reads it needs no
/// YAML library.
struct YamlValue {
  enum class Kind { kNothing, kScalar, kList, kMapping };
  Kind kind = Kind::kNothing;
  std::string file;                                        // as given to ReadYaml
  int line = 1;                                            // counted from 1
  std::string key;                                         // "tag_map.tags[3].id"; "" for the root
  std::string scalar;                                      // kScalar: its text
  bool quoted = false;                                     // kScalar: "5" is a text, 5 a number
  std::vector<YamlValue> items;                            // kList
  std::vector<std::pair<std::string, YamlValue>> members;  // kMapping, in the order of the file

  /// "file:line: key: expected ..., got ...".
  Error Refuse(const std::string& expected) const;
  /// What it is, for a message: its text, cut short, or "a list", "a mapping", "nothing".
  std::string Describe() const;
};

/// A mapping's member of that name, or nullptr.
const YamlValue* Member(const YamlValue& mapping, const std::string& name);

/// One line of plain text of at most 60 characters, whatever the bytes are.
std::string PrintableYaml(const std::string& text);

}  // namespace tagtwist::internal

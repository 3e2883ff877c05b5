#include "frontend/io/setup/yaml_reader.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <system_error>

namespace tagtwist {
namespace {

constexpr size_t kMaxNodes = 200000;  // aliases can make a short file endless

// One line of plain text, whatever the bytes are.
std::string Printable(const std::string& text) {
  constexpr size_t kMaxLength = 60;
  std::string out;
  for (const char c : text.substr(0, kMaxLength)) out += (c >= ' ' && c <= '~') ? c : '?';
  return text.size() > kMaxLength ? out + "..." : out;
}

// Copies a yaml-cpp tree; each fault carries its line.
class TreeCopier {
 public:
  explicit TreeCopier(std::string file) : file_(std::move(file)) {}

  Result<YamlValue> Copy(const YAML::Node& node, const std::string& key) {
    YamlValue out;
    out.file = file_;
    out.line = node.Mark().line + 1;
    out.key = key;
    if (++nodes_ > kMaxNodes) return out.Refuse("a smaller file");
    if (node.IsScalar()) {
      out.kind = YamlValue::Kind::kScalar;
      out.scalar = node.Scalar();
      out.quoted = node.Tag() == "!";
    } else if (node.IsSequence()) {
      return CopyList(node, std::move(out));
    } else if (node.IsMap()) {
      return CopyMapping(node, std::move(out));
    }
    return out;
  }

 private:
  Result<YamlValue> CopyList(const YAML::Node& node, YamlValue out) {
    out.kind = YamlValue::Kind::kList;
    for (size_t i = 0; i < node.size(); ++i) {
      Result<YamlValue> item = Copy(node[i], out.key + "[" + std::to_string(i) + "]");
      if (!item) return item;
      out.items.push_back(std::move(*item));
    }
    return out;
  }

  // yaml-cpp keeps repeated keys silently and hands out the first one.
  Result<YamlValue> CopyMapping(const YAML::Node& node, YamlValue out) {
    out.kind = YamlValue::Kind::kMapping;
    for (const auto& pair : node) {
      YamlValue place;
      place.file = file_;
      place.line = pair.first.Mark().line + 1;
      if (!pair.first.IsScalar()) return place.Refuse("a plain key");
      const std::string name = pair.first.Scalar();
      const std::string key = out.key.empty() ? Printable(name) : out.key + "." + Printable(name);
      place.key = key;
      for (const auto& [other, value] : out.members) {
        if (other == name) {
          return place.Refuse("the key once, got it again (first on line " +
                              std::to_string(value.line) + ")");
        }
      }
      Result<YamlValue> member = Copy(pair.second, key);
      if (!member) return member;
      member->line = place.line;
      out.members.emplace_back(name, std::move(*member));
    }
    return out;
  }

  std::string file_;
  size_t nodes_ = 0;
};

Result<std::string> ReadText(const std::string& path) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored))
    return Error{path + ": expected a file, got a folder"};
  std::ifstream in(path, std::ios::binary);
  if (!in) return Error{path + ": cannot open"};
  std::ostringstream text;
  text << in.rdbuf();
  if (in.bad() || text.str().empty()) return Error{path + ": expected YAML, got an empty file"};
  return text.str();
}

template <typename Number>
bool ParseWhole(const std::string& text, Number* value) {
  const char* begin = text.data();
  const char* end = begin + text.size();
  if (begin != end && *begin == '+') ++begin;
  const auto [stop, error] = std::from_chars(begin, end, *value);
  return error == std::errc() && stop == end;
}

bool IsPlain(const YamlValue& node) {
  return node.kind == YamlValue::Kind::kScalar && !node.quoted;
}

}  // namespace

std::string YamlValue::Describe() const {
  switch (kind) {
    case Kind::kNothing:
      return "nothing";
    case Kind::kScalar:
      return quoted ? "the text \"" + Printable(scalar) + "\"" : Printable(scalar);
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
  message += "expected " + expected;
  if (expected.find(", got ") == std::string::npos) message += ", got " + Describe();
  return Error{message};
}

Result<YamlValue> ReadYaml(const std::string& path) {
  Result<std::string> text = ReadText(path);
  if (!text) return text.error();
  if (text->compare(0, 6, "%YAML:") == 0) (*text)[0] = '#';
  try {
    const std::vector<YAML::Node> documents = YAML::LoadAll(*text);
    if (documents.size() != 1) {
      return Error{path + ": expected one YAML document, got " + std::to_string(documents.size())};
    }
    return TreeCopier(path).Copy(documents[0], "");
  } catch (const YAML::Exception& e) {
    return Error{path + ":" + std::to_string(e.mark.line + 1) +
                 ": not valid YAML: " + Printable(e.msg)};
  } catch (const std::exception& e) {
    return Error{path + ": not valid YAML: " + Printable(e.what())};
  }
}

Status ReadValue(const YamlValue& node, double* value) {
  double number = 0;
  if (!IsPlain(node) || !ParseWhole(node.scalar, &number) || !std::isfinite(number)) {
    return node.Refuse("a finite number");
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
  Keep(Error{place.file + ":" + std::to_string(place.line) + ": " + prefix + separator + *problem});
}

Status YamlSection::Finish() {
  std::string names;
  for (const std::string& name : known_) names += (names.empty() ? "" : ", ") + name;
  // An unknown key comes first: a misspelt key also leaves a needed one missing.
  for (const auto& [name, value] : mapping_.members) {
    if (std::find(known_.begin(), known_.end(), name) == known_.end()) {
      return value.Refuse("one of " + names + ", got an unknown key");
    }
  }
  return FirstFault();
}

Status YamlSection::FirstFault() const {
  if (fault_) return *fault_;
  return Ok();
}

}  // namespace tagtwist

#include "frontend/io/setup/yaml_tree.h"

#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/yaml.h>

#include <map>
#include <new>
#include <optional>
#include <sstream>
#include <utility>

namespace tagtwist::internal {
namespace {

// Ends the parsing where the tree cannot be.
struct Refusal {
  Error error;
};

// Builds the tree from the parser's events. The parser's own tree would be built whole before it
// could be counted, and may be a circle.
class TreeBuilder : public YAML::EventHandler {
 public:
  TreeBuilder(std::string file, const Limits& limits) : file_(std::move(file)), limits_(limits) {}

  int documents() const { return documents_; }
  Result<YamlValue> TakeRoot() {
    if (fault_) return *fault_;
    return std::move(root_);
  }

  void OnDocumentStart(const YAML::Mark&) override {
    after_root_ = ++documents_ > 1;
    if (documents_ > 2) throw Refusal{{file_ + ": expected one YAML document, got 2 or more"}};
  }
  void OnDocumentEnd() override {}

  // What stands behind a closing --- is an empty document.
  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    if (after_root_ && open_.empty()) return;
    Take(Begin(mark), anchor);
  }
  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                const std::string& text) override {
    YamlValue value = Begin(mark);
    value.kind = YamlValue::Kind::kScalar;
    value.scalar = text;
    value.quoted = tag == "!";
    Take(std::move(value), anchor);
  }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    YamlValue place = Begin(mark);
    const auto found = anchored_.find(anchor);
    if (found == anchored_.end()) {
      throw Refusal{place.Refuse("a value that ends, got an alias of what it is in")};
    }
    YamlValue copy = Copy(found->second, place.key, open_.size());
    copy.line = place.line;
    Take(std::move(copy), 0);
  }

  void OnSequenceStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t anchor,
                       YAML::EmitterStyle::value) override {
    Open(mark, anchor, YamlValue::Kind::kList);
  }
  void OnSequenceEnd() override { Close(); }
  void OnMapStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t anchor,
                  YAML::EmitterStyle::value) override {
    Open(mark, anchor, YamlValue::Kind::kMapping);
  }
  void OnMapEnd() override { Close(); }

 private:
  // A list or a mapping that is not at its end yet.
  struct Level {
    YamlValue value;
    YAML::anchor_t anchor = 0;
    std::optional<std::string> name;  // of the member that comes next
    int name_line = 1;
    std::map<std::string, int> lines;  // of the names so far
  };

  bool ExpectsName() const {
    return !open_.empty() && open_.back().value.kind == YamlValue::Kind::kMapping &&
           !open_.back().name;
  }

  // Where the next node belongs: "tag_map.tags[3]".
  std::string NextKey() const {
    if (open_.empty()) return "";
    const Level& level = open_.back();
    if (level.value.kind == YamlValue::Kind::kList) {
      return level.value.key + "[" + std::to_string(level.value.items.size()) + "]";
    }
    if (!level.name) return level.value.key;
    const std::string name = PrintableYaml(*level.name);
    return level.value.key.empty() ? name : level.value.key + "." + name;
  }

  YamlValue Begin(const YAML::Mark& mark) const {
    if (after_root_) throw Refusal{{file_ + ": expected one YAML document, got 2 or more"}};
    YamlValue out;
    out.file = file_;
    out.line = mark.line + 1;
    out.key = NextKey();
    return out;
  }

  void Open(const YAML::Mark& mark, YAML::anchor_t anchor, YamlValue::Kind kind) {
    Level level;
    level.value = Begin(mark);
    level.value.kind = kind;
    level.anchor = anchor;
    Charge(level.value, open_.size() + 1);
    open_.push_back(std::move(level));
  }

  void Close() {
    Level level = std::move(open_.back());
    open_.pop_back();
    Deliver(std::move(level.value), level.anchor);
  }

  void Take(YamlValue value, YAML::anchor_t anchor) {
    Charge(value, open_.size());
    Deliver(std::move(value), anchor);
  }

  // A fault here is told at the end only: what is no YAML at all is told as such.
  void TakeName(YamlValue name) {
    Level& level = open_.back();
    if (name.kind != YamlValue::Kind::kScalar && !fault_) fault_ = name.Refuse("a plain key");
    level.name = name.scalar;
    level.name_line = name.line;
    name.key = NextKey();
    const auto [first, is_new] = level.lines.emplace(name.scalar, name.line);
    if (is_new || fault_) return;
    fault_ = name.Refuse("the key once, got it again (first on line " +
                         std::to_string(first->second) + ")");
  }

  void Deliver(YamlValue value, YAML::anchor_t anchor) {
    if (anchor != 0) anchored_[anchor] = Copy(value, value.key, open_.size());
    if (ExpectsName()) return TakeName(std::move(value));
    if (open_.empty()) {
      root_ = std::move(value);
      return;
    }
    Level& level = open_.back();
    if (level.value.kind == YamlValue::Kind::kList) {
      level.value.items.push_back(std::move(value));
      return;
    }
    value.line = level.name_line;
    level.value.members.emplace_back(std::move(*level.name), std::move(value));
    level.name.reset();
  }

  // The same at another place, charged like what was written out.
  YamlValue Copy(const YamlValue& value, const std::string& key, size_t level) {
    YamlValue out;
    out.kind = value.kind;
    out.file = value.file;
    out.line = value.line;
    out.key = key;
    out.scalar = value.scalar;
    out.quoted = value.quoted;
    Charge(out, level);
    for (size_t i = 0; i < value.items.size(); ++i) {
      out.items.push_back(Copy(value.items[i], key + "[" + std::to_string(i) + "]", level + 1));
    }
    for (const auto& [name, member] : value.members) {
      const std::string of_member =
          key.empty() ? PrintableYaml(name) : key + "." + PrintableYaml(name);
      out.members.emplace_back(name, Copy(member, of_member, level + 1));
    }
    return out;
  }

  void Charge(const YamlValue& value, size_t level) {
    bytes_ += static_cast<int64_t>(value.key.size() + value.scalar.size() + value.file.size());
    const bool crowded = ++nodes_ > limits_.nodes;
    if (crowded || bytes_ > limits_.key_bytes) {
      throw Refusal{value.Refuse("a smaller file" + RaisesLimit(crowded ? "nodes" : "key_bytes"))};
    }
    if (static_cast<int64_t>(level) > limits_.depth) {
      throw Refusal{value.Refuse("at most " + std::to_string(limits_.depth) + " levels, got more" +
                                 RaisesLimit("depth"))};
    }
  }

  std::string file_;
  YamlValue root_;
  std::vector<Level> open_;
  std::map<YAML::anchor_t, YamlValue> anchored_;
  std::optional<Error> fault_;
  int documents_ = 0;
  bool after_root_ = false;
  Limits limits_;
  int64_t nodes_ = 0, bytes_ = 0;
};

}  // namespace

Result<YamlValue> ParseYaml(std::string text, const std::string& file, const Limits& limits) {
  if (text.empty()) return Error{file + ": expected YAML, got an empty file"};
  if (text.compare(0, 6, "%YAML:") == 0) text[0] = '#';
  try {
    std::istringstream in(text);
    YAML::Parser parser(in);
    TreeBuilder builder(file, limits);
    while (parser.HandleNextDocument(builder)) {
    }
    if (builder.documents() == 0) return Error{file + ": expected one YAML document, got 0"};
    return builder.TakeRoot();
  } catch (const Refusal& refusal) {
    return refusal.error;
  } catch (const YAML::Exception& e) {
    return Error{file + ":" + std::to_string(e.mark.line + 1) +
                 ": not valid YAML: " + PrintableYaml(e.msg)};
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& e) {
    return Error{file + ": not valid YAML: " + PrintableYaml(e.what())};
  }
}

}  // namespace tagtwist::internal

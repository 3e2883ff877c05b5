#include "frontend/io/setup/opencv_xml.h"

#include <tinyxml2.h>

#include <sstream>
#include <utility>

namespace tagtwist::internal {
namespace {

// Copies a document's tree until a bound is met. The XML parser bounds the depth.
class TreeCopier {
 public:
  TreeCopier(std::string file, const Limits& limits) : file_(std::move(file)), limits_(limits) {}
  bool is_full() const { return nodes_ > limits_.nodes || bytes_ > limits_.key_bytes; }

  YamlValue Copy(const tinyxml2::XMLElement& element, const std::string& key) {
    YamlValue out = At(element, key);
    const tinyxml2::XMLElement* child = element.FirstChildElement();
    if (child == nullptr) CopyText(element.GetText(), &out);
    for (; child != nullptr && !is_full(); child = child->NextSiblingElement()) {
      const std::string name = child->Name();
      if (name == "_") {
        out.kind = YamlValue::Kind::kList;
        const std::string path = key + "[" + std::to_string(out.items.size()) + "]";
        out.items.push_back(Copy(*child, path));
      } else {
        out.kind = YamlValue::Kind::kMapping;
        out.members.emplace_back(name, Copy(*child, key.empty() ? name : key + "." + name));
      }
    }
    return out;
  }

 private:
  YamlValue At(const tinyxml2::XMLElement& element, const std::string& key) {
    YamlValue out;
    out.file = file_;
    out.line = element.GetLineNum();
    out.key = key;
    Charge(out);
    return out;
  }

  void Charge(const YamlValue& value) {
    ++nodes_;
    bytes_ += static_cast<int64_t>(value.file.size() + value.key.size() + value.scalar.size());
  }

  // One word is a scalar, several are a list; words in quotes are texts.
  void CopyText(const char* text, YamlValue* out) {
    if (text == nullptr) return;
    std::istringstream words(text);
    YamlValue item = *out;
    item.kind = YamlValue::Kind::kScalar;
    while (!is_full() && words >> item.scalar) {
      item.quoted = item.scalar.front() == '"';
      out->items.push_back(item);
      Charge(item);
    }
    if (out->items.size() == 1) {
      *out = std::move(item);
      out->scalar = text;
      out->scalar.erase(0, out->scalar.find_first_not_of(" \t\r\n"));
      out->scalar.erase(out->scalar.find_last_not_of(" \t\r\n") + 1);
      out->items.clear();
    } else if (!out->items.empty()) {
      out->kind = YamlValue::Kind::kList;
    }
  }

  std::string file_;
  Limits limits_;
  int64_t nodes_ = 0, bytes_ = 0;
};

}  // namespace

bool LooksLikeXml(const std::string& text) {
  const size_t first = text.find_first_not_of(" \t\r\n");
  return first != std::string::npos && text[first] == '<';
}

Result<YamlValue> ParseOpenCvXml(const std::string& text, const std::string& file,
                                 const Limits& limits) {
  tinyxml2::XMLDocument document;
  if (document.Parse(text.data(), text.size()) != tinyxml2::XML_SUCCESS) {
    return Error{file + ":" + std::to_string(document.ErrorLineNum()) + ": not valid XML"};
  }
  const tinyxml2::XMLElement* root = document.RootElement();
  if (root == nullptr || std::string(root->Name()) != "opencv_storage") {
    return Error{file + ": expected <opencv_storage>, got other XML"};
  }
  TreeCopier copier(file, limits);
  YamlValue out = copier.Copy(*root, "");
  if (copier.is_full()) return Error{file + ": expected a smaller file" + RaisesLimit("nodes")};
  return out;
}

}  // namespace tagtwist::internal

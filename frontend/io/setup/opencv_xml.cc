#include "frontend/io/setup/opencv_xml.h"

#include <tinyxml2.h>

#include <fstream>
#include <sstream>

#include "frontend/base/atomic_file.h"

namespace tagtwist {
namespace {

YamlValue At(const tinyxml2::XMLElement& element, const std::string& file, const std::string& key) {
  YamlValue out;
  out.file = file;
  out.line = element.GetLineNum();
  out.key = key;
  return out;
}

// One word is a scalar, several are a list; words in quotes are texts.
void CopyText(const char* text, YamlValue* out) {
  if (text == nullptr) return;
  std::istringstream words(text);
  YamlValue item = *out;
  item.kind = YamlValue::Kind::kScalar;
  while (words >> item.scalar) {
    item.quoted = item.scalar.front() == '"';
    out->items.push_back(item);
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

// The reader below bounds the depth.
YamlValue Copy(const tinyxml2::XMLElement& element, const std::string& file,
               const std::string& key) {
  YamlValue out = At(element, file, key);
  const tinyxml2::XMLElement* child = element.FirstChildElement();
  if (child == nullptr) CopyText(element.GetText(), &out);
  for (; child != nullptr; child = child->NextSiblingElement()) {
    const std::string name = child->Name();
    if (name == "_") {
      out.kind = YamlValue::Kind::kList;
      const std::string path = key + "[" + std::to_string(out.items.size()) + "]";
      out.items.push_back(Copy(*child, file, path));
    } else {
      out.kind = YamlValue::Kind::kMapping;
      out.members.emplace_back(name, Copy(*child, file, key.empty() ? name : key + "." + name));
    }
  }
  return out;
}

}  // namespace

bool IsXml(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  char first = 0;
  return in >> first && first == '<';
}

Result<YamlValue> ReadOpenCvXml(const std::string& path) {
  const auto bytes = ReadWholeFile(path);
  if (!bytes) return bytes.error();
  tinyxml2::XMLDocument document;
  if (document.Parse(bytes->data(), bytes->size()) != tinyxml2::XML_SUCCESS) {
    return Error{path + ":" + std::to_string(document.ErrorLineNum()) + ": not valid XML"};
  }
  const tinyxml2::XMLElement* root = document.RootElement();
  if (root == nullptr || std::string(root->Name()) != "opencv_storage") {
    return Error{path + ": expected <opencv_storage>, got other XML"};
  }
  return Copy(*root, path, "");
}

}  // namespace tagtwist

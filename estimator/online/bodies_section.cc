#include "estimator/online/bodies_section.h"

#include <algorithm>
#include <string>
#include <utility>

#include "estimator/online/map_section.h"
#include "frontend/base/files/plain_name.h"
#include "frontend/io/setup/yaml_reader.h"

namespace tagtwist::internal {
namespace {

// Files are called after it, beside those that every run has.
bool IsName(const std::string& name) { return IsPlainName(name) && name != "lagged"; }

YamlValue Without(const std::string& name, const YamlValue& mapping) {
  YamlValue out = mapping;
  const auto is_it = [&](const auto& member) { return member.first == name; };
  out.members.erase(std::remove_if(out.members.begin(), out.members.end(), is_it),
                    out.members.end());
  return out;
}

// The body's own map: what is left of its entry, with the family of all.
YamlValue MapNodeOf(const YamlValue& entry, const YamlValue* family) {
  YamlValue out = Without("name", entry);
  if (family != nullptr && Member(entry, "family") == nullptr) {
    out.members.emplace_back("family", *family);
  }
  return out;
}

Result<TaggedBody> ReadBody(const YamlValue& entry, const YamlValue* family, const Limits& limits,
                            std::optional<double>* sigma_m) {
  if (entry.kind != YamlValue::Kind::kMapping) return entry.Refuse("a body's keys");
  const YamlValue* name = Member(entry, "name");
  if (name == nullptr) return entry.Refuse("name, got none");
  TaggedBody out;
  if (const Status read = ReadValue(*name, &out.name); !read) return read.error();
  if (!IsName(out.name)) {
    return name->Refuse("letters, digits, - and _ (not \"lagged\"), got \"" +
                        PrintableYaml(out.name) + "\"");
  }
  std::optional<double> own;
  auto map = ReadMapSection(MapNodeOf(entry, family), limits, &own);
  if (!map) return map.error();
  out.map = std::move(*map);
  *sigma_m = std::max(*sigma_m, own);
  return out;
}

}  // namespace

bool HasOwnTags(const YamlValue& node) {
  return Member(node, "grid") != nullptr || Member(node, "tags") != nullptr ||
         Member(node, "file") != nullptr;
}

YamlValue WithoutBodies(const YamlValue& node) { return Without("bodies", node); }

Result<std::vector<TaggedBody>> ReadBodies(const YamlValue& node, const Limits& limits,
                                           std::optional<double>* sigma_m) {
  const YamlValue* family = Member(node, "family");
  const YamlValue* bodies = Member(node, "bodies");
  if (bodies->kind != YamlValue::Kind::kList || bodies->items.empty()) {
    return bodies->Refuse("a list of bodies");
  }
  std::vector<TaggedBody> out;
  for (const YamlValue& entry : bodies->items) {
    auto body = ReadBody(entry, family, limits, sigma_m);
    if (!body) return body.error();
    for (const TaggedBody& other : out) {
      if (other.name == body->name) {
        return Member(entry, "name")->Refuse("a name that no other body has");
      }
    }
    if (const auto fine = CheckOnce(entry, body->map, out); !fine) return fine.error();
    out.push_back(std::move(*body));
  }
  return out;
}

Status CheckOnce(const YamlValue& node, const TagMap& map, const std::vector<TaggedBody>& bodies) {
  for (const TaggedBody& other : bodies) {
    if (other.map.family() != map.family()) {
      return node.Refuse("one family, got " + map.family() + " and " + other.map.family() + " of " +
                         other.name);
    }
    for (const Tag& tag : map.tags()) {
      if (other.map.Find(tag.id) == nullptr) continue;
      return node.Refuse("each id once, got " + std::to_string(tag.id) + " of " + other.name +
                         " again");
    }
  }
  return Ok();
}

}  // namespace tagtwist::internal

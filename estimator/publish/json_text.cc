#include "estimator/publish/json_text.h"

#include <array>
#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>

namespace tagtwist::internal {

void JsonText::Separate() {
  if (text_.empty()) return;
  const char last = text_.back();
  if (last != '{' && last != '[' && last != ':') text_ += ',';
}

JsonText& JsonText::Raw(std::string_view json) {
  Separate();
  text_ += json;
  return *this;
}

JsonText& JsonText::Open(char bracket) { return Raw({&bracket, 1}); }

JsonText& JsonText::Close(char bracket) {
  text_ += bracket;
  return *this;
}

JsonText& JsonText::Key(std::string_view name) {
  String(name);
  text_ += ':';
  return *this;
}

JsonText& JsonText::Number(double value, int digits) {
  if (!std::isfinite(value)) return Null();
  std::array<char, 40> text;
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value,
                                 std::chars_format::general, digits);
  return Raw({text.data(), static_cast<size_t>(end.ptr - text.data())});
}

JsonText& JsonText::Integer(int64_t value) { return Raw(std::to_string(value)); }

JsonText& JsonText::Truth(bool value) { return Raw(value ? "true" : "false"); }

JsonText& JsonText::Null() { return Raw("null"); }

JsonText& JsonText::String(std::string_view text) {
  std::string out;
  for (const char c :
       nlohmann::json(std::string(text))
           .dump(-1, ' ', /*ensure_ascii=*/true, nlohmann::json::error_handler_t::replace)) {
    out += c == '<' ? std::string("\\u003c") : std::string(1, c);
  }
  return Raw(out);
}

}  // namespace tagtwist::internal

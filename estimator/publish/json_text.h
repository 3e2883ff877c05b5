#pragma once
#include <cstdint>
#include <string>
#include <string_view>

namespace tagtwist::internal {

/// A JSON text from front to end; commas come by themselves. Nothing that could end a script
/// element is in it.
class JsonText {
 public:
  JsonText& Open(char bracket);   // '{' or '['
  JsonText& Close(char bracket);  // '}' or ']'
  JsonText& Key(std::string_view name);
  /// The number in so many significant digits, as states.csv has it; null where it is not finite.
  JsonText& Number(double value, int digits);
  JsonText& Integer(int64_t value);
  JsonText& Truth(bool value);
  JsonText& Null();
  JsonText& String(std::string_view text);
  /// An array of numbers: whatever has size() and an index.
  template <typename Values>
  JsonText& Numbers(const Values& values, int digits) {
    Open('[');
    for (decltype(values.size()) i = 0; i < values.size(); ++i) Number(values[i], digits);
    return Close(']');
  }
  /// What is JSON already.
  JsonText& Raw(std::string_view json);

  const std::string& text() const { return text_; }

 private:
  void Separate();
  std::string text_;
};

}  // namespace tagtwist::internal

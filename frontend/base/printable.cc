#include "frontend/base/printable.h"

namespace tagtwist::internal {

std::string Printable(std::string_view text) {
  std::string out;
  out.reserve(text.size());
  for (size_t i = 0; i < text.size(); ++i) {
    const auto byte = static_cast<unsigned char>(text[i]);
    const auto next = static_cast<unsigned char>(i + 1 < text.size() ? text[i + 1] : 0);
    const bool of_latin_1 = byte == 0xC2 && next >= 0x80 && next < 0xA0;
    if (of_latin_1) ++i;
    out += byte < 0x20 || byte == 0x7F || of_latin_1 ? '?' : text[i];
  }
  return out;
}

}  // namespace tagtwist::internal

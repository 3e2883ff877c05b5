# Writes SOURCE, which defines a function that returns the content of FILE:
#   std::string_view tagtwist::internal::NAME();
# Run as a script: cmake -DFILE=... -DNAME=... -DSOURCE=... -P embed_text.cmake
file(READ "${FILE}" hex HEX)
string(REGEX REPLACE "([0-9a-f][0-9a-f])" "'\\\\x\\1'," bytes "${hex}")
file(WRITE "${SOURCE}" "#include <string_view>
namespace tagtwist::internal {
std::string_view ${NAME}();
std::string_view ${NAME}() {
  static constexpr char kContent[] = {${bytes}'\\0'};
  return {kContent, sizeof kContent - 1};
}
}  // namespace tagtwist::internal
")

#include "tests/fuzz/fuzz_file.h"

#include <algorithm>
#include <filesystem>
#include <string_view>

namespace tagtwist::internal {
namespace {

namespace fs = std::filesystem;
constexpr std::string_view kMark = "\n=== ";
constexpr size_t kMostFiles = 20;

bool IsPlainName(const std::string& name) {
  if (name.empty() || name.size() > 60 || name[0] == '/') return false;
  for (const fs::path& part : fs::path(name)) {
    if (part == ".." || part == ".") return false;
  }
  return name.find('\0') == std::string::npos;
}

}  // namespace

std::string PackTree(const FuzzTree& tree) {
  std::string out;
  for (const auto& [name, bytes] : tree) {
    out.append(kMark).append(name).append("\n").append(bytes);
  }
  return out;
}

FuzzTree UnpackTree(const std::string& bytes) {
  FuzzTree out;
  for (size_t at = bytes.find(kMark); at != std::string::npos && out.size() < kMostFiles;) {
    const size_t name = at + kMark.size(), line = bytes.find('\n', name);
    if (line == std::string::npos) break;
    at = bytes.find(kMark, line);
    const size_t end = std::min(at, bytes.size());
    out.emplace_back(bytes.substr(name, line - name), bytes.substr(line + 1, end - line - 1));
  }
  out.erase(std::remove_if(out.begin(), out.end(),
                           [](const auto& file) { return !IsPlainName(file.first); }),
            out.end());
  return out;
}

FuzzTree ReadTree(const std::string& folder) {
  FuzzTree out;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (!entry.is_regular_file()) continue;
    out.emplace_back(fs::relative(entry.path(), folder).string(), ReadText(entry.path()));
  }
  std::sort(out.begin(), out.end());
  return out;
}

void WriteTree(const FuzzTree& tree, const std::string& folder) {
  for (const auto& [name, bytes] : tree) {
    const fs::path path = fs::path(folder) / name;
    std::error_code ignored;
    fs::create_directories(path.parent_path(), ignored);
    WriteText(path, bytes);
  }
}

}  // namespace tagtwist::internal

#include "frontend/base/files/input_digest.h"

#include <nettle/sha2.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <vector>

namespace tagtwist {
namespace {

namespace fs = std::filesystem;

std::string Hexadecimal(sha256_ctx* context) {
  constexpr const char* kDigits = "0123456789abcdef";
  std::array<uint8_t, SHA256_DIGEST_SIZE> digest{};
  sha256_digest(context, digest.size(), digest.data());
  std::string out;
  for (const uint8_t byte : digest) {
    out += kDigits[byte >> 4U];
    out += kDigits[byte & 15U];
  }
  return out;
}

void Update(const char* data, size_t size, sha256_ctx* context) {
  sha256_update(context, size, reinterpret_cast<const uint8_t*>(data));
}

std::string Sha256(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) return "";
  sha256_ctx context{};
  sha256_init(&context);
  std::vector<char> block(1U << 16U);
  while (in) {
    in.read(block.data(), static_cast<std::streamsize>(block.size()));
    Update(block.data(), static_cast<size_t>(in.gcount()), &context);
  }
  return Hexadecimal(&context);
}

bool IsTable(const fs::path& path) {
  const std::string ending = path.extension().string();
  return ending == ".csv" || ending == ".yaml" || ending == ".db3" || ending == ".mcap";
}

}  // namespace

std::string DigestText(const std::string& text) {
  sha256_ctx context{};
  sha256_init(&context);
  Update(text.data(), text.size(), &context);
  return Hexadecimal(&context);
}

std::vector<InputFile> DigestInput(const std::string& flag, const std::string& path) {
  constexpr int kDeepest = 2;
  std::error_code unknown;
  std::vector<std::string> files;
  if (fs::is_regular_file(path, unknown)) {
    files.push_back(path);
  } else if (fs::is_directory(path, unknown)) {
    for (auto entry = fs::recursive_directory_iterator(path, unknown);
         entry != fs::recursive_directory_iterator(); entry.increment(unknown)) {
      if (entry.depth() >= kDeepest) entry.disable_recursion_pending();
      if (entry->is_regular_file(unknown) && IsTable(entry->path())) {
        files.push_back(entry->path().string());
      }
    }
    std::sort(files.begin(), files.end());
  }
  std::vector<InputFile> out;
  for (const std::string& file : files) {
    out.push_back({flag, file, fs::file_size(file, unknown), Sha256(file)});
  }
  return out;
}

}  // namespace tagtwist

#include "frontend/base/files/input_digest.h"

#include <openssl/evp.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <memory>

namespace tagtwist {
namespace {

namespace fs = std::filesystem;

struct FreeDigest {
  void operator()(EVP_MD_CTX* context) const { EVP_MD_CTX_free(context); }
};

std::string Hexadecimal(const std::array<unsigned char, EVP_MAX_MD_SIZE>& digest,
                        unsigned int size) {
  constexpr const char* kDigits = "0123456789abcdef";
  std::string out;
  for (unsigned int i = 0; i < size; ++i) {
    out += kDigits[digest[i] >> 4U];
    out += kDigits[digest[i] & 15U];
  }
  return out;
}

std::string Sha256(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  const std::unique_ptr<EVP_MD_CTX, FreeDigest> context(EVP_MD_CTX_new());
  if (!in || EVP_DigestInit_ex(context.get(), EVP_sha256(), nullptr) != 1) return "";
  std::vector<char> block(1U << 16U);
  while (in) {
    in.read(block.data(), static_cast<std::streamsize>(block.size()));
    EVP_DigestUpdate(context.get(), block.data(), static_cast<size_t>(in.gcount()));
  }
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned int size = 0;
  EVP_DigestFinal_ex(context.get(), digest.data(), &size);
  return Hexadecimal(digest, size);
}

bool IsTable(const fs::path& path) {
  const std::string ending = path.extension().string();
  return ending == ".csv" || ending == ".yaml" || ending == ".db3" || ending == ".mcap";
}

}  // namespace

std::string DigestText(const std::string& text) {
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned int size = 0;
  EVP_Digest(text.data(), text.size(), digest.data(), &size, EVP_sha256(), nullptr);
  return Hexadecimal(digest, size);
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

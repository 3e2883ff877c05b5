#pragma once
#include <cstdint>
#include <string>
#include <vector>

namespace tagtwist {

/// A file that a run read.
struct InputFile {
  std::string flag;  // that named it: "--map"
  std::string path;  // as it was named, or in the folder that was
  uint64_t bytes = 0;
  std::string sha256;  // of its content, 64 hexadecimal digits; empty: it cannot be read twice
};

/// SHA-256 of a text, 64 hexadecimal digits.
std::string DigestText(const std::string& text);

/// A file's digest; of a folder (a recording) those of its tables, .csv, .yaml, .db3 and .mcap, up
/// to two folders deep, in order of name: images are not read for it. Nothing for what is no file.
std::vector<InputFile> DigestInput(const std::string& flag, const std::string& path);

}  // namespace tagtwist

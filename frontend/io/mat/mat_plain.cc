#include "frontend/io/mat/mat_plain.h"

#include <stdlib.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <memory>

#include "frontend/io/mat/mat_elements.h"

namespace tagtwist::internal {
namespace {

using Chunk = std::array<unsigned char, 65536>;

// Feeds the element's bytes to take(data, size), which returns false to stop; false when the file
// cannot be read or take stopped.
template <typename Take>
bool ForEachChunk(std::FILE* file, uint64_t begin, uint64_t length, const Take& take) {
  if (std::fseek(file, static_cast<long>(begin), SEEK_SET) != 0) return false;
  auto chunk = std::make_unique<Chunk>();
  while (length > 0) {
    const size_t wanted = static_cast<size_t>(std::min<uint64_t>(length, chunk->size()));
    if (std::fread(chunk->data(), 1, wanted, file) != wanted) return false;
    if (!take(chunk->data(), wanted)) return false;
    length -= wanted;
  }
  return true;
}

// One zlib stream, inflated into a file.
class Inflater {
 public:
  Inflater(std::FILE* to, uint64_t most_bytes) : to_(to), most_bytes_(most_bytes) {
    ready_ = ::inflateInit(&stream_) == Z_OK;
  }
  ~Inflater() { ::inflateEnd(&stream_); }
  Inflater(const Inflater&) = delete;
  Inflater& operator=(const Inflater&) = delete;

  // False when the stream is damaged, or the file cannot take more (see write_failed).
  bool Take(unsigned char* data, size_t size) {
    stream_.next_in = data;
    stream_.avail_in = static_cast<unsigned>(size);
    while (ready_ && !ended_ && stream_.avail_in > 0) {
      stream_.next_out = out_->data();
      stream_.avail_out = static_cast<unsigned>(out_->size());
      const int status = ::inflate(&stream_, Z_NO_FLUSH);
      if (status != Z_OK && status != Z_STREAM_END) return false;
      ended_ = status == Z_STREAM_END;
      const size_t got = out_->size() - stream_.avail_out;
      if (written_ < kMatTagBytes)
        std::memcpy(tag_.data() + written_, out_->data(), std::min(got, kMatTagBytes - written_));
      written_ += got;
      too_large_ = written_ > most_bytes_;
      if (too_large_) return false;
      write_failed_ = std::fwrite(out_->data(), 1, got, to_) != got;
      if (write_failed_) return false;
    }
    return ready_;
  }
  // True when the stream ended and holds exactly the one variable that its tag speaks of.
  bool IsWhole(bool big_endian) const {
    return ended_ && written_ >= kMatTagBytes &&
           MatUint32(tag_.data(), big_endian) == kMatMatrixType &&
           MatUint32(tag_.data() + 4, big_endian) == written_ - kMatTagBytes;
  }
  bool write_failed() const { return write_failed_; }
  bool too_large() const { return too_large_; }
  uint64_t written() const { return written_; }

 private:
  std::FILE* to_;
  uint64_t most_bytes_;
  z_stream stream_ = {};
  bool ready_ = false, ended_ = false, write_failed_ = false, too_large_ = false;
  uint64_t written_ = 0;
  std::array<unsigned char, kMatTagBytes> tag_ = {};
  std::unique_ptr<Chunk> out_ = std::make_unique<Chunk>();
};

// `left_bytes`: that may still be inflated.
Status CopyElement(std::FILE* from, const MatElement& element, bool big_endian, std::FILE* to,
                   const std::string& path, const std::string& copy_path, uint64_t* left_bytes) {
  const Error write_error{path + ": cannot inflate into " + copy_path + ": " +
                          std::strerror(ENOSPC)};
  const uint64_t tag_begin = element.begin - kMatTagBytes;
  if (element.type == kMatMatrixType) {
    const bool copied = ForEachChunk(
        from, tag_begin, element.length + kMatTagBytes,
        [to](unsigned char* data, size_t size) { return std::fwrite(data, 1, size, to) == size; });
    if (!copied) return write_error;
    return Ok();
  }
  Inflater inflater(to, *left_bytes);
  const bool inflated =
      ForEachChunk(from, element.begin, element.length,
                   [&](unsigned char* data, size_t size) { return inflater.Take(data, size); });
  if (inflater.write_failed()) return write_error;
  if (inflater.too_large()) {
    return Error{path + ": the compressed variable at byte " + std::to_string(tag_begin) +
                 " becomes larger than any recording of that file's size" +
                 RaisesLimit("inflated_bytes")};
  }
  *left_bytes -= inflater.written();
  if (!inflated || !inflater.IsWhole(big_endian)) {
    return Error{path + ": damaged: the compressed variable at byte " + std::to_string(tag_begin) +
                 " does not inflate"};
  }
  return Ok();
}

Status CopyPlain(std::FILE* from, const MatElements& contents, const std::string& path,
                 const std::string& copy_path, const Limits& limits) {
  const CFile to = OpenCFile(copy_path, "wbe");
  bool written = to != nullptr && std::fwrite(contents.header.data(), 1, kMatHeaderBytes,
                                              to.get()) == kMatHeaderBytes;
  const uint64_t file_bytes = contents.variables.empty() ? 0
                                                         : contents.variables.back().begin +
                                                               contents.variables.back().length;
  // Images of one gray deflate to a thousandth, real ones to a half.
  auto left_bytes = static_cast<uint64_t>(limits.inflated_bytes) +
                    static_cast<uint64_t>(limits.inflated_ratio * static_cast<double>(file_bytes));
  for (const MatElement& element : contents.variables) {
    if (!written) break;
    Status copied =
        CopyElement(from, element, contents.big_endian, to.get(), path, copy_path, &left_bytes);
    if (!copied) return copied;
  }
  written = written && std::fflush(to.get()) == 0;
  if (!written) return Error{path + ": cannot inflate into " + copy_path};
  return Ok();
}

}  // namespace

Result<PlainMat> MakePlainMat(const std::string& path, const Limits& limits) {
  const CFile file = OpenCFile(path, "rbe");
  if (file == nullptr) return Error{path + ": cannot open: " + std::strerror(errno)};
  const auto contents = ListMatVariables(file.get(), path);
  if (!contents) return contents.error();
  bool compressed = false;
  for (const MatElement& element : contents->variables)
    compressed |= element.type == kMatCompressedType;
  if (!compressed) return PlainMat{path, false};

  std::error_code no_folder;
  PlainMat copy{(std::filesystem::temp_directory_path(no_folder) / "tagtwist-XXXXXX").string(),
                true};
  const int descriptor = ::mkstemp(copy.path.data());
  if (descriptor < 0) {
    return Error{path + ": cannot inflate into " + copy.path + ": " + std::strerror(errno)};
  }
  ::close(descriptor);
  if (const Status copied = CopyPlain(file.get(), *contents, path, copy.path, limits); !copied) {
    ::unlink(copy.path.c_str());
    return copied.error();
  }
  return copy;
}

Status CheckMatIsWhole(const std::string& path) {
  const CFile file = OpenCFile(path, "rbe");
  if (file == nullptr) return Error{path + ": cannot open: " + std::strerror(errno)};
  const auto contents = ListMatVariables(file.get(), path);
  if (!contents) return contents.error();
  return Ok();
}

}  // namespace tagtwist::internal

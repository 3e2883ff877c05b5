#include "frontend/io/images/png_image.h"

#include <png.h>

#include <csetjmp>
#include <cstring>
#include <vector>

namespace tagtwist::internal {
namespace {

struct PngSource {
  const std::string* bytes;
  size_t at;
};

void TakePngBytes(png_structp png, png_bytep to, size_t size) {
  auto* const source = static_cast<PngSource*>(png_get_io_ptr(png));
  if (size > source->bytes->size() - source->at) png_error(png, "");
  std::memcpy(to, source->bytes->data() + source->at, size);
  source->at += size;
}

// libpng's own handlers print. An error has to leave by a jump; no object lies on its way.
void EndPng(png_structp png, png_const_charp) { png_longjmp(png, 1); }
void IgnoreOfPng(png_structp, png_const_charp) {}

// libpng's state, freed with its scope.
class PngReader {
 public:
  explicit PngReader(PngSource* source)
      : png_(::png_create_read_struct(PNG_LIBPNG_VER_STRING, nullptr, EndPng, IgnoreOfPng)),
        info_(png_ == nullptr ? nullptr : ::png_create_info_struct(png_)) {
    if (info_ != nullptr) ::png_set_read_fn(png_, source, TakePngBytes);
  }
  ~PngReader() { ::png_destroy_read_struct(&png_, &info_, nullptr); }
  PngReader(const PngReader&) = delete;
  PngReader& operator=(const PngReader&) = delete;

  // Takes the header and asks for 8 bits of gray.
  bool Begin() {
    if (info_ == nullptr || setjmp(png_jmpbuf(png_)) != 0) return false;
    ::png_read_info(png_, info_);
    const int colour = ::png_get_color_type(png_, info_);
    const int depth = ::png_get_bit_depth(png_, info_);
    if (depth == 16) ::png_set_strip_16(png_);
    ::png_set_strip_alpha(png_);
    if (colour == PNG_COLOR_TYPE_PALETTE) ::png_set_palette_to_rgb(png_);
    if ((colour & PNG_COLOR_MASK_COLOR) == 0 && depth < 8) ::png_set_expand_gray_1_2_4_to_8(png_);
    ::png_set_rgb_to_gray(png_, 1, 0.299, 0.587);
    ::png_set_interlace_handling(png_);
    ::png_read_update_info(png_, info_);
    return ::png_get_rowbytes(png_, info_) == width();
  }
  size_t width() const { return ::png_get_image_width(png_, info_); }
  size_t height() const { return ::png_get_image_height(png_, info_); }

  bool ReadRows(png_bytepp rows) {
    if (setjmp(png_jmpbuf(png_)) != 0) return false;
    ::png_read_image(png_, rows);
    ::png_read_end(png_, nullptr);
    return true;
  }

 private:
  png_structp png_;
  png_infop info_;
};

}  // namespace

std::optional<cv::Mat> DecodeGrayPng(const std::string& bytes) {
  PngSource source{&bytes, 0};
  PngReader reader(&source);
  if (!reader.Begin()) return std::nullopt;
  cv::Mat out(static_cast<int>(reader.height()), static_cast<int>(reader.width()), CV_8UC1);
  std::vector<png_bytep> rows;
  for (int row = 0; row < out.rows; ++row) rows.push_back(out.ptr(row));
  if (!reader.ReadRows(rows.data())) return std::nullopt;
  return out;
}

}  // namespace tagtwist::internal

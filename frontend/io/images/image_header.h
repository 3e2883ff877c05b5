#pragma once
#include <cstdint>
#include <optional>
#include <string_view>

namespace tagtwist::internal {

/// Pixels across and down that an image says it has.
struct ImageHeader {
  uint64_t width = 0, height = 0;
  uint64_t least_bytes = 0;  // that a file of these has (PNM; 0: it depends)
};

/// Whether the bytes begin as a PNM's (PBM, PGM, PPM) do.
bool BeginsAsPnm(std::string_view bytes);

/// Read from the bytes of a PNG, JPEG, TIFF, BMP, WebP or PNM, before anything is decoded; nullopt:
/// another format, or its header is cut or says that there is no pixel. Sizes as in those formats'
/// specifications; what has one is no other format to any library.
std::optional<ImageHeader> ReadImageHeader(std::string_view bytes);

}  // namespace tagtwist::internal

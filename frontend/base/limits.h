#pragma once
#include <cstdint>
#include <optional>
#include <string>

namespace tagtwist {

/// What a file of others may ask for at most. Whatever asks for more is refused before the memory
/// or the time is spent, in one line that names the limit. The defaults are far above what
/// recordings have; who means a larger file raises what the line names.
struct Limits {
  int64_t file_bytes = 2'000'000'000;   // of a table, a trajectory or an image that is read whole
  int64_t text_bytes = 20'000'000;      // of YAML or XML, whose trees are larger than they are
  int64_t pipe_bytes = 200'000'000;     // of a pipe, which does not tell how much is to come
  double pipe_start_s = 1.5;            // that a pipe may have no writer
  double pipe_idle_s = 5;               // that a pipe may say nothing
  double first_frame_s = 10;            // that a stream may take to open, or to a frame
  int64_t frame_pixels = 100'000'000;   // of an image or a frame of a video
  int64_t elements = 1 << 30;           // of an array in a .mat
  int64_t fields = 1'000'000;           // of all structs and cells in a .mat
  int64_t nodes = 200'000;              // of a tree of YAML or XML, aliases written out
  int64_t key_bytes = 64'000'000;       // of that tree's names and texts
  int64_t depth = 64;                   // of lists in lists, structs in structs
  int64_t tags = 100'000;               // of a map that is a grid
  int64_t record_bytes = 1 << 30;       // of a record of an MCAP file, and of a chunk unpacked
  int64_t inflated_bytes = 64'000'000;  // that what is compressed may become, whatever its size,
  double inflated_ratio = 100;          // or so many times its size, where that is more

  /// The first limit that is none: "depth: expected in [1, 1000], got 0".
  std::optional<std::string> Problem() const;

  template <typename Self, typename Visitor>
  static void VisitFields(Self& self, Visitor&& visit) {
    visit("file_bytes", self.file_bytes);
    visit("text_bytes", self.text_bytes);
    visit("pipe_bytes", self.pipe_bytes);
    visit("pipe_start_s", self.pipe_start_s);
    visit("pipe_idle_s", self.pipe_idle_s);
    visit("first_frame_s", self.first_frame_s);
    visit("frame_pixels", self.frame_pixels);
    visit("elements", self.elements);
    visit("fields", self.fields);
    visit("nodes", self.nodes);
    visit("key_bytes", self.key_bytes);
    visit("depth", self.depth);
    visit("tags", self.tags);
    visit("record_bytes", self.record_bytes);
    visit("inflated_bytes", self.inflated_bytes);
    visit("inflated_ratio", self.inflated_ratio);
  }
};

namespace internal {

/// The way on, at the end of a refusal: " (--limits nodes=N raises that)".
std::string RaisesLimit(const char* name);

/// Whether what is compressed in so many bytes may become so many.
bool MayInflate(uint64_t packed_bytes, uint64_t bytes, const Limits& limits);

}  // namespace internal
}  // namespace tagtwist

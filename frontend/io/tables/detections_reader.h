#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "frontend/base/limits.h"
#include "frontend/base/result.h"
#include "frontend/io/tables/stamps.h"
#include "frontend/types/measurements.h"

namespace tagtwist::internal {

/// The rows of one stamp.
struct StampedDetections {
  int64_t t_ns = 0;
  int line = 0;  // of the first row, for messages
  std::vector<TagDetection> tags;
  std::vector<int> doubled_ids = {};  // of rows that tell that alone, sorted
};

/// A table "t,id,u1,v1,...,u4,v4" (or "timestamp" in ns): corners p1..p4 in pixels, pixel centres
/// at integers. Rows of a stamp stand together and stamps grow; ids may repeat. Where `known_ids`
/// has entries, another id is an error. Rows without numbers and those whose stamps run backwards
/// are passed over, and counted in the notes.
/// The table is gone over once when it is opened, which tells all that is wrong with it, and once
/// more as its stamps are asked for; no more of it than a piece is ever in memory.
class DetectionsReader {
 public:
  static Result<DetectionsReader> Open(const std::string& path, TimeUnit unit,
                                       const std::vector<int>& known_ids = {},
                                       const Limits& limits = {});
  DetectionsReader(DetectionsReader&&) noexcept;
  DetectionsReader& operator=(DetectionsReader&&) noexcept;
  ~DetectionsReader();

  /// All stamps, strictly growing. Who takes them keeps them: they are here no longer.
  std::vector<int64_t> TakeStamps();
  const std::vector<std::string>& notes() const;

  /// What the next stamp has; nullopt at the end. An error where the file was changed since it was
  /// opened, as far as that is seen.
  Result<std::optional<StampedDetections>> Next();

 private:
  struct Impl;
  explicit DetectionsReader(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

/// All of such a table.
Result<std::vector<StampedDetections>> ReadDetectionsCsv(const std::string& path, TimeUnit unit,
                                                         const std::vector<int>& known_ids = {},
                                                         std::vector<std::string>* notes = nullptr,
                                                         const Limits& limits = {});

}  // namespace tagtwist::internal

#pragma once
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "frontend/base/result.h"
#include "frontend/types/body_state.h"

namespace tagtwist {

/// A trajectory that was read, and what its reader must tell.
struct TrajectoryFile {
  std::vector<TruthSample> samples;  // stamps grow strictly; at least one
  std::string form;                  // "TUM", "Motive", ...
  std::vector<std::string> notes;    // one line each: rows passed over, a unit that was found
};

/// Samples of rows as they come in a file: a row without finite numbers, with a quaternion of zero
/// or with a stamp that does not grow is passed over and counted.
class TrajectoryRows {
 public:
  explicit TrajectoryRows(std::string path) : path_(std::move(path)) {}

  /// `line`: of the file; for messages. An error only for a quaternion that is neither of unit
  /// norm (to 1e-2) nor zero.
  Status Add(int line, int64_t t_ns, const std::vector<double>& xyz_qxyzw);
  /// Of the sample that was added last; false when the last row was passed over.
  bool LastWasTaken() const { return last_was_taken_; }
  void SetTwist(const Twist& twist) { out_.samples.back().twist = twist; }
  void PassOver(int line, const std::string& why);

  /// With the notes; refuses a file of which no more than half is left.
  Result<TrajectoryFile> Finish(const std::string& form);

 private:
  struct PassedOver {
    size_t count = 0;
    int first_line = 0;
    std::string why;
  };
  std::string path_;
  TrajectoryFile out_;
  std::vector<PassedOver> passed_over_;  // one a reason
  size_t rows_ = 0;
  bool last_was_taken_ = false;
};

}  // namespace tagtwist

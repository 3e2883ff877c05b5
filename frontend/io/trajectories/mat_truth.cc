#include "frontend/io/trajectories/mat_truth.h"

#include <cmath>

#include "frontend/io/tables/stamps.h"
#include "frontend/io/trajectories/vicon.h"

namespace tagtwist::internal {
namespace {

// "a.mat: time(3): fault", packets and columns counted from 1.
Error ElementError(const std::string& path, const std::string& element, size_t index,
                   const std::string& fault) {
  return Error{path + ": " + element + std::to_string(index + 1) + "): " + fault};
}

}  // namespace

std::optional<int64_t> NanosecondsFromMat(double seconds) {
  if (!(std::abs(seconds) < 1e-9 * kMostStampNs)) return std::nullopt;
  return std::llround(seconds * 1e9);
}

Result<std::vector<TruthSample>> TruthFromMat(MatFile* file, const std::string& path) {
  const auto time = file->ReadVariable("time");
  if (!time) return time.error();
  const auto vicon = file->ReadVariable("vicon");
  if (!vicon) return vicon.error();
  if (!*vicon || (*vicon)->size() == 0) return std::vector<TruthSample>{};
  if (!*time) return Error{path + ": vicon without the variable 'time'"};
  const std::vector<double> seconds = (*time)->ToNumbers(), values = (*vicon)->ToNumbers();
  const size_t n = seconds.size();
  if (!(*vicon)->IsMatrix(12, n)) {
    return Error{path + ": vicon: expected 12 x " + std::to_string(n) + " like time, got " +
                 DescribeShape(**vicon)};
  }
  std::vector<TruthSample> truth;
  truth.reserve(n);
  for (size_t i = 0; i < n; ++i) {
    const auto t_ns = NanosecondsFromMat(seconds[i]);
    if (!t_ns) {
      const std::string got = FormatNumber(seconds[i]);
      return ElementError(path, "time(", i, "expected a time in seconds, got " + got);
    }
    if (!truth.empty()) {
      const auto fault = StampFault(truth.back().t_ns, *t_ns);
      if (fault) return ElementError(path, "time(", i, *fault);
    }
    const ViconColumn state(values.data() + 12 * i);
    if (!state.allFinite()) return ElementError(path, "vicon(:,", i, "not finite");
    truth.push_back(TruthFromVicon(*t_ns, state));
  }
  return truth;
}

Result<std::vector<TruthSample>> ReadMatTruth(const std::string& path, const Limits& limits) {
  const auto file = OpenMatFile(path, limits);
  if (!file) return file.error();
  auto truth = TruthFromMat(file->get(), path);
  if (truth && truth->empty()) return Error{path + ": no ground truth: no variable 'vicon'"};
  return truth;
}

}  // namespace tagtwist::internal

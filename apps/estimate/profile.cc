#include "apps/estimate/profile.h"

#include <chrono>
#include <cstdint>
#include <filesystem>

#include "apps/support/trace_recorder.h"
#include "frontend/base/files/atomic_file.h"

namespace tagtwist::internal {

Status WithProfile(const std::string& path, const std::function<Status(SpanObserver*)>& run) {
  if (path.empty()) return run(nullptr);
  std::error_code ignored;
  const auto folder = std::filesystem::path(path).parent_path();
  if (!folder.empty() && !std::filesystem::is_directory(folder, ignored)) {
    return Error{path + ": cannot write: its folder is not there"};
  }
  TraceRecorder recorder([] {
    const auto now = std::chrono::steady_clock::now().time_since_epoch();
    return static_cast<int64_t>(std::chrono::nanoseconds(now).count());
  });
  Status done = Ok();
  {
    const Span all(&recorder, "run");
    done = run(&recorder);
  }
  const auto written = WriteFileAtomically(path, recorder.Json());
  return done ? written : done;
}

}  // namespace tagtwist::internal

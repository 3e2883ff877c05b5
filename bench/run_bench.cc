#include "bench/run_bench.h"

#include <glog/logging.h>

namespace tagtwist::internal {

int RunBench(int argc, char** argv, const Usage& usage,
             const std::function<std::optional<std::string>()>& flag_problem,
             const std::function<Status()>& measure) {
  google::InitGoogleLogging(argv[0]);
  ParseFlagsOrExit2(argc, argv, usage);
  if (const auto problem = flag_problem()) return Fail(usage, *problem, 2);
  const auto done = measure();
  return done ? 0 : Fail(usage, done.error().message);
}

}  // namespace tagtwist::internal

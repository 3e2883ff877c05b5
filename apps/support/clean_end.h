#pragma once
#include <atomic>
#include <functional>
#include <string>
#include <thread>
#include <vector>

#include "apps/support/usage.h"

namespace tagtwist::internal {

/// What a program writes, file by file, and the folder that gets a FileSet; empty: none.
struct Outputs {
  std::vector<std::string> files;
  std::string set_folder;
};

/// Keeps a program's outputs whole when it is told to end. At its beginning it tells, on standard
/// error, what runs that were killed have left of the same outputs, and finishes or removes it.
/// While it lives an interrupt (INT, TERM, HUP) ends the process by that signal, with one line and
/// nothing half-written: a set of results that has begun to take its place is waited for.
/// To be made before the process has other threads.
class CleanEnd {
 public:
  CleanEnd(const Usage& usage, Outputs outputs);
  ~CleanEnd();
  CleanEnd(const CleanEnd&) = delete;
  CleanEnd& operator=(const CleanEnd&) = delete;

  /// From now on the first interrupt but makes the returned function true, as long as this lives.
  std::function<bool()> AskFirst();

 private:
  void Watch();
  [[noreturn]] void End(int signal);

  std::string program_;
  Outputs outputs_;
  int signals_ = -1, wake_ = -1;  // descriptors
  std::atomic<bool> ask_first_{false}, asked_{false};
  std::thread watcher_;
};

}  // namespace tagtwist::internal

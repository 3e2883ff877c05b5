#pragma once
#include <csignal>
#include <functional>
#include <string>
#include <vector>

#include "frontend/io/recordings/dataset_writer.h"

namespace tagtwist::internal {

/// What a program did.
struct ProgramRun {
  int status = -1;  // exit status, or -1 when a signal ended it
  std::string out, err;
  double peak_rss_mib = 0;  // 0: not more than the test itself had
  double wall_s = 0;
};

/// What a program finds around it.
struct Surroundings {
  std::string out;                       // where standard output goes; empty: into ProgramRun::out
  std::vector<std::string> environment;  // besides the usual: "NAME=value"
  int signal = SIGINT;                   // what interrupt_when sends
};

/// Runs a built program ("tagtwist_estimate") in `folder`. A sanitizer's report would be status 99.
/// `interrupt_when` is asked while it runs; when it says true the program gets a Ctrl-C, or the
/// signal of `around`.
ProgramRun RunProgram(const std::string& folder, const std::string& program,
                      const std::vector<std::string>& arguments,
                      const std::function<bool()>& interrupt_when = {},
                      const Surroundings& around = {});

/// True when the text is exactly one line, ended.
bool IsOneLine(const std::string& text);

/// True where the folder is missing, or has no more than the summary.json that says why a run
/// failed.
bool HasNoResults(const std::string& folder);

/// A recording of six frames over the course's mat, at t = 0, 0.02, ..., 0.1 s, with ground truth
/// and IMU; the images are rendered plainly, or left out. Written at folder/name.
std::string MakeRecording(const std::string& folder, const std::string& name, DatasetFormat format,
                          bool images);

/// Line `number` (from 1) of a file replaced; number past the end appends.
void ReplaceLine(const std::string& path, size_t number, const std::string& line);
/// The first `bytes` bytes of a file are kept; a negative number counts from the end.
void Truncate(const std::string& path, long bytes);
/// 4096 bytes of no meaning, the same at every call.
std::string Garbage();
/// Paths of everything below a folder, relative to it, hidden files included, sorted.
std::vector<std::string> ListTree(const std::string& folder);

}  // namespace tagtwist::internal

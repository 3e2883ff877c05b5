#pragma once
#include <initializer_list>
#include <optional>
#include <string>
#include <vector>

#include "apps/support/help_text.h"

namespace tagtwist::internal {

/// A command line, read. With an exit status the program ends: `text` is its last word, on standard
/// output when the status is 0 and on standard error otherwise.
struct ParsedCommandLine {
  std::vector<std::string> arguments;  // those that are not flags
  std::optional<int> exit_status;
  std::string text;
};

/// Sets the gflags of the process from argv and returns the other arguments. Stricter than gflags
/// itself, which exits with status 1: an unknown flag, a value that does not parse or that its
/// validator refuses, a missing value and too many arguments are wrong usage, status 2, in one
/// line. --help prints `usage`, --man the same as a man page, --version the version; all end with
/// status 0.
/// Forms: --flag value, --flag=value, --flag and --noflag for booleans; "--" ends the flags.
ParsedCommandLine ParseCommandLine(int argc, const char* const* argv, const Usage& usage);

/// ParseCommandLine for a main(): prints and exits where that is called for.
std::vector<std::string> ParseFlagsOrExit2(int argc, char** argv, const Usage& usage);

/// The first problem of flags ("seeds: expected ...", frontend/base/option_check.h) as --seeds'
/// own.
std::optional<std::string> FirstFlagProblem(
    std::initializer_list<std::optional<std::string>> problems);

/// Prints "program: message" on standard error and returns `status`: 1 for bad input or data,
/// 2 for wrong usage.
int Fail(const Usage& usage, const std::string& message, int status = 1);

}  // namespace tagtwist::internal

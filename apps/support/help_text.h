#pragma once
#include <gflags/gflags.h>

#include <map>
#include <optional>
#include <string>
#include <vector>

namespace tagtwist::internal {

/// Flags that belong together in the help text, by name.
struct FlagGroup {
  std::string title;
  std::vector<std::string> flags;
};

/// A command line to copy.
struct UsageExample {
  std::string purpose, command;
};

/// What a program says of itself. Texts and defaults of the flags come from gflags.
struct Usage {
  std::string program;   // "tagtwist_simulate"
  std::string synopsis;  // what follows the name: "--output PATH [options]"
  std::string summary;   // what the program does, a line or more
  std::vector<FlagGroup> groups;
  int max_arguments = 0;  // arguments that are not flags
  std::vector<UsageExample> examples = {};
  std::map<std::string, std::string> implied = {};  // values of flags that may be given without one
  std::vector<std::string> repeated = {};  // flags that may be given several times: lines of a text
};

/// A flag as the help tells of it.
struct FlagHelp {
  std::string form;  // "--output TEXT"
  std::string text;  // what it does, and its default: "Folder to write to. [results]"
};
/// nullopt: the program has no such flag.
std::optional<FlagHelp> HelpOfFlag(const std::string& name);

/// The help text, as --help prints it.
std::string HelpText(const Usage& usage);

/// The program's own flag of that name; false: it has none. Those that gflags brings along
/// (--flagfile, --fromenv, ...) are not ours, and not honoured.
bool FindFlag(const std::string& name, gflags::CommandLineFlagInfo* info);

}  // namespace tagtwist::internal

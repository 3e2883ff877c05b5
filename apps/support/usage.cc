#include "apps/support/usage.h"

#include <gflags/gflags.h>

#include <algorithm>
#include <cstdlib>
#include <iostream>

#include "apps/support/help_text.h"
#include "apps/support/man_page.h"
#include "frontend/base/nearest_name.h"
#include "frontend/base/number_text.h"
#include "frontend/base/printable.h"

#ifndef TAGTWIST_VERSION
#define TAGTWIST_VERSION "unknown"
#endif

namespace tagtwist::internal {
namespace {

bool IsTrueWord(const std::string& word) {
  return word == "true" || word == "1" || word == "yes" || word == "t" || word == "y";
}

ParsedCommandLine WrongUsage(const Usage& usage, const std::string& fault) {
  ParsedCommandLine out;
  out.exit_status = 2;
  out.text = usage.program + ": " + fault + " (see " + usage.program + " --help)\n";
  return out;
}

// A flag as typed: its name, and its value where one was given.
struct TypedFlag {
  std::string name, value;
  bool has_value = false;
};

TypedFlag SplitFlag(const std::string& argument) {
  const std::string body = argument.substr(argument.rfind("--", 0) == 0 ? 2 : 1);
  const size_t equals = body.find('=');
  if (equals == std::string::npos) return {body, "", false};
  return {body.substr(0, equals), body.substr(equals + 1), true};
}

// --help, --man and --version, with the status and the text to end with.
bool AnswerQuestion(const TypedFlag& flag, const Usage& usage, ParsedCommandLine* out) {
  const bool help = flag.name == "help" || flag.name == "h" || flag.name == "helpshort";
  if (!help && flag.name != "version" && flag.name != "man") return false;
  if (flag.has_value && !IsTrueWord(flag.value)) return false;
  out->exit_status = 0;
  out->text = help                 ? HelpText(usage)
              : flag.name == "man" ? ManPage(usage, TAGTWIST_VERSION)
                                   : usage.program + " " + TAGTWIST_VERSION + "\n";
  return true;
}

std::vector<std::string> KnownFlags() {
  std::vector<gflags::CommandLineFlagInfo> all;
  gflags::GetAllFlags(&all);
  std::vector<std::string> out;
  for (const gflags::CommandLineFlagInfo& info : all) {
    gflags::CommandLineFlagInfo own;
    if (FindFlag(info.name, &own)) out.push_back(info.name);
  }
  return out;
}

// Flags that name what a run reads: a second one would silently take the place of the first.
bool NamesAnInput(const std::string& name) {
  return name == "dataset" || name == "config" || name == "camera_file" || name == "map" ||
         name == "ground_truth";
}

// The fault in words, or empty; may take the value from the next argument.
std::string SetFlag(const Usage& usage, TypedFlag flag, int argc, const char* const* argv, int* i) {
  gflags::CommandLineFlagInfo info;
  if (!FindFlag(flag.name, &info)) {
    const bool negated = !flag.has_value && flag.name.rfind("no", 0) == 0;
    if (!negated || !FindFlag(flag.name.substr(2), &info) || info.type != "bool") {
      return "unknown flag --" + flag.name + DidYouMean(flag.name, KnownFlags(), "--");
    }
    flag = {info.name, "false", true};
  }
  const auto implied = usage.implied.find(flag.name);
  const bool is_last = *i + 1 >= argc || argv[*i + 1][0] == '-';
  if (!flag.has_value && info.type == "bool") {
    flag.value = "true";
  } else if (!flag.has_value && is_last && implied != usage.implied.end()) {
    flag.value = implied->second;
  } else if (!flag.has_value) {
    if (*i + 1 >= argc) return "--" + flag.name + ": expected a value";
    flag.value = argv[++*i];
  }
  const bool again = !info.is_default && !info.current_value.empty();
  if (NamesAnInput(flag.name) && again && flag.value != info.current_value) {
    return "--" + flag.name + ": given twice, '" + info.current_value + "' and '" + flag.value +
           "': one run takes one";
  }
  const auto& repeated = usage.repeated;
  if (again && std::find(repeated.begin(), repeated.end(), flag.name) != repeated.end()) {
    flag.value = info.current_value + "\n" + flag.value;
  }
  const bool is_real = info.type == "double", is_whole = info.type.rfind("int", 0) == 0;
  // gflags takes nothing at all for 0, and hexadecimal numbers.
  const bool bad_number =
      (is_real && !ParseNumber(flag.value)) || (is_whole && !ParseInteger(flag.value));
  if (bad_number || gflags::SetCommandLineOption(flag.name.c_str(), flag.value.c_str()).empty()) {
    return "--" + flag.name + ": bad value '" + flag.value + "'";
  }
  return "";
}

}  // namespace

ParsedCommandLine ParseCommandLine(int argc, const char* const* argv, const Usage& usage) {
  ParsedCommandLine out;
  bool flags_ended = false;
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    if (flags_ended || argument.size() < 2 || argument[0] != '-') {
      out.arguments.push_back(argument);
    } else if (argument == "--") {
      flags_ended = true;
    } else {
      const TypedFlag flag = SplitFlag(argument);
      if (AnswerQuestion(flag, usage, &out)) return out;
      const std::string fault = SetFlag(usage, flag, argc, argv, &i);
      if (!fault.empty()) return WrongUsage(usage, fault);
    }
  }
  if (out.arguments.size() > static_cast<size_t>(usage.max_arguments)) {
    const std::string& stray = out.arguments[static_cast<size_t>(usage.max_arguments)];
    return WrongUsage(usage, "unexpected argument '" + stray + "'");
  }
  return out;
}

std::vector<std::string> ParseFlagsOrExit2(int argc, char** argv, const Usage& usage) {
  ParsedCommandLine parsed = ParseCommandLine(argc, argv, usage);
  if (parsed.exit_status) {
    std::ostream& out = *parsed.exit_status == 0 ? std::cout : std::cerr;
    if (!(out << parsed.text << std::flush)) {
      parsed.exit_status = Fail(usage, "standard output: cannot write");
    }
    std::exit(*parsed.exit_status);  // NOLINT(concurrency-mt-unsafe): before any thread
  }
  return parsed.arguments;
}

std::optional<std::string> FirstFlagProblem(
    std::initializer_list<std::optional<std::string>> problems) {
  for (const auto& problem : problems) {
    if (problem) return "--" + *problem;
  }
  return std::nullopt;
}

int Fail(const Usage& usage, const std::string& message, int status) {
  std::cerr << usage.program << ": " << Printable(message) << std::endl;
  return status;
}

}  // namespace tagtwist::internal

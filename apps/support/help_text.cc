#include "apps/support/help_text.h"

#include <gflags/gflags.h>

#include <cstdlib>
#include <sstream>

namespace tagtwist::internal {
namespace {

constexpr size_t kWrapColumn = 100;

bool IsOfGflagsItself(const gflags::CommandLineFlagInfo& info) {
  return info.filename.find("gflags") != std::string::npos;
}

// Paragraph `text` broken at words, every line after the first indented.
std::string Wrap(const std::string& text, size_t first_column, size_t indent) {
  std::istringstream words(text);
  std::string out, word;
  size_t column = first_column;
  while (words >> word) {
    if (column > indent && column + 1 + word.size() > kWrapColumn) {
      out += "\n" + std::string(indent, ' ');
      column = indent;
    } else if (!out.empty()) {
      out += ' ';
      ++column;
    }
    out += word;
    column += word.size();
  }
  return out;
}

// gflags prints 0.2 as 0.20000000000000001.
std::string DefaultText(const gflags::CommandLineFlagInfo& info) {
  if (info.type != "double") return info.default_value;
  std::ostringstream out;
  out << std::strtod(info.default_value.c_str(), nullptr);
  return out.str();
}

std::string DescribeFlag(const FlagHelp& help) {
  constexpr size_t kTextColumn = 26;
  std::string line = "  " + help.form;
  line += line.size() < kTextColumn ? std::string(kTextColumn - line.size(), ' ')
                                    : "\n" + std::string(kTextColumn, ' ');
  return line + Wrap(help.text, kTextColumn, kTextColumn) + "\n";
}

}  // namespace

bool FindFlag(const std::string& name, gflags::CommandLineFlagInfo* info) {
  return gflags::GetCommandLineFlagInfo(name.c_str(), info) && !IsOfGflagsItself(*info);
}

std::optional<FlagHelp> HelpOfFlag(const std::string& name) {
  gflags::CommandLineFlagInfo info;
  if (!FindFlag(name, &info)) return std::nullopt;
  FlagHelp out{"--" + name, info.description};
  if (info.type == "bool") {
    if (info.default_value == "true") out.form += "=false";
    return out;
  }
  out.form += info.type == "string" ? " TEXT" : " NUMBER";
  if (!info.default_value.empty()) out.text += " [" + DefaultText(info) + "]";
  return out;
}

std::string HelpText(const Usage& usage) {
  std::string out = usage.program + " " + usage.synopsis + "\n\n" + usage.summary + "\n";
  for (const FlagGroup& group : usage.groups) {
    out += "\n" + group.title + "\n";
    for (const std::string& name : group.flags) {
      if (const auto help = HelpOfFlag(name)) out += DescribeFlag(*help);
    }
  }
  out +=
      "\nHelp\n  --help                  this text\n  --man                   the same as a man "
      "page: "
      "--man | man -l -\n  --version               the version\n";
  if (!usage.examples.empty()) out += "\nExamples\n";
  for (const UsageExample& example : usage.examples) {
    out += "  " + example.purpose + ":\n    " + example.command + "\n";
  }
  out +=
      "\nExit status: 0 done; 1 bad input or data, told in one line; 2 wrong usage; 3 done, with "
      "what\n--fail_on asks for.\n";
  return out;
}

}  // namespace tagtwist::internal

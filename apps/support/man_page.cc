#include "apps/support/man_page.h"

#include <algorithm>
#include <cctype>

namespace tagtwist::internal {
namespace {

// Text as roff takes it: hyphens that can be copied, no line that begins as a request.
std::string Escape(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '\\') {
      out += "\\e";
    } else if (c == '-') {
      out += "\\-";
    } else if ((c == '.' || c == '\'') && (out.empty() || out.back() == '\n')) {
      out += std::string("\\&") + c;
    } else {
      out += c;
    }
  }
  return out;
}

// What a reader of the list of all pages sees: the first clause, in lower case, without its stop.
std::string WhatIs(const std::string& summary) {
  std::string out = summary.substr(0, summary.find_first_of(".,:("));
  std::replace(out.begin(), out.end(), '\n', ' ');
  while (!out.empty() && out.back() == ' ') out.pop_back();
  if (!out.empty()) out[0] = static_cast<char>(std::tolower(static_cast<unsigned char>(out[0])));
  return out;
}

std::string Upper(std::string text) {
  for (char& c : text) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return text;
}

std::string Tagged(const std::string& form, const std::string& text) {
  return ".TP\n.B " + Escape(form) + "\n" + Escape(text) + "\n";
}

}  // namespace

std::string ManPage(const Usage& usage, const std::string& version) {
  std::string out = ".TH " + Upper(usage.program) + " 1 \"\" \"tagtwist " + version +
                    "\" \"User Commands\"\n.SH NAME\n" + Escape(usage.program) + " \\- " +
                    Escape(WhatIs(usage.summary)) + "\n.SH SYNOPSIS\n.B " + Escape(usage.program) +
                    "\n" + Escape(usage.synopsis) + "\n.SH DESCRIPTION\n" + Escape(usage.summary) +
                    "\n.SH OPTIONS\n";
  for (const FlagGroup& group : usage.groups) {
    out += ".SS " + Escape(group.title) + "\n";
    for (const std::string& name : group.flags) {
      if (const auto help = HelpOfFlag(name)) out += Tagged(help->form, help->text);
    }
  }
  out += ".SS Help\n" + Tagged("--help", "The text of this page, shorter.") +
         Tagged("--man", "This page.") + Tagged("--version", "The version.");
  out += ".SH EXIT STATUS\n" + Tagged("0", "Done.") +
         Tagged("1", "Bad input or data, told in one line.") + Tagged("2", "Wrong usage.");
  if (!usage.examples.empty()) out += ".SH EXAMPLES\n";
  for (const UsageExample& example : usage.examples) {
    out += ".PP\n" + Escape(example.purpose) + ":\n.PP\n.RS\n.nf\n" + Escape(example.command) +
           "\n.fi\n.RE\n";
  }
  return out;
}

}  // namespace tagtwist::internal

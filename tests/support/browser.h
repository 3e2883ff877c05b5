#pragma once
#include <array>
#include <cstdio>
#include <string>

#include "tests/support/test_files.h"

namespace tagtwist::internal {

/// What a command prints on both outputs.
inline std::string OutputOf(const std::string& command) {
  std::string out;
  std::FILE* const pipe = ::popen((command + " 2>&1").c_str(), "r");  // NOLINT(cert-env33-c)
  if (pipe == nullptr) return out;
  std::array<char, 4096> buffer;
  for (size_t n; (n = std::fread(buffer.data(), 1, buffer.size(), pipe)) > 0;) {
    out.append(buffer.data(), n);
  }
  ::pclose(pipe);
  return out;
}

inline bool HasBrowser() { return !OutputOf("command -v chromium").empty(); }

inline std::string Browser(const TempFolder& folder, int width, const std::string& what) {
  return OutputOf("HOME=" + folder.path() +
                  " timeout 100 chromium --headless=new --no-sandbox --disable-gpu "
                  "--enable-logging=stderr --virtual-time-budget=3000 --window-size=" +
                  std::to_string(width) + ",900 --user-data-dir=" + (folder / "profile") + " " +
                  what);
}

/// The page as it stands after `script`, below what the browser logged. It lies at page.html.
inline std::string ShowPage(const TempFolder& folder, std::string html, const std::string& script,
                            int width) {
  html.insert(html.rfind("</body>"), "<script>" + script + "</script>\n");
  WriteText(folder / "page.html", html);
  return Browser(folder, width, "--dump-dom file://" + (folder / "page.html"));
}

}  // namespace tagtwist::internal

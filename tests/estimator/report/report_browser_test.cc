// The report in a real browser, where there is one: no fault on its console, everything drawn,
// series switched by their buttons.
#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <utility>

#include "estimator/report/html/report.h"
#include "tests/support/flights/synthetic_estimate.h"
#include "tests/support/temp_folder.h"
#include "tests/support/test_files.h"

namespace tagtwist::internal::report_browser_test {
namespace {

// What a command prints on both outputs.
std::string OutputOf(const std::string& command) {
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

std::string Report(bool window) {
  const Estimate estimate = SyntheticEstimate(300, window);
  ReportInput input;
  input.facts = SyntheticFacts("flight", estimate.frames.size());
  input.map = MakeTagMap(TagGrid());
  input.truth = SmoothTruth(8, 100);
  input.rows = CompareMethods(estimate, input.truth, {});
  return FormatReport(estimate, input);
}

class ReportBrowser : public testing::Test {
 protected:
  void SetUp() override {
    if (OutputOf("command -v chromium").empty()) GTEST_SKIP() << "chromium is not installed";
  }

  // The page as it stands after `script`, below what the browser logged.
  std::string Show(std::string html, const std::string& script, int width) const {
    html.insert(html.rfind("</body>"), "<script>" + script + "</script>\n");
    WriteText(folder_ / "report.html", html);
    return OutputOf("HOME=" + folder_.path() +
                    " timeout 100 chromium --headless=new --no-sandbox --disable-gpu "
                    "--enable-logging=stderr --virtual-time-budget=3000 --window-size=" +
                    std::to_string(width) + ",900 --user-data-dir=" + (folder_ / "profile") +
                    " --dump-dom file://" + (folder_ / "report.html"));
  }

  TempFolder folder_;
};

// Switches the series of slot 2 off, draws all plots, and leaves what it finds on the page.
const char* const kSwitchAndCount = R"(
  const before = document.querySelectorAll('svg .path[data-slot="2"]').length;
  document.querySelector('.legend button[data-slot="2"]').click();
  dispatchEvent(new Event("beforeprint"));
  const pressed = [...document.querySelectorAll('.legend button[data-slot="2"]')];
  const paths = [...document.querySelectorAll('svg .path[data-slot="2"]')];
  document.body.dataset.found = [
    "plots " + document.querySelectorAll(".plot").length,
    "drawn " + [...document.querySelectorAll(".plot")].filter(p => p.querySelector("canvas")).length,
    "switched " + pressed.every(b => b.getAttribute("aria-pressed") === "false"),
    "hidden " + (before > 0 && paths.every(p => p.style.display === "none")),
    "wider " + (document.documentElement.scrollWidth > innerWidth)].join(", ");
)";

TEST_F(ReportBrowser, DrawsAndSwitchesWithoutAFault) {
  for (const auto& [window, width] : {std::pair(false, 1280), std::pair(true, 500)}) {
    const std::string page = Show(Report(window), kSwitchAndCount, width);
    EXPECT_EQ(page.find("CONSOLE"), std::string::npos) << page.substr(0, 1000);
    EXPECT_NE(page.find("data-found=\"plots 29, drawn 29, switched true, hidden true, wider "
                        "false\""),
              std::string::npos)
        << page.substr(page.find("data-found"), 120);
  }
}

TEST_F(ReportBrowser, AFaultWouldBeSeen) {
  const std::string page = Show(Report(false), "nothing.like.this();", 1280);
  EXPECT_NE(page.find("CONSOLE"), std::string::npos);
}

}  // namespace
}  // namespace tagtwist::internal::report_browser_test

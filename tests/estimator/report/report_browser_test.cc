// The report in a real browser, where there is one: no fault on its console, everything drawn,
// series switched by their buttons.
#include <gtest/gtest.h>

#include <utility>

#include "estimator/report/html/report.h"
#include "tests/support/browser.h"
#include "tests/support/flights/synthetic_estimate.h"
#include "tests/support/temp_folder.h"

namespace tagtwist::internal::report_browser_test {
namespace {

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
    if (!HasBrowser()) GTEST_SKIP() << "chromium is not installed";
  }

  std::string Show(const std::string& html, const std::string& script, int width) const {
    return ShowPage(folder_, html, script, width);
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

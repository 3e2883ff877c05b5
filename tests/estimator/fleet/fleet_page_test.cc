#include "estimator/fleet/fleet_page.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <optional>

#include "estimator/fleet/fleet_files.h"
#include "estimator/report/html/page.h"
#include "tests/support/browser.h"
#include "tests/support/fleets.h"

namespace tagtwist::internal::fleet_page_test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

constexpr char kHostile[] = "a \"b\" 'c' <script>alert(1)</script>&amp; d";

Fleet HostileFleet() {
  Fleet fleet = DrawFleet(12, 1, 1);
  fleet.place = kHostile;
  fleet.rows[3].name = kHostile;
  fleet.rows[3].folder = std::string("runs/") + kHostile;
  fleet.rows[4].outcome = FleetOutcome::kFailed;
  fleet.rows[4].error = kHostile;
  fleet.rows[4].log = "logs/a b.txt";
  fleet.rows[5].first_finding = kHostile;
  fleet.rows[5].findings = 1;
  for (double& figure : fleet.rows[4].figures) figure = std::numeric_limits<double>::quiet_NaN();
  return fleet;
}

std::string PageOf(const Fleet& fleet, const Fleet* old_fleet = nullptr) {
  std::optional<FleetChanges> changes;
  if (old_fleet != nullptr) changes = CompareFleets(*old_fleet, fleet);
  return FormatFleetPage(fleet, old_fleet, changes ? &*changes : nullptr, ".");
}

TEST(FleetPage, HostileNamesAreText) {
  const Fleet fleet = HostileFleet();
  const std::string page = PageOf(fleet, &fleet);
  EXPECT_THAT(page, Not(HasSubstr("<script>alert")));
  EXPECT_THAT(page, HasSubstr("&lt;script&gt;alert(1)&lt;/script&gt;&amp;amp; d"));
  EXPECT_THAT(page, HasSubstr("href=\"runs/a%20%22b%22%20%27c%27%20%3Cscript%3Ealert%281%29%3C/"
                              "script%3E%26amp%3B%20d/report.html\""));
}

TEST(FleetPage, NothingComesFromElsewhere) {
  const std::string page = PageOf(HostileFleet());
  EXPECT_THAT(page, HasSubstr("default-src 'none'"));
  for (const char* outside : {"src=", "http://", "https://", "@import", "url("}) {
    EXPECT_THAT(page, Not(HasSubstr(outside)));
  }
}

TEST(FleetPage, LinksLeadFromThePageToTheFile) {
  EXPECT_EQ(LinkTo("results/runs/a b/report.html", "results"), "runs/a%20b/report.html");
  EXPECT_EQ(LinkTo("old/x.html", "pages/here"), "../../old/x.html");
}

TEST(FleetCsv, CellsAreQuotedWhereTheyMust) {
  Fleet fleet = DrawFleet(1, 1, 1);
  fleet.rows[0].name = "a,\"b\"\nc";
  const std::string csv = FormatFleetCsv(fleet);
  EXPECT_THAT(csv, HasSubstr("\n\"a,\"\"b\"\"\nc\",,done,"));
}

TEST(FleetJson, SaysWhatBecameWorse) {
  const Fleet old_fleet = DrawFleet(12, 1, 7), fleet = DrawFleet(12, 1.1, 8);
  const FleetChanges changes = CompareFleets(old_fleet, fleet);
  const std::string json = FormatFleetJson(fleet, &old_fleet, &changes);
  EXPECT_THAT(json, HasSubstr("\"figure\": \"corner_sigma_px\",\n        \"sign\": \"worse\""));
  EXPECT_THAT(json, Not(HasSubstr("\"sign\": \"better\"")));
  EXPECT_THAT(FleetText(fleet, &old_fleet, &changes), HasSubstr("changed: corner noise [px] "));
}

TEST(FleetText, NothingThatATerminalWouldObey) {
  Fleet fleet = HostileFleet();
  fleet.rows[4].error = "x\033[2Jy\n";
  EXPECT_THAT(FleetText(fleet, nullptr, nullptr), HasSubstr("x?[2Jy?"));
}

// Presses the heading of a column twice, filters, follows a point of the plot, and leaves what it
// finds on the page.
const char* const kSortAndFilter = R"(
  const rows = () => [...document.querySelectorAll("#fleet tbody tr")];
  const column = [...document.querySelectorAll("#fleet thead button")]
      .findIndex(b => b.textContent === "ATE [mm]");
  const values = () => rows().map(r => r.cells[column].dataset.v).filter(v => v !== undefined)
      .map(Number);
  const button = document.querySelectorAll("#fleet thead button")[column];
  const grows = v => v.every((x, i) => i === 0 || v[i - 1] <= x);
  button.click();
  const up = grows(values()) && rows()[11].cells[column].dataset.v === undefined;
  button.click();
  const down = grows(values().reverse()) && rows()[11].cells[column].dataset.v === undefined;
  document.querySelectorAll("#fleet thead button")[0].click();
  const names = rows().map(r => r.cells[0].textContent);
  const natural = names.indexOf("flight 2") < names.indexOf("flight 10");
  const filter = document.getElementById("filter");
  filter.value = "failed";
  filter.dispatchEvent(new Event("input"));
  const shown = rows().filter(r => !r.hidden).length;
  filter.value = "";
  filter.dispatchEvent(new Event("input"));
  const points = document.querySelectorAll("svg.scatter a");
  const target = document.querySelector(points[0].getAttribute("href"));
  document.body.dataset.found = [
    "up " + up, "down " + down, "natural " + natural, "shown " + shown,
    "points " + points.length, "leads " + (target !== null && target.tagName === "TR"),
    "links " + [...document.querySelectorAll("#fleet tbody a")].length,
    "wider " + (document.documentElement.scrollWidth > innerWidth)].join(", ");
)";

class FleetBrowser : public testing::Test {
 protected:
  void SetUp() override {
    if (!HasBrowser()) GTEST_SKIP() << "chromium is not installed";
  }
  TempFolder folder_;
};

TEST_F(FleetBrowser, SortsFiltersAndLinksAtEveryWidth) {
  const Fleet fleet = HostileFleet(), old_fleet = DrawFleet(12, 1.2, 2);
  for (const int width : {1280, 500}) {  // no window of Chromium's is narrower
    const std::string page = ShowPage(folder_, PageOf(fleet, &old_fleet), kSortAndFilter, width);
    EXPECT_THAT(page, Not(HasSubstr("CONSOLE"))) << page.substr(0, 1000);
    EXPECT_THAT(page, HasSubstr("data-found=\"up true, down true, natural true, shown 1, points "
                                "22, leads true, links 12, wider false\""))
        << page.substr(page.find("data-found"), 200);
  }
}

// A phone of 360 px, in a frame: the page is not wider, the table scrolls by itself.
TEST_F(FleetBrowser, FitsAPhone) {
  const std::string frame =
      "<!DOCTYPE html><html><body><iframe id=\"phone\" width=\"360\" height=\"700\" srcdoc=\"" +
      EscapeHtml(PageOf(HostileFleet())) + "\"></iframe></body></html>";
  const std::string page = ShowPage(folder_, frame, R"(
    addEventListener("load", () => {
      const page = document.getElementById("phone").contentDocument;
      document.body.dataset.found =
          "rows " + page.querySelectorAll("#fleet tbody tr").length +
          ", wider " + (page.documentElement.scrollWidth > 360) +
          ", scrolls " + (page.querySelector(".scroll").scrollWidth > 360);
    });)",
                                    800);
  EXPECT_THAT(page, HasSubstr("data-found=\"rows 12, wider false, scrolls true\""))
      << page.substr(page.find("data-found"), 100);
}

TEST_F(FleetBrowser, PrintsOnPaper) {
  WriteText(folder_ / "page.html", PageOf(HostileFleet()));
  Browser(folder_, 1280,
          "--print-to-pdf=" + (folder_ / "page.pdf") + " file://" + (folder_ / "page.html"));
  const std::string pdf = ReadText(folder_ / "page.pdf");
  ASSERT_EQ(pdf.substr(0, 5), "%PDF-");
  // A4 across: 842 x 595 points.
  EXPECT_THAT(pdf, HasSubstr("/MediaBox [0 0 84"));
}

}  // namespace
}  // namespace tagtwist::internal::fleet_page_test

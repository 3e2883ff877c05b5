// gcc 12 with the sanitizers calls parts of std::regex uninitialised (its bug 105562).
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"

#include "estimator/report/html/report.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <regex>

#include "estimator/report/html/page.h"
#include "estimator/report/html/pictures.h"
#include "estimator/report/html/plots.h"
#include "estimator/result/imu_left_out.h"
#include "frontend/io/trajectories/vicon.h"
#include "tests/support/flights/synthetic_estimate.h"

namespace tagtwist::internal::report_test {
namespace {

std::string Report(const Estimate& estimate, bool truth = true) {
  ReportInput input;
  input.facts = SyntheticFacts("flights/<b>figure8</b> & more", estimate.frames.size());
  input.map = MakeTagMap(TagGrid());
  if (truth) input.truth = SmoothTruth(5, 100);
  input.rows = CompareMethods(estimate, input.truth, {});
  return FormatReport(estimate, input);
}

std::string WithoutComments(const std::string& html) {
  std::string out;
  for (size_t at = 0; at < html.size();) {
    const size_t start = std::min(html.find("<!--", at), html.size());
    out += html.substr(at, start - at);
    at = start == html.size() ? start : html.find("-->", start) + 3;
  }
  for (size_t at; (at = out.find("/*! @license")) != std::string::npos;) {
    out.erase(at, out.find("*/", at) + 2 - at);
  }
  return out;
}

size_t Count(const std::string& text, const std::string& what) {
  size_t count = 0;
  for (size_t at = 0; (at = text.find(what, at)) != std::string::npos; ++at) ++count;
  return count;
}

nlohmann::json Data(const std::string& html) {
  const std::string start = "<script type=\"application/json\" id=\"data\">";
  const size_t from = html.find(start) + start.size();
  return nlohmann::json::parse(html.substr(from, html.find("</script>", from) - from));
}

TEST(Report, RefersToNothingOutside) {
  const std::string html = WithoutComments(Report(SyntheticEstimate(90, true)));
  EXPECT_EQ(Count(html, "http://"), 0u);
  EXPECT_EQ(Count(html, "https://"), 0u);
  for (const char* attribute : {" src=", " href=", "url(", "@import", "sourceMappingURL"}) {
    EXPECT_EQ(Count(html.substr(0, html.find("<script>")), attribute), 0u) << attribute;
  }
  EXPECT_EQ(Count(html, "//# sourceMappingURL"), 0u);
}

TEST(Report, ElementsAreClosedAndNamesEscaped) {
  const std::string html = Report(SyntheticEstimate(90, true));
  const std::string page = html.substr(0, html.find("<script"));
  for (const char* tag : {"section", "table", "thead", "tbody", "tr", "td", "th", "div", "svg", "p",
                          "h2", "button", "text", "style", "noscript"}) {
    const std::regex open("<" + std::string(tag) + "[ >]");
    const auto opened = std::distance(std::sregex_iterator(page.begin(), page.end(), open), {});
    EXPECT_EQ(static_cast<size_t>(opened), Count(page, "</" + std::string(tag) + ">")) << tag;
    EXPECT_GT(opened, 0) << tag;
  }
  EXPECT_EQ(Count(html, "<b>figure8"), 0u);
  EXPECT_EQ(Count(page, "&lt;b&gt;figure8&lt;/b&gt; &amp; more"), 2u);  // title and heading
  EXPECT_EQ(Count(html, "</script>"), 3u);
}

TEST(Report, SaysHowGoodItIsAndWarns) {
  const std::string html = Report(SyntheticEstimate(90, true));
  EXPECT_NE(html.find("Pose and twist of the body for 88 of 90 frames"), std::string::npos);
  EXPECT_NE(html.find("images/000017.png: cannot decode"), std::string::npos);
  EXPECT_NE(html.find("Against ground truth (88 frames): position"), std::string::npos);
  EXPECT_NE(html.find("closed form (RANSAC + low-pass)"), std::string::npos);
  EXPECT_NE(html.find("each frame's tags alone"), std::string::npos);
  const std::string without = Report(SyntheticEstimate(90, false), false);
  EXPECT_NE(without.find("There is no ground truth"), std::string::npos);
  EXPECT_EQ(without.find("Position error"), std::string::npos);
}

TEST(Report, SaysWhyFramesHaveNoState) {
  Estimate estimate = SyntheticEstimate(90, true);
  for (size_t i = 0; i < 7; ++i) {
    estimate.frames[i].status = FrameStatus::kNoFix;
    estimate.frames[i].n_tags = i < 3 ? 0 : 1;  // a lone tag, whose mirrored pose fits as well
  }
  estimate.frames[40].status = FrameStatus::kNoFix;
  const std::string html = Report(estimate);
  EXPECT_NE(html.find(" 3 frames before the first tag have no state."), std::string::npos);
  EXPECT_NE(html.find(" In 5 frames the tags left two attitudes open: they have no state."),
            std::string::npos);
}

TEST(Report, PlotsHoldTheStatesAndTheirBands) {
  const Estimate estimate = SyntheticEstimate(90, false);
  const auto data = Data(Report(estimate));
  const auto& x = data["plots"][0];  // closed form, ground truth, optimised
  ASSERT_EQ(x["series"].size(), 3u);
  EXPECT_EQ(data["slots"][x["series"][2]["slot"].get<size_t>()], "optimised");
  ASSERT_EQ(x["t"].size(), 90u);
  const FrameEstimate& f = estimate.frames[50];
  EXPECT_NEAR(x["t"][50], ToSeconds(f.t_ns - estimate.frames[0].t_ns), 1e-4);
  EXPECT_NEAR(x["series"][2]["v"][50], f.state.world_from_body.translation().x(), 1e-5);
  EXPECT_NEAR(x["series"][2]["w"][50], 3 * std::sqrt(f.covariance(3, 3)), 1e-5);
  EXPECT_TRUE(x["series"][0]["v"][39].is_null()) << "frame 39 has no tag, hence no closed form";
  EXPECT_EQ(data["plots"].size(), 12u + 12u + 2u + 2u + 1u);
}

TEST(Report, AnEstimateOfNothingStillMakesAPage) {
  EXPECT_NE(Report(Estimate(), false).find("0 of 0 frames"), std::string::npos);
}

// Extremes of every series stay, ends too, and the order.
TEST(Thinning, KeepsEveryPeak) {
  Plot plot;
  plot.series.resize(2);
  for (int i = 0; i < 50000; ++i) {
    plot.t_s.push_back(i);
    plot.series[0].values.push_back(i == 33333 ? 9 : std::sin(0.01 * i));
    plot.series[1].values.push_back(i == 12345 ? -9 : std::nan(""));
  }
  const auto indices = ThinnedIndices(plot, 4000);
  EXPECT_LE(indices.size(), 4000u);
  EXPECT_GT(indices.size(), 1500u);
  EXPECT_TRUE(std::is_sorted(indices.begin(), indices.end()));
  EXPECT_EQ(indices.front(), 0u);
  EXPECT_EQ(indices.back(), 49999u);
  EXPECT_TRUE(std::binary_search(indices.begin(), indices.end(), 33333u));
  EXPECT_TRUE(std::binary_search(indices.begin(), indices.end(), 12345u));
  EXPECT_EQ(ThinnedIndices(plot, 50000).size(), 50000u);
}

TEST(Plots, AngleRatesAreTheNumericDerivative) {
  const Eigen::Vector3d angles(0.4, -0.7, 2.1);
  const Eigen::Quaterniond q = RotationFromZxy(angles);
  Eigen::Matrix3d numeric;
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d h = 1e-6 * Eigen::Vector3d::Unit(i);
    numeric.col(i) = (ZxyFromRotation(q * ExpSo3(h)) - ZxyFromRotation(q * ExpSo3(-h))) / 2e-6;
  }
  EXPECT_LT((ZxyRatesFromBodyRates(angles) - numeric).norm(), 1e-8);
}

TEST(Plots, YawRunsOnThroughTheTurn) {
  PlotInput input;
  PlottedSeries turning;
  for (int i = 0; i < 100; ++i) {
    input.stamps_ns.push_back(i * 20'000'000);
    turning.series.push_back({input.stamps_ns.back(),
                              MakePose(ExpSo3({0, 0, 0.1 * i}), Eigen::Vector3d::Zero()),
                              std::nullopt, std::nullopt});
  }
  input.series = {turning};
  for (const ReportSection& section : TrajectorySections(input)) {
    if (section.title != "Attitude") continue;
    const auto& yaw = section.plots[2].series[0].values;
    EXPECT_NEAR(yaw.back() - yaw.front(), 9.9 * 180 / M_PI, 1e-9);
    return;
  }
  FAIL() << "no section of attitudes";
}

TEST(Pictures, HistogramOfNothingIsNothing) {
  EXPECT_EQ(HistogramSvg({}, "px"), "");
  EXPECT_EQ(Count(HistogramSvg({1, 2, 3, 50}, "px"), "<rect"), 40u);
}

// The IMU has a section where one was asked for: what it told, or why it is left out.
TEST(Report, TellsOfTheImu) {
  Estimate estimate = SyntheticEstimate(30, true);
  EXPECT_EQ(Count(Report(estimate), "<h2>IMU</h2>"), 0u);
  estimate.imu.emplace();
  estimate.imu->intervals = 28;
  estimate.imu->gyro_bias_radps = {0.012, -0.034, 0};
  estimate.imu->gyro_bias_sigma_radps = {0.001, 0.002, 0.003};
  std::string html = Report(estimate);
  EXPECT_EQ(Count(html, "<h2>IMU</h2>"), 1u);
  EXPECT_NE(html.find("over 28 intervals"), std::string::npos);
  EXPECT_NE(html.find("-34.000 \xc2\xb1 2.000"), std::string::npos);
  estimate.imu.reset();
  estimate.warnings.push_back(ImuLeftOut("it covers nothing"));
  html = Report(estimate);
  EXPECT_EQ(Count(html, "<h2>IMU</h2>"), 1u);
  EXPECT_NE(html.find("Left out: it covers nothing."), std::string::npos);
}

}  // namespace
}  // namespace tagtwist::internal::report_test

// What is published of a frame, as JSON.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <sstream>

#include "estimator/publish/foxglove_messages.h"
#include "estimator/publish/live_verdict.h"
#include "estimator/publish/page.h"
#include "estimator/publish/picture_json.h"
#include "estimator/publish/state_json.h"
#include "estimator/report/files/states_csv.h"

namespace tagtwist::internal::messages_test {
namespace {

using Json = nlohmann::json;

PublishedRun AnyRun() {
  PublishedRun run;
  run.set_up = MakeSetUp(Camera(), Pose(), MakeTagMap(TagGrid()));
  run.dataset = "</script><b>";
  return run;
}

// A camera over the middle of the mat that looks down.
PublishedFrame Frame(const PublishedRun& run, int64_t t_ns = 1'234'567'890'123'456'789) {
  PublishedFrame frame;
  FrameEstimate& state = frame.bodies.front().state;
  frame.images = {{0, cv::Mat()}};
  state.t_ns = t_ns;
  state.status = FrameStatus::kOk;
  state.state.world_from_body =
      MakePose(Eigen::Quaterniond(0, -1, 0.001, 0).normalized(), {1.7123456789123, 1.3, 1.2});
  state.state.twist.v_world = {0.1, -1e-7, 3};
  state.state.twist.omega_body = {1.0 / 3, 0, -2};
  const Eigen::Matrix<double, 12, 1> sigmas = Eigen::Matrix<double, 12, 1>::LinSpaced(0.001, 0.012);
  state.covariance = sigmas.cwiseAbs2().asDiagonal();
  state.covariance(0, 1) = state.covariance(1, 0) = 1e-7;
  state.n_tags = 2;
  const Camera& camera = run.set_up.rig.front().camera;
  for (const int id : {52, 53}) {
    TagDetection tag;
    tag.id = id;
    for (size_t c = 0; c < 4; ++c) {
      EXPECT_TRUE(camera.Project(
          Inverse(state.state.world_from_body) * run.set_up.map.CornersInWorld(id)[c],
          &tag.corners[c]));
    }
    frame.bodies.front().tags.push_back(tag);
    frame.bodies.front().used_tags.push_back(id);
  }
  return frame;
}

std::vector<std::string> Cells(const std::string& row) {
  std::vector<std::string> out;
  std::istringstream in(row);
  for (std::string cell; std::getline(in, cell, ',');) out.push_back(cell);
  return out;
}

TEST(StateJson, HasTheNumbersOfStatesCsv) {
  const PublishedRun run = AnyRun();
  const PublishedFrame frame = Frame(run);
  const std::string text = StateJson(run, frame);
  const Json json = Json::parse(text);
  const auto cells = Cells(FormatStatesRow(frame.bodies[0].state));
  size_t column = 1;
  for (const char* key : {"position", "orientation", "linear_velocity", "angular_velocity"}) {
    for (const Json& value : json[key]) EXPECT_EQ(value.get<double>(), std::stod(cells[column++]));
  }
  EXPECT_EQ(column, 14u);
  column = 27;
  for (const Json& value : json["sigma"]) {
    EXPECT_EQ(value.get<double>(), std::stod(cells[column++]));
  }
  EXPECT_EQ(column, 39u);
  ASSERT_EQ(json["covariance"].size(), 78u);
  EXPECT_DOUBLE_EQ(json["covariance"][1].get<double>(), 1e-7);
  EXPECT_NE(text.find("\"t\":1234567890.123456789,"), std::string::npos);
  EXPECT_EQ(json["stamp"]["sec"], 1234567890);
  EXPECT_EQ(json["stamp"]["nsec"], 123456789);
  EXPECT_EQ(json["status"], "ok");
}

TEST(StateJson, AFrameWithoutAStateHasNone) {
  const PublishedRun run = AnyRun();
  PublishedFrame frame = Frame(run, -1);
  frame.bodies[0].state.status = FrameStatus::kNoFix;
  const Json json = Json::parse(StateJson(run, frame));
  EXPECT_TRUE(json["position"].is_null());
  EXPECT_TRUE(json["covariance"].is_null());
  EXPECT_EQ(json["stamp"]["sec"], -1);
  EXPECT_EQ(json["stamp"]["nsec"], 999999999);
  EXPECT_EQ(NumberMessages(run, frame, {"{}"}).size(), 1u);
}

TEST(FoxgloveMessages, AreJsonWithTheNumbersOfTheState) {
  const PublishedRun run = AnyRun();
  const PublishedFrame frame = Frame(run);
  const auto messages = NumberMessages(run, frame, StateJsons(run, frame));
  ASSERT_EQ(messages.size(), 4u);
  const Json pose = Json::parse(messages[1].json), twist = Json::parse(messages[2].json);
  EXPECT_EQ(pose["pose"]["position"]["x"].get<double>(), 1.712345679);
  EXPECT_EQ(twist["angular"]["z"].get<double>(), -2);
  const Json transforms = Json::parse(messages[3].json)["transforms"];
  ASSERT_EQ(transforms.size(), 2u);
  EXPECT_EQ(transforms[0]["parent_frame_id"], "world");
  EXPECT_EQ(transforms[1]["child_frame_id"], "cam0");
  const Json map = Json::parse(MapMessage(run, 5).json);
  EXPECT_EQ(map["entities"][0]["lines"][0]["points"].size(), 108u * 8);
  EXPECT_EQ(map["entities"][0]["texts"].size(), 108u);
  EXPECT_EQ(Json::parse(ImageMessage(run, 0, 5, "\xff\xd8").json)["data"], "/9g=");
}

TEST(FoxgloveMessages, Base64OfRfc4648) {
  for (const auto& [plain, coded] : {std::pair("", ""),
                                     {"f", "Zg=="},
                                     {"fo", "Zm8="},
                                     {"foo", "Zm9v"},
                                     {"foobar", "Zm9vYmFy"}}) {
    EXPECT_EQ(Base64(plain), coded);
  }
}

TEST(PictureNumbers, TagsAreWhereTheStateHasThem) {
  const PublishedRun run = AnyRun();
  PublishedFrame frame = Frame(run);
  frame.bodies[0].tags[1].corners[0].x() += 30;
  frame.bodies[0].used_tags.pop_back();
  const Json json = Json::parse(PictureNumbers(run).Json(frame, 0));
  ASSERT_EQ(json["seen"].size(), 2u);
  EXPECT_TRUE(json["seen"][0]["used"].get<bool>());
  EXPECT_FALSE(json["seen"][1]["used"].get<bool>());
  EXPECT_NE(json["seen"][1]["why"].get<std::string>().find("mm from where the map has it"),
            std::string::npos);
  int found = 0;
  for (const Json& tag : json["map"]) {
    if (tag["id"] != 52) continue;
    ++found;
    double middle = 0;
    for (size_t i = 0; i < 8; ++i) {
      const double seen = json["seen"][0]["corners"][i].get<double>();
      EXPECT_NEAR(tag["corners"][i].get<double>(), seen, 1e-3);
      middle += i % 2 == 0 ? 0.25 * seen : 0;
    }
    EXPECT_NEAR(tag["axes"][0].get<double>(), middle, 0.5);
  }
  EXPECT_EQ(found, 1);
  frame.bodies[0].state.status = FrameStatus::kNoFix;
  EXPECT_TRUE(Json::parse(PictureNumbers(run).Json(frame, 0))["map"].empty());
}

TEST(LiveVerdict, SaysWhatSpeaksAgainstIt) {
  const PublishedRun run = AnyRun();
  const PictureNumbers numbers(run);
  LiveVerdict verdict;
  EXPECT_EQ(verdict.Text(), "No frame has come yet.");
  PublishedFrame frame = Frame(run, 0);
  for (int i = 0; i < 30; ++i) {
    frame.bodies[0].state.t_ns += 20'000'000;
    verdict.Add(frame, 0, numbers);
  }
  EXPECT_EQ(verdict.Text(), "Nothing in the last seconds speaks against it.");
  EXPECT_NEAR(verdict.RateHz(), 50, 1e-6);
  EXPECT_TRUE(verdict.Aside().empty());
  frame.bodies[0].tags[1].corners[0].x() += 30;
  frame.bodies[0].used_tags.pop_back();
  for (int i = 0; i < 30; ++i) {
    frame.bodies[0].state.t_ns += 20'000'000;
    verdict.Add(frame, 0, numbers);
  }
  ASSERT_EQ(verdict.Aside().size(), 1u);
  EXPECT_EQ(verdict.Aside()[0].id, 53);
  EXPECT_EQ(verdict.Text().rfind("Not to be relied on as it is: tag 53 lies", 0), 0u)
      << verdict.Text();
  frame.bodies[0].state.status = FrameStatus::kNoFix;
  frame.bodies[0].tags.clear();
  verdict.Add(frame, 0, numbers);
  EXPECT_EQ(verdict.Text(), "No state: no tag of the map is in view.");
  LiveVerdicts verdicts(run);
  verdicts.Add(frame, numbers);
  const Json facts = Json::parse(verdicts.FactsJson(frame, "null"));
  EXPECT_EQ(facts["status"]["body"], "no_fix");
  EXPECT_EQ(facts["verdict"], verdict.Text());
}

TEST(LivePage, IsOneFileThatFetchesNothing) {
  const std::string page = LivePage();
  EXPECT_EQ(page.find("/*live."), std::string::npos);
  EXPECT_EQ(page.find("src="), std::string::npos);
  EXPECT_EQ(page.find("http"), page.find("https:\""));  // what it compares its own address with
  EXPECT_EQ(page.find("@import"), std::string::npos);
  const std::string set_up = SetUpJson(AnyRun(), true);
  EXPECT_EQ(set_up.find('<'), std::string::npos);
  EXPECT_EQ(Json::parse(set_up)["dataset"], "</script><b>");
  EXPECT_EQ(Json::parse(set_up)["tags"].size(), 108u);
}

}  // namespace
}  // namespace tagtwist::internal::messages_test

// Several bodies and cameras, each by its name.
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "estimator/publish/foxglove_messages.h"
#include "estimator/publish/live_verdict.h"
#include "estimator/publish/page.h"
#include "estimator/publish/picture_json.h"
#include "estimator/publish/publisher.h"
#include "estimator/publish/state_json.h"
#include "tests/support/temp_folder.h"
#include "tests/support/test_files.h"

namespace tagtwist::internal::several_test {
namespace {

using Json = nlohmann::json;

TagMap Board(int id) { return {"tag36h11", {Tag{id, Pose(), 0.2}}}; }

// Two cameras that look at where they both are, 1 m in front of the world's origin.
PublishedRun AnyRun(MountedOn mounted_on) {
  PublishedRun run;
  run.set_up = MakeSetUp(Camera(), Pose(), Board(0));
  run.set_up.rig.mounted_on = mounted_on;
  run.set_up.rig.cameras.push_back(run.set_up.rig.front());
  run.set_up.rig.cameras[1].name = "right";
  run.set_up.rig.cameras[1].cam_from_body = MakePose(Eigen::Quaterniond::Identity(), {0.1, 0, 0});
  run.others = {{"toy", Board(1)}, {"cup", Board(2)}};
  return run;
}

SeenBody At(const Eigen::Vector3d& place, const Eigen::Quaterniond& attitude) {
  SeenBody out;
  out.state.t_ns = 5;
  out.state.status = FrameStatus::kOk;
  out.state.state.world_from_body = MakePose(attitude, place);
  out.state.covariance.setIdentity();
  return out;
}

// Tags face the camera that looks along z.
PublishedFrame Frame(const PublishedRun& run) {
  const Eigen::Quaterniond facing(0, 1, 0, 0), turned(0.9, 0.1, -0.2, 0.05);
  const bool stands = run.set_up.rig.mounted_on == MountedOn::kWorld;
  PublishedFrame frame;
  frame.images = {{1, cv::Mat(240, 376, CV_8UC1, cv::Scalar(9))}};
  frame.bodies = {stands ? At({0.05, 0, 1}, facing) : At({0, 0.05, 1}, facing),
                  At({-0.1, 0.1, stands ? 1.2 : 0.1}, stands ? facing : turned.normalized()),
                  At({}, facing)};
  frame.bodies[2].state.status = FrameStatus::kNoFix;
  return frame;
}

// What a camera sees of a tag of the run, by hand.
std::vector<double> Seen(const PublishedRun& run, const PublishedFrame& frame, size_t body) {
  const RigCamera& camera = run.set_up.rig.cameras[1];
  const Pose first = frame.bodies[0].state.state.world_from_body;
  const Pose world_from_map =
      run.TagsMove(body) ? frame.bodies[body].state.state.world_from_body : Pose();
  const Pose cam_from_world =
      run.TagsMove(0) ? camera.cam_from_body : camera.cam_from_body * Inverse(first);
  std::vector<double> out;
  const TagMap map = run.SetUpOf(body).map;
  for (const Eigen::Vector3d& corner : map.CornersInWorld(static_cast<int>(body))) {
    Eigen::Vector2d pixel;
    EXPECT_TRUE(camera.camera.Project(cam_from_world * (world_from_map * corner), &pixel));
    out.insert(out.end(), {pixel.x(), pixel.y()});
  }
  return out;
}

class Several : public testing::TestWithParam<MountedOn> {};

TEST_P(Several, EachIsNamedInItsTopics) {
  const PublishedRun run = AnyRun(GetParam());
  const bool stands = GetParam() == MountedOn::kWorld;
  const PublishedFrame frame = Frame(run);
  const auto channels = FoxgloveChannels(run);
  std::vector<std::string> topics;
  for (size_t i = 0; i < channels.size(); ++i) {
    EXPECT_EQ(channels[i].id, i + 1);
    topics.push_back(channels[i].topic);
  }
  const std::string of_camera = stands ? "/tagtwist/" : "/tagtwist/body/";
  EXPECT_EQ(topics,
            (std::vector<std::string>{
                "/tf", "/tagtwist/map", "/tagtwist/body/state", "/tagtwist/body/pose",
                "/tagtwist/body/twist", "/tagtwist/toy/state", "/tagtwist/toy/pose",
                "/tagtwist/toy/twist", "/tagtwist/cup/state", "/tagtwist/cup/pose",
                "/tagtwist/cup/twist", of_camera + "cam0/image", of_camera + "right/image"}));
  std::vector<std::string> said;
  for (const auto& message : NumberMessages(run, frame, StateJsons(run, frame))) {
    said.push_back(topics.at(message.channel - 1));
    const Json json = Json::parse(message.json);
    if (said.back() != "/tf") continue;
    ASSERT_EQ(json["transforms"].size(), 4U);  // the cup is nowhere
    EXPECT_EQ(json["transforms"][1]["child_frame_id"], "toy");
    EXPECT_EQ(json["transforms"][3]["parent_frame_id"], stands ? "world" : "body");
    EXPECT_EQ(json["transforms"][3]["child_frame_id"], "right");
  }
  EXPECT_EQ(said, (std::vector<std::string>{topics[2], topics[3], topics[4], topics[5], topics[6],
                                            topics[7], topics[8], "/tf"}));
  const Json state = Json::parse(StateJson(run, frame, 1));
  EXPECT_EQ(state["body"], "toy");
  EXPECT_EQ(state["cameras"], Json({"right"}));
  const auto image = ImageMessage(run, 1, 5, "x");
  EXPECT_EQ(topics.at(image.channel - 1), of_camera + "right/image");
  EXPECT_EQ(Json::parse(image.json)["frame_id"], "right");
  const Json map = Json::parse(MapMessage(run, 0).json)["entities"];
  EXPECT_EQ(map[0]["frame_id"], stands ? "body" : "world");
  EXPECT_EQ(map[2]["frame_id"], "cup");
}

TEST_P(Several, ThePictureOfACameraHasTheTagsWhereItSeesThem) {
  const PublishedRun run = AnyRun(GetParam());
  PublishedFrame frame = Frame(run);
  for (size_t body = 0; body < 2; ++body) {
    const auto corners = Seen(run, frame, body);
    TagDetection tag;
    tag.id = static_cast<int>(body);
    for (size_t c = 0; c < 4; ++c) tag.corners[c] = {corners[2 * c] + 30, corners[2 * c + 1]};
    tag.camera = 1;
    frame.bodies[body].tags = {tag};
  }
  const PictureNumbers numbers(run);
  const Json json = Json::parse(numbers.Json(frame, 1));
  EXPECT_EQ(json["camera"], "right");
  ASSERT_EQ(json["map"].size(), 2U);
  for (size_t body = 0; body < 2; ++body) {
    const auto expected = Seen(run, frame, body);
    for (size_t i = 0; i < 8; ++i) {
      EXPECT_NEAR(json["map"][body]["corners"][i].get<double>(), expected[i], 1e-3) << body;
    }
    EXPECT_EQ(json["seen"][body]["id"], body);
    EXPECT_NE(json["seen"][body]["why"].get<std::string>().find("mm from where"),
              std::string::npos);
  }
  EXPECT_TRUE(Json::parse(numbers.Json(frame, 0))["seen"].empty());

  LiveVerdicts verdicts(run);
  verdicts.Add(frame, numbers);
  EXPECT_NE(verdicts.Text().find("cup: No state: no tag"), std::string::npos) << verdicts.Text();
  EXPECT_EQ(Json::parse(verdicts.FactsJson(frame, "null"))["status"]["cup"], "no_fix");
  const Json set_up = Json::parse(SetUpJson(run, false));
  EXPECT_EQ(set_up["bodies"], Json({"body", "toy", "cup"}));
  EXPECT_EQ(set_up["tags"][0]["on"].is_null(), GetParam() == MountedOn::kBody);
  EXPECT_EQ(set_up["tags"][2]["on"], "cup");
  EXPECT_EQ(set_up["cameras"][1]["stands"].is_null(), GetParam() == MountedOn::kBody);
}

INSTANTIATE_TEST_SUITE_P(MountedOn, Several, testing::Values(MountedOn::kBody, MountedOn::kWorld));

TEST(SeveralNames, OneNameForTwoThingsIsRefused) {
  PublishedRun run = AnyRun(MountedOn::kBody);
  run.others[1].name = "right";
  const auto refused = Publisher::Start(PublishOptions(), run);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().message.rfind("bodies: right is what another body, a camera", 0), 0U);
  run.others[1].name = "body";
  EXPECT_FALSE(Publisher::Start(PublishOptions(), run));
  run.others[1].name = "cup";
  run.set_up.rig.cameras[1].name = "world";
  EXPECT_FALSE(Publisher::Start(PublishOptions(), run));
}

TEST(SeveralRecording, EachCameraHasAFolderWithItsOwnStamps) {
  const TempFolder folder;
  PublishedRun run = AnyRun(MountedOn::kWorld);
  run.set_up.rig.cameras[1].clock_offset_s = -2e-9;
  PublishOptions options;
  options.record = folder / "rec";
  options.waits = true;
  auto publisher = Publisher::Start(options, run);
  ASSERT_TRUE(publisher) << publisher.error().message;
  (*publisher)->Publish(std::make_shared<const PublishedFrame>(Frame(run)));
  EXPECT_EQ((*publisher)->Finish().failure, "");
  const auto lines = [&](const std::string& name) {
    const std::string text = ReadText(folder / ("rec/" + name + "/timestamps.csv"));
    return std::count(text.begin(), text.end(), '\n');
  };
  EXPECT_EQ(lines("cam0"), 1);
  EXPECT_EQ(lines("right"), 2);
  EXPECT_NE(ReadText(folder / "rec/right/timestamps.csv").find("0.000000007"), std::string::npos);

  options.record = folder / "rec.mkv";
  EXPECT_FALSE(Publisher::Start(options, run));
  run.set_up.rig.cameras[1].name = "../elsewhere";
  options.record = folder / "new";
  EXPECT_FALSE(Publisher::Start(options, run));
}

}  // namespace
}  // namespace tagtwist::internal::several_test

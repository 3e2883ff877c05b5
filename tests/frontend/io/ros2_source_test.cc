// ROS 2 bags that are written here record by record, sqlite3 and MCAP: the same recording comes out
// of each, and damaged ones are refused.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "frontend/io/recordings/data_source.h"
#include "tests/support/formats/ros2_writers.h"
#include "tests/support/temp_folder.h"
#include "tests/support/test_files.h"

namespace tagtwist::internal::ros2_source_test {
namespace {

using ::testing::HasSubstr;

class Ros2Bags : public ::testing::Test {
 protected:
  Result<std::unique_ptr<DataSource>> Open(const std::string& name, const std::string& topic = "") {
    DataSourceOptions options;
    options.topic = topic;
    return OpenDataSource(folder_.path() + "/" + name, options);
  }
  void Write(const std::string& name, const std::string& bytes) {
    WriteText(folder_.path() + "/" + name, bytes);
  }
  std::string Refusal(const std::string& name, const std::string& topic = "") {
    const auto source = Open(name, topic);
    return source ? "opened" : source.error().message;
  }
  void ExpectTheRecording(const std::string& name) {
    auto source = Open(name);
    ASSERT_TRUE(source) << source.error().message;
    ASSERT_EQ((*source)->stamps_ns().size(), 5U) << name;
    EXPECT_EQ((*source)->notes().size(), 0U);
    ASSERT_EQ((*source)->ground_truth().size(), 5U);
    EXPECT_EQ((*source)->ground_truth()[3].world_from_body.translation().x(), 3);
    EXPECT_EQ((*source)->truth_origin(), "topic /body");
    ASSERT_EQ((*source)->imu().size(), 5U);
    EXPECT_EQ((*source)->imu()[2].gyro_radps, Eigen::Vector3d(0.1, 0.2, 0.3));
    for (int i = 0; i < 5; ++i) {
      const auto frame = (*source)->Next();
      ASSERT_TRUE(frame && *frame) << name;
      EXPECT_EQ((*frame)->t_ns, 10'000'000'000 + 100'000'000LL * i);
      ASSERT_EQ((*frame)->image.size(), cv::Size(kRos2Width, kRos2Height));
      EXPECT_EQ((*frame)->image.at<uint8_t>(2, 3), 10 * i);
    }
    const auto end = (*source)->Next();
    EXPECT_TRUE(end && !*end);
  }

  const TempFolder folder_;
};

TEST_F(Ros2Bags, SqliteAndEveryMcapGiveTheSameRecording) {
  WriteSqlite(folder_.path() + "/r.db3", Ros2Recording());
  ExpectTheRecording("r.db3");
  for (const char* compression : {"none", "plain", "lz4", "zstd"}) {
    Write(std::string(compression) + ".mcap", Mcap(compression, Ros2Recording()));
    ExpectTheRecording(std::string(compression) + ".mcap");
  }
}

TEST_F(Ros2Bags, AFolderOfFilesIsOneRecording) {
  const std::vector<Message> all = Ros2Recording();
  std::filesystem::create_directory(folder_.path() + "/bag");
  Write("bag/metadata.yaml", "rosbag2_bagfile_information:\n  version: 5\n");
  WriteSqlite(folder_.path() + "/bag/r_0.db3", {all.begin(), all.begin() + 6});
  WriteSqlite(folder_.path() + "/bag/r_1.db3", {all.begin() + 6, all.end()});
  ExpectTheRecording("bag");
}

TEST_F(Ros2Bags, ARepeatedStampIsPassedOverAndCounted) {
  std::vector<Message> messages = Ros2Recording();
  Message again = messages[3];
  again.arrival_ns += 1;
  messages.insert(messages.begin() + 4, again);
  Write("x.mcap", Mcap("zstd", messages));
  auto source = Open("x.mcap");
  ASSERT_TRUE(source);
  EXPECT_EQ((*source)->stamps_ns().size(), 5U);
  ASSERT_EQ((*source)->notes().size(), 1U);
  EXPECT_THAT((*source)->notes()[0], HasSubstr("passed over 1 of 6 messages on /cam"));
  for (int i = 0; i < 5; ++i) EXPECT_EQ((*(*source)->Next())->image.at<uint8_t>(0, 0), 10 * i);
}

TEST_F(Ros2Bags, AMistypedTopicIsTold) {
  Write("x.mcap", Mcap("none", Ros2Recording()));
  EXPECT_THAT(Refusal("x.mcap", "/cma"), HasSubstr("did you mean /cam?"));
}

TEST_F(Ros2Bags, ATopicThatATerminalWouldObeyIsToldWithoutThat) {
  std::string bag = Mcap("none", Ros2Recording());
  for (size_t at = 0; (at = bag.find("/cam", at)) != std::string::npos;) {
    bag.replace(at, 4, "\x1b[\nJ");
  }
  Write("x.mcap", bag);
  EXPECT_THAT(Refusal("x.mcap", "/other"), HasSubstr("expected one of ?[?J"));
}

TEST_F(Ros2Bags, DamagedOnesAreRefused) {
  const std::string good = Mcap("zstd", Ros2Recording());
  Write("cut.mcap", good.substr(0, good.size() / 2));
  EXPECT_THAT(Refusal("cut.mcap"), HasSubstr("cut or was not ended"));
  std::string flipped = Mcap("plain", Ros2Recording());
  flipped[400] = static_cast<char>(flipped[400] ^ 1);
  Write("flipped.mcap", flipped);
  EXPECT_NE(Refusal("flipped.mcap"), "opened");
  for (size_t at = 8; at < good.size() - 8; at += 7) {  // whatever byte is bad: no crash
    std::string bad = good;
    bad[at] = static_cast<char>(bad[at] ^ 0x55);
    Write("bad.mcap", bad);
    auto source = Open("bad.mcap");
    for (int i = 0; source && i < 10; ++i) {
      const auto frame = (*source)->Next();
      if (!frame || !*frame) break;
    }
  }
  WriteSqlite(folder_.path() + "/r.db3", Ros2Recording());
  const std::string database = ReadText(folder_.path() + "/r.db3");
  Write("cut.db3", database.substr(0, database.size() / 3));
  EXPECT_NE(Refusal("cut.db3"), "opened");
}

TEST_F(Ros2Bags, AChunkThatUnpacksToAThousandTimesItsSizeIsRefused) {
  for (const char* compression : {"lz4", "zstd"}) {
    const std::string zeros = Record(0x7F, std::string(80'000'000, '\0'));
    std::string bytes = Mcap(compression, Ros2Recording());
    bytes.insert(8, Chunk(compression, zeros));
    Write("bomb.mcap", bytes);
    EXPECT_THAT(Refusal("bomb.mcap"), HasSubstr("a chunk that says it unpacks to"));
  }
}

// A length that says more than there is must not be believed.
TEST_F(Ros2Bags, AHostileMessageIsABadImage) {
  std::vector<Message> messages = Ros2Recording();
  std::string& data = messages[0].data;
  const size_t length = data.size() - kRos2Width * kRos2Height - 4;
  for (size_t i = 0; i < 4; ++i) data[length + i] = '\xFF';
  Write("x.mcap", Mcap("none", messages));
  auto source = Open("x.mcap");
  ASSERT_TRUE(source) << source.error().message;
  const auto frame = (*source)->Next();
  ASSERT_TRUE(frame && *frame);
  EXPECT_EQ((*frame)->image_problem, "cannot decode");
}

// Corners of both detectors' messages: apriltag's count pixels from their edges, from the bottom
// left against the clock; isaac_ros' begin at the top left and run with the clock.
TEST_F(Ros2Bags, DetectionsOfEitherDetectorAreTags) {
  for (const bool isaac : {false, true}) {
    std::vector<Message> messages;
    for (int i = 0; i < 3; ++i) {
      Ros2Writer out;
      out.Header(10 + 0.1 * i) << uint32_t{2};
      for (const int id : {4, 7}) {
        out << std::string("tag36h11") << int32_t{id};
        if (!isaac) out << int32_t{0} << 1.0F << 2.0F;
        out.Zeros(isaac ? 3 : 2);
        for (int corner = 0; corner < 4; ++corner) {
          out << 100.5 + (isaac ? 3 - corner : corner) << 50.5 + i;
          if (isaac) out << 0.0;
        }
        if (isaac) out.Header(10 + 0.1 * i).Zeros(7 + 36);
        if (!isaac) out.Zeros(9);
      }
      messages.push_back({"/cam",
                          isaac ? "isaac_ros_apriltag_interfaces/msg/AprilTagDetectionArray"
                                : "apriltag_msgs/msg/AprilTagDetectionArray",
                          std::llround(1e9 * (10 + 0.1 * i)), out.Data()});
    }
    Write("tags.mcap", Mcap("zstd", messages));
    DataSourceOptions options;
    options.use_detections = true;
    auto source = OpenDataSource(folder_.path() + "/tags.mcap", options);
    ASSERT_TRUE(source) << source.error().message;
    for (int i = 0; i < 3; ++i) {
      const auto frame = (*source)->Next();
      ASSERT_TRUE(frame && *frame);
      ASSERT_EQ((*frame)->detections.size(), 2u) << isaac;
      EXPECT_EQ((*frame)->detections[1].id, 7);
      const double edge_px = isaac ? 0 : 0.5;
      EXPECT_EQ((*frame)->detections[1].corners[3],
                Eigen::Vector2d(103.5 - edge_px, 50.5 + i - edge_px));
    }
  }
}

// Transforms are truth where one of their frames is asked for; else a note says how.
TEST_F(Ros2Bags, TransformsOfAFrameAreTruth) {
  std::vector<Message> messages;
  for (int i = 0; i < 4; ++i) {
    const double t_s = 10 + 0.1 * i;
    messages.push_back({"/cam", "sensor_msgs/msg/Image", std::llround(1e9 * t_s),
                        Ros2Image(t_s, static_cast<uint8_t>(i))});
    Ros2Writer out;
    out << uint32_t{2};
    for (const std::string child : {"gripper", "base_link"}) {
      out.Header(t_s) << child << (child == "base_link" ? 1.0 * i : -1.0) << 2.0 << 3.0 << 0.0
                      << 0.0 << 0.0 << 1.0;
    }
    messages.push_back({"/body", "tf2_msgs/msg/TFMessage", std::llround(1e9 * t_s), out.Data()});
  }
  Write("tf.mcap", Mcap("lz4", messages));
  auto untold = Open("tf.mcap");
  ASSERT_TRUE(untold) << untold.error().message;
  EXPECT_TRUE((*untold)->ground_truth().empty());
  ASSERT_EQ((*untold)->notes().size(), 1u);
  EXPECT_THAT((*untold)->notes()[0], HasSubstr("--truth_topic /body:CHILD"));
  DataSourceOptions options;
  options.truth_topic = "/body:base_link";
  auto source = OpenDataSource(folder_.path() + "/tf.mcap", options);
  ASSERT_TRUE(source) << source.error().message;
  ASSERT_EQ((*source)->ground_truth().size(), 4u);
  EXPECT_EQ((*source)->ground_truth()[3].world_from_body.translation(), Eigen::Vector3d(3, 2, 3));
  options.truth_topic = "/body:base";
  const auto wrong = OpenDataSource(folder_.path() + "/tf.mcap", options);
  ASSERT_FALSE(wrong);
  EXPECT_THAT(wrong.error().message, HasSubstr("expected one of base_link, gripper"));
}

}  // namespace
}  // namespace tagtwist::internal::ros2_source_test

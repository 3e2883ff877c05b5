// ROS 2 bags that are written here record by record, sqlite3 and MCAP: the same recording comes out
// of each, and damaged ones are refused.
#include <fastcdr/Cdr.h>
#include <fastcdr/FastBuffer.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "frontend/io/recordings/data_source.h"
#include "tests/support/ros2_writers.h"
#include "tests/support/temp_folder.h"
#include "tests/support/test_files.h"

namespace tagtwist::ros2_source_test {
namespace {

using eprosima::fastcdr::Cdr;
using eprosima::fastcdr::FastBuffer;
using ::testing::HasSubstr;

constexpr int kWidth = 8, kHeight = 6;

class Writer {
 public:
  Writer() : cdr_(buffer_, Cdr::DEFAULT_ENDIAN, Cdr::DDS_CDR) { cdr_.serialize_encapsulation(); }
  template <typename Value>
  Writer& operator<<(const Value& value) {
    cdr_.serialize(value);
    return *this;
  }
  Writer& Header(double t_s) {
    const auto whole = static_cast<int32_t>(t_s);
    return *this << whole << static_cast<uint32_t>(std::llround(1e9 * (t_s - whole)))
                 << std::string("cam");
  }
  Writer& Zeros(int count) {
    for (int i = 0; i < count; ++i) *this << 0.0;
    return *this;
  }
  std::string Data() { return {buffer_.getBuffer(), cdr_.getSerializedDataLength()}; }

 private:
  FastBuffer buffer_;
  Cdr cdr_;
};

std::string Image(double t_s, uint8_t grey) {
  Writer out;
  out.Header(t_s) << uint32_t{kHeight} << uint32_t{kWidth} << std::string("mono8") << uint8_t{0}
                  << uint32_t{kWidth} << std::vector<uint8_t>(kWidth * kHeight, grey);
  return out.Data();
}
std::string PoseMessage(double t_s, double x) {
  Writer out;
  out.Header(t_s) << x << 2.0 << 3.0 << 0.0 << 0.0 << 0.0 << 1.0;
  return out.Data();
}
std::string Imu(double t_s) {
  Writer out;
  out.Header(t_s).Zeros(13) << 0.1 << 0.2 << 0.3;
  out.Zeros(9) << 1.0 << 2.0 << 9.8;
  out.Zeros(9);
  return out.Data();
}

std::vector<Message> Recording() {
  std::vector<Message> out;
  for (int i = 0; i < 5; ++i) {
    const double t_s = 10 + 0.1 * i;
    const int64_t arrival_ns = std::llround(1e9 * t_s) + 1000;
    out.push_back(
        {"/cam", "sensor_msgs/msg/Image", arrival_ns, Image(t_s, static_cast<uint8_t>(10 * i))});
    out.push_back({"/body", "geometry_msgs/msg/PoseStamped", arrival_ns, PoseMessage(t_s, i)});
    out.push_back({"/imu", "sensor_msgs/msg/Imu", arrival_ns, Imu(t_s)});
  }
  return out;
}

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
      ASSERT_EQ((*frame)->image.size(), cv::Size(kWidth, kHeight));
      EXPECT_EQ((*frame)->image.at<uint8_t>(2, 3), 10 * i);
    }
    const auto end = (*source)->Next();
    EXPECT_TRUE(end && !*end);
  }

  const TempFolder folder_;
};

TEST_F(Ros2Bags, SqliteAndEveryMcapGiveTheSameRecording) {
  WriteSqlite(folder_.path() + "/r.db3", Recording());
  ExpectTheRecording("r.db3");
  for (const char* compression : {"none", "plain", "lz4", "zstd"}) {
    Write(std::string(compression) + ".mcap", Mcap(compression, Recording()));
    ExpectTheRecording(std::string(compression) + ".mcap");
  }
}

TEST_F(Ros2Bags, AFolderOfFilesIsOneRecording) {
  const std::vector<Message> all = Recording();
  std::filesystem::create_directory(folder_.path() + "/bag");
  Write("bag/metadata.yaml", "rosbag2_bagfile_information:\n  version: 5\n");
  WriteSqlite(folder_.path() + "/bag/r_0.db3", {all.begin(), all.begin() + 6});
  WriteSqlite(folder_.path() + "/bag/r_1.db3", {all.begin() + 6, all.end()});
  ExpectTheRecording("bag");
}

TEST_F(Ros2Bags, ARepeatedStampIsPassedOverAndCounted) {
  std::vector<Message> messages = Recording();
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
  Write("x.mcap", Mcap("none", Recording()));
  EXPECT_THAT(Refusal("x.mcap", "/cma"), HasSubstr("did you mean /cam?"));
}

TEST_F(Ros2Bags, DamagedOnesAreRefused) {
  const std::string good = Mcap("zstd", Recording());
  Write("cut.mcap", good.substr(0, good.size() / 2));
  EXPECT_THAT(Refusal("cut.mcap"), HasSubstr("cut or was not ended"));
  std::string flipped = Mcap("plain", Recording());
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
  WriteSqlite(folder_.path() + "/r.db3", Recording());
  const std::string database = ReadText(folder_.path() + "/r.db3");
  Write("cut.db3", database.substr(0, database.size() / 3));
  EXPECT_NE(Refusal("cut.db3"), "opened");
}

// A length that says more than there is must not be believed.
TEST_F(Ros2Bags, AHostileMessageIsABadImage) {
  std::vector<Message> messages = Recording();
  std::string& data = messages[0].data;
  const size_t length = data.size() - kWidth * kHeight - 4;
  for (size_t i = 0; i < 4; ++i) data[length + i] = '\xFF';
  Write("x.mcap", Mcap("none", messages));
  auto source = Open("x.mcap");
  ASSERT_TRUE(source) << source.error().message;
  const auto frame = (*source)->Next();
  ASSERT_TRUE(frame && *frame);
  EXPECT_EQ((*frame)->image_problem, "cannot decode");
}

}  // namespace
}  // namespace tagtwist::ros2_source_test

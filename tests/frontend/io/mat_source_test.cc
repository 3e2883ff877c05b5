// What the reader of course .mat files accepts and refuses.
#include <gtest/gtest.h>

#include <cmath>

#include "frontend/io/mat/mat_file.h"
#include "tests/support/formats/mat_fixture.h"
#include "tests/support/sanitizers.h"

namespace tagtwist::internal::mat_source_test {
namespace {

constexpr std::array<std::pair<bool, mat_ft>, 4> kKinds = {
    {{true, MAT_FT_MAT5}, {false, MAT_FT_MAT5}, {true, MAT_FT_MAT73}, {false, MAT_FT_MAT73}}};

TEST_F(MatSource, ReadsPackets) {
  for (const auto& [compressed, version] : kKinds) {
    builder_.AddPackets({Packet(0.5), Packet(0.75, 0), Packet(1, 1)});
    builder_.Write(path_, compressed, version);
    const auto frames = Frames();
    ASSERT_EQ(frames.size(), 3u);
    EXPECT_EQ(frames[0].t_ns, 500'000'000);
    EXPECT_EQ(frames[0].name, path_ + ": data(1)");
    ASSERT_EQ(frames[0].detections.size(), 2u);
    EXPECT_EQ(frames[0].detections[1].id, 5);
    EXPECT_EQ(frames[0].detections[1].corners[0], Eigen::Vector2d(11, 101));
    EXPECT_EQ(frames[0].detections[1].corners[3], Eigen::Vector2d(41, 101));
    EXPECT_TRUE(frames[1].detections.empty());
    EXPECT_EQ(frames[2].detections.size(), 1u);
    // Column-major 2 x 3: the first column is 0 1.
    const cv::Mat want = (cv::Mat_<uchar>(2, 3) << 0, 2, 4, 1, 3, 5);
    EXPECT_EQ(cv::norm(frames[0].image, want, cv::NORM_INF), 0);
  }
}

TEST_F(MatSource, OnePacketIsAScalarStruct) {
  for (const auto& [compressed, version] : kKinds) {
    builder_.AddPackets({Packet(0.5)});
    builder_.Add(M::Numbers(1, 2, {0, 1}, "time"));
    builder_.Add(M::Numbers(12, 2, {1, 2, 3, 0, 0, 0, 7}, "vicon"));
    builder_.Write(path_, compressed, version);
    const auto source = OpenDataSource(path_, UseDetections());
    ASSERT_TRUE(source) << source.error().message;
    const auto frames = ReadAllFrames(source->get());
    ASSERT_EQ(frames.size(), 1u);
    EXPECT_EQ(frames[0].detections.size(), 2u);
    EXPECT_EQ(frames[0].image.size(), cv::Size(3, 2));
    ASSERT_EQ((*source)->ground_truth().size(), 2u);
    EXPECT_EQ((*source)->ground_truth()[0].twist->v_world.x(), 7.0);
  }
}

TEST_F(MatSource, TakesIdsOfAnyShapeAndClass) {
  builder_.AddPackets({With(Packet(0, 3), "id", M::Numbers(3, 1, {7, 8, 9})),
                       With(Packet(1, 3), "id", M::Integers(1, 3, {7, 8, 9})),
                       With(Packet(2, 1), "id", M::Bytes({1, 1}, {107})),
                       With(Packet(3, 0), "id", M::Numbers(0, 0, {})),
                       With(Packet(4, 1), "p1", M::Floats(2, 1, {0.5F, 1.5F})),
                       With(With(Packet(5, 0), "id", nullptr), "p1", nullptr)});
  builder_.Write(path_, /*compressed=*/false);  // matio garbles unset fields when it compresses
  const auto frames = Frames();
  ASSERT_EQ(frames.size(), 6u);
  for (const size_t i : {0u, 1u}) {
    ASSERT_EQ(frames[i].detections.size(), 3u);
    EXPECT_EQ(frames[i].detections[2].id, 9);
  }
  EXPECT_EQ(frames[2].detections.at(0).id, 107);
  EXPECT_TRUE(frames[3].detections.empty());
  EXPECT_EQ(frames[4].detections.at(0).corners[0], Eigen::Vector2d(0.5, 1.5));
  EXPECT_TRUE(frames[5].detections.empty());
}

TEST_F(MatSource, RefusesBadIdsAndCorners) {
  const std::vector<std::pair<M::Fields, std::string>> cases = {
      {With(Packet(0), "p2", M::Numbers(2, 1, {1, 2})),
       "data(1).p2: expected 2 x 2 like id, got 2 x 1"},
      {With(Packet(0), "p4", M::Numbers(0, 0, {})),
       "data(1).p4: expected 2 x 2 like id, got 0 x 0"},
      {With(Packet(0), "p1", M::Numbers(2, 2, {1, 2, std::nan(""), 4})), "data(1).p1: not finite"},
      {With(Packet(0), "id", M::Numbers(1, 2, {1, 2.5})),
       "data(1).id: expected tag ids >= 0, got 2.5"},
      {With(Packet(0), "id", M::Numbers(1, 2, {1, std::nan("")})),
       "data(1).id: expected tag ids >= 0, got nan"},
      {With(Packet(0), "id", M::Text("ab")), "data(1).id: expected tag ids, got not a real array"},
      {Without(Packet(0), "p3"), "data: missing field 'p3'"}};
  for (const auto& [packet, fault] : cases) {
    Write({packet});
    EXPECT_EQ(Fault(), fault);
    EXPECT_EQ(Fault({}), "read") << "not read when not asked for";
  }
}

TEST_F(MatSource, RefusesBadStamps) {
  Write({Packet(1), Packet(1)});
  EXPECT_EQ(Fault(), "data(2).t: stamp 1.000000000 s repeats");
  Write({Packet(1), Packet(0.5)});
  EXPECT_EQ(Fault(), "data(2).t: stamp 0.500000000 s runs backwards, after 1.000000000 s");
  Write({Packet(std::nan(""))});
  EXPECT_EQ(Fault(), "data(1).t: expected a time in seconds, got nan");
  Write({With(Packet(0), "t", M::Numbers(1, 2, {1, 2}))});
  EXPECT_EQ(Fault(), "data(1).t: expected one number, got 1 x 2");
  Write({With(Packet(0), "t", M::Text("now"))});
  EXPECT_EQ(Fault(), "data(1).t: expected one number, got not a real array");
  Write({Without(Packet(0), "t")});
  EXPECT_EQ(Fault(), "data: missing field 't'");
}

TEST_F(MatSource, TakesTheOnlyStructWhereNoneIsCalledData) {
  builder_.Add(M::Numbers(1, 1, {3}, "other"));
  builder_.AddPackets({Packet(0)}, "empty");
  builder_.Write(path_);
  EXPECT_EQ(Frames().at(0).name, path_ + ": empty(1)");
  builder_.Add(M::Numbers(1, 1, {3}, "data"));
  builder_.Write(path_);
  EXPECT_EQ(Fault(), "no struct variable 'data'");
  builder_.AddPackets({Packet(0)}, "one");
  builder_.AddPackets({Packet(0)}, "two");
  builder_.Write(path_);
  EXPECT_EQ(Fault(), "no struct variable 'data'");
}

TEST_F(MatSource, BadImagesAreSurvivedAndTold) {
  Write({Packet(0), With(Packet(1), "img", M::Numbers(0, 0, {})),
         With(Packet(2), "img", M::Numbers(2, 3, {})), With(Packet(3), "img", M::Text("ab")),
         Packet(4)});
  const auto frames = Frames({});
  ASSERT_EQ(frames.size(), 5u);
  EXPECT_EQ(frames[1].image_problem, "img: empty");
  EXPECT_EQ(frames[2].image_problem, "img: expected an image of bytes, got 2 x 3");
  EXPECT_EQ(frames[3].image_problem, "img: expected an image of bytes, got not a real array");
  EXPECT_FALSE(frames[4].image.empty());
  Write({Packet(0), With(Packet(1), "img", M::Bytes({3, 2}, {0, 1, 2, 3, 4, 5}))});
  EXPECT_EQ(Fault({}), "data(2): expected 3 x 2 px like " + path_ + ": data(1), got 2 x 3");
  Write({Without(Packet(0), "img")});
  EXPECT_EQ(Fault({}), "data: missing field 'img'");
  EXPECT_EQ(Fault(), "read") << "detections need no image";
}

TEST_F(MatSource, TurnsColourIntoGray) {
  // 1 x 2 pixels: pure red, then pure blue.
  Write({With(Packet(0), "img", M::Bytes({1, 2, 3}, {255, 0, 0, 0, 0, 255}))});
  const auto frames = Frames();
  ASSERT_EQ(frames.at(0).image.size(), cv::Size(2, 1));
  EXPECT_EQ(frames[0].image.at<uchar>(0, 0), 76);
  EXPECT_EQ(frames[0].image.at<uchar>(0, 1), 29);
}

TEST_F(MatSource, ImuComesFromPacketsThatHaveIt) {
  const auto with_imu = [](double t, matvar_t* acc, matvar_t* omg) {
    M::Fields packet = Packet(t);
    packet.emplace_back("acc", acc);
    packet.emplace_back("omg", omg);
    return packet;
  };
  Write({with_imu(0, M::Numbers(3, 1, {1, 2, 3}), M::Numbers(1, 3, {4, 5, 6})),
         with_imu(1, M::Numbers(0, 0, {}), M::Numbers(3, 1, {4, 5, 6})),
         with_imu(2, M::Numbers(3, 1, {1, std::nan(""), 3}), M::Numbers(3, 1, {4, 5, 6}))});
  const auto source = OpenDataSource(path_, {});
  ASSERT_TRUE(source) << source.error().message;
  ASSERT_EQ((*source)->imu().size(), 1u);
  EXPECT_EQ((*source)->imu()[0].accel_mps2, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ((*source)->imu()[0].gyro_radps, Eigen::Vector3d(4, 5, 6));
  Write({with_imu(0, M::Numbers(2, 1, {1, 2}), M::Numbers(3, 1, {4, 5, 6}))});
  EXPECT_EQ(Fault(), "data(1).acc: expected 3 x 1, got 2 x 1");
}

TEST_F(MatSource, RefusesBadVicon) {
  const auto write = [&](matvar_t* time, matvar_t* vicon) {
    builder_.AddPackets({Packet(0)});
    if (time != nullptr) builder_.Add(time);
    if (vicon != nullptr) builder_.Add(vicon);
    builder_.Write(path_);
  };
  write(M::Numbers(1, 2, {0, 1}, "time"), M::Numbers(12, 2, {}, "vicon"));
  EXPECT_EQ(Fault(), "read");
  write(M::Numbers(1, 2, {0, 1}, "time"), nullptr);
  EXPECT_EQ(Fault(), "read") << "no vicon is no truth";
  write(nullptr, M::Numbers(12, 2, {}, "vicon"));
  EXPECT_EQ(Fault(), "vicon without the variable 'time'");
  write(M::Numbers(1, 3, {0, 1, 2}, "time"), M::Numbers(12, 2, {}, "vicon"));
  EXPECT_EQ(Fault(), "vicon: expected 12 x 3 like time, got 12 x 2");
  write(M::Numbers(1, 2, {1, 1}, "time"), M::Numbers(12, 2, {}, "vicon"));
  EXPECT_EQ(Fault(), "time(2): stamp 1.000000000 s repeats");
  write(M::Numbers(1, 2, {1, INFINITY}, "time"), M::Numbers(12, 2, {}, "vicon"));
  EXPECT_EQ(Fault(), "time(2): expected a time in seconds, got inf");
  write(M::Numbers(1, 1, {1}, "time"), M::Numbers(12, 1, {1, std::nan("")}, "vicon"));
  EXPECT_EQ(Fault(), "vicon(:,1): not finite");
}

TEST_F(MatSource, MemoryAndTimeDoNotGrowWithTheImages) {
  constexpr int kPackets = 300;
  std::vector<M::Fields> packets;
  for (int i = 0; i < kPackets; ++i) {
    packets.push_back(
        With(Packet(i), "img",
             M::Bytes({240, 376}, std::vector<uint8_t>(240 * 376, static_cast<uint8_t>(i)))));
  }
  Write(packets);
  packets.clear();
  const auto source = OpenDataSource(path_, {});
  ASSERT_TRUE(source) << source.error().message;
  // Resident size now, not the peak: the file above was made in this process.
  const auto resident_kib = [] {
    std::ifstream status("/proc/self/statm");
    long total = 0, resident = 0;
    status >> total >> resident;
    return 4 * resident;
  };
  const long before_kib = resident_kib();
  long most_kib = 0;
  for (int i = 0; i < kPackets; ++i) {
    const auto frame = (*source)->Next();
    ASSERT_TRUE(frame && *frame);
    EXPECT_EQ((*frame)->image.at<uchar>(100, 100), static_cast<uchar>(i));
    most_kib = std::max(most_kib, resident_kib());
  }
#ifdef TAGTWIST_SANITIZED
  constexpr long kMostKib = 1024 * 1024;  // freed memory is held back there
#else
  constexpr long kMostKib = 4 * 1024;  // of 26 MiB of images
#endif
  EXPECT_LT(most_kib - before_kib, kMostKib);
}

TEST_F(MatSource, WriterKeepsToTheCourseSchema) {
  Recording recording = MakeRecording(2);
  TagDetection& tag = recording.frames[0].detections[0];
  // The diagonals y = x and x + y = 4 meet in (2, 2); the corners' mean is (1.75, 1.75).
  tag.corners = {Eigen::Vector2d(0, 0), Eigen::Vector2d(4, 0), Eigen::Vector2d(3, 3),
                 Eigen::Vector2d(0, 4)};
  WriteRecording(recording, path_, DatasetFormat::kMat);
  const auto file = OpenMatFile(path_);
  ASSERT_TRUE(file) << file.error().message;
  ASSERT_TRUE((*file)->OpenPackets());
  EXPECT_EQ((*file)->packets_name(), "data");
  const std::vector<std::tuple<const char*, size_t, size_t>> shapes = {
      {"is_ready", 1, 1}, {"t", 1, 1},  {"rpy", 3, 1}, {"omg", 3, 1}, {"acc", 3, 1},
      {"img", 30, 40},    {"id", 1, 3}, {"p0", 2, 3},  {"p1", 2, 3},  {"p4", 2, 3}};
  for (const auto& [field, rows, columns] : shapes) {
    const auto array = (*file)->ReadField(0, field);
    ASSERT_TRUE(array) << field;
    EXPECT_TRUE(array->IsMatrix(rows, columns)) << field << ": " << DescribeShape(*array);
  }
  const auto p0 = (*file)->ReadField(0, "p0");
  EXPECT_NEAR(p0->numbers[0], 2, 1e-12);
  EXPECT_NEAR(p0->numbers[1], 2, 1e-12);
  const auto no_ids = (*file)->ReadField(1, "id");
  EXPECT_TRUE(no_ids->IsMatrix(1, 0)) << DescribeShape(*no_ids);
  const auto vicon = (*file)->ReadVariable("vicon");
  ASSERT_TRUE(vicon && *vicon);
  EXPECT_TRUE((*vicon)->IsMatrix(12, recording.truth.size()));
}

TEST(RealDataMat, OneGenuinePacket) {
  const std::string path = std::string(TAGTWIST_REAL_DATA_DIR) + "/course/one_packet.mat";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "no real data at " << path;
  const auto source = OpenDataSource(path, UseDetections());
  ASSERT_TRUE(source) << source.error().message;
  EXPECT_TRUE((*source)->ground_truth().empty());
  ASSERT_EQ((*source)->imu().size(), 1u);
  EXPECT_NEAR((*source)->imu()[0].accel_mps2.norm(), 9.81, 2.0);
  const auto frames = ReadAllFrames(source->get());
  ASSERT_EQ(frames.size(), 1u);
  EXPECT_TRUE(frames[0].detections.empty()) << "no tag in view";
  EXPECT_EQ(frames[0].image.size(), cv::Size(376, 240));
  EXPECT_GT(cv::norm(frames[0].image, cv::NORM_INF), 100);
}

}  // namespace
}  // namespace tagtwist::internal::mat_source_test

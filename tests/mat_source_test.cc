// What the reader of course .mat files accepts and refuses.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <cmath>

#include "tests/dataset_fixture.h"
#include "tests/mat_builder.h"
#include "tests/temp_folder.h"

namespace tagtwist {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;
using M = MatBuilder;

DataSourceOptions UseDetections() {
  DataSourceOptions options;
  options.use_detections = true;
  return options;
}

// A packet with n tags; corner k of tag j is (10 k + j, 100 + j).
M::Fields Packet(double t, size_t n = 2) {
  std::vector<double> ids;
  for (size_t j = 0; j < n; ++j) ids.push_back(static_cast<double>(5 * j));
  M::Fields fields = {{"t", M::Numbers(1, 1, {t})},
                      {"img", M::Bytes({2, 3}, {0, 1, 2, 3, 4, 5})},
                      {"id", M::Numbers(1, n, ids)}};
  for (int k = 0; k <= 4; ++k) {
    std::vector<double> points;
    for (size_t j = 0; j < n; ++j) {
      points.push_back(10.0 * k + static_cast<double>(j));
      points.push_back(100 + static_cast<double>(j));
    }
    fields.emplace_back("p" + std::to_string(k), M::Numbers(2, n, points));
  }
  return fields;
}

// Replaces a field of the packet.
M::Fields With(M::Fields packet, const std::string& field, matvar_t* value) {
  for (auto& [name, old] : packet) {
    if (name != field) continue;
    Mat_VarFree(old);
    old = value;
  }
  return packet;
}

M::Fields Without(M::Fields packet, const std::string& field) {
  M::Fields out;
  for (auto& [name, value] : packet) {
    if (name == field) {
      Mat_VarFree(value);
    } else {
      out.emplace_back(name, value);
    }
  }
  return out;
}

class MatSource : public ::testing::Test {
 protected:
  void Write(const std::vector<M::Fields>& packets) {
    builder_.AddPackets(packets);
    builder_.Write(path_);
  }
  // The fault with detections in use, at opening or in a frame, without the path at its head.
  std::string Fault(const DataSourceOptions& options = UseDetections()) const {
    const auto source = OpenDataSource(path_, options);
    std::string fault = source ? "" : source.error().message;
    if (source) ReadAllFrames(source->get(), &fault);
    if (fault.empty()) return "read";
    EXPECT_THAT(fault, StartsWith(path_ + ": "));
    return fault.substr(path_.size() + 2);
  }
  std::vector<Frame> Frames(const DataSourceOptions& options = UseDetections()) const {
    const auto source = OpenDataSource(path_, options);
    EXPECT_TRUE(source) << source.error().message;
    return source ? ReadAllFrames(source->get()) : std::vector<Frame>{};
  }
  TempFolder folder_;
  const std::string path_ = folder_ / "a.mat";
  MatBuilder builder_;
};

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

TEST_F(MatSource, RefusesWhatIsNoMatFile) {
  WriteText(path_, "");
  EXPECT_EQ(Fault(), "empty file");
  WriteText(path_, std::string(1000, 'x'));
  EXPECT_EQ(Fault(), "expected a course .mat or a folder, got a file that is no MAT file");
}

TEST_F(MatSource, EveryTruncationIsRefused) {
  for (const bool compressed : {true, false}) {
    builder_.AddPackets({Packet(0.5), Packet(0.75)});
    builder_.Add(M::Numbers(1, 1, {0}, "time"));
    builder_.Add(M::Numbers(12, 1, {}, "vicon"));
    builder_.Write(path_, compressed);
    const std::string whole = ReadText(path_);
    size_t variable_ends = 0;
    for (size_t size = 0; size < whole.size(); size += size < 200 ? 1 : 9) {
      WriteText(path_, whole.substr(0, size));
      const std::string fault = Fault();
      if (fault == "read") ++variable_ends;  // before vicon nothing tells that something follows
      if (size > 128 && fault != "read") {
        EXPECT_THAT(fault, ::testing::AnyOf(StartsWith("truncated: "), StartsWith("vicon without")))
            << size;
      }
    }
    EXPECT_LE(variable_ends, 2u);
  }
}

TEST_F(MatSource, Hdf5FaultsAreToldInOneLine) {
  builder_.AddPackets({Without(Packet(0.5), "t")});
  builder_.Write(path_, true, MAT_FT_MAT73);
  EXPECT_EQ(Fault(), "data: missing field 't'");
  builder_.AddPackets({Packet(0.5), With(Packet(1), "img", M::Text("ab"))});
  builder_.Write(path_, true, MAT_FT_MAT73);
  EXPECT_EQ(Frames().at(1).image_problem, "img: expected an image of bytes, got not a real array");
  const std::string whole = ReadText(path_);
  ::testing::internal::CaptureStderr();
  for (size_t size = 600; size < whole.size(); size += whole.size() / 20) {
    WriteText(path_, whole.substr(0, size));
    EXPECT_EQ(Fault(), "truncated or damaged: no whole HDF5 file") << size;
  }
  WriteText(path_, whole.substr(0, 512) + std::string(5000, 'x'));
  EXPECT_EQ(Fault(), "truncated or damaged: no whole HDF5 file");
  builder_.Add(M::Numbers(1, 1, {0}, "data"));
  builder_.Write(path_, true, MAT_FT_MAT73);
  EXPECT_EQ(Fault(), "no struct variable 'data'");
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "") << "HDF5 prints unless told not to";
}

TEST_F(MatSource, FlippedBytesNeverCrash) {
  for (const bool compressed : {true, false}) {
    builder_.AddPackets({Packet(0.5, 1), Packet(0.75, 0)});
    builder_.Write(path_, compressed);
    const std::string whole = ReadText(path_);
    for (size_t at = 128; at < whole.size(); at += compressed ? 7 : 1) {
      std::string damaged = whole;
      damaged[at] = static_cast<char>(damaged[at] ^ "\x01\x80\xff"[at % 3]);
      WriteText(path_, damaged);
      const std::string fault = Fault();
      EXPECT_TRUE(!compressed || fault != "read") << "the checksum covers byte " << at;
    }
  }
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
#if defined(__SANITIZE_ADDRESS__)
  constexpr long kMostKib = 1024 * 1024;  // freed memory is held back there
#else
  constexpr long kMostKib = 4 * 1024;  // of 26 MiB of images
#endif
  EXPECT_LT(most_kib - before_kib, kMostKib);
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
}  // namespace tagtwist

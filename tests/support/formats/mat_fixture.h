#pragma once
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "tests/support/dataset_fixture.h"
#include "tests/support/formats/mat_builder.h"
#include "tests/support/temp_folder.h"

namespace tagtwist::internal {

using M = MatBuilder;

inline DataSourceOptions UseDetections() {
  DataSourceOptions options;
  options.use_detections = true;
  return options;
}

/// A packet with n tags; corner k of tag j is (10 k + j, 100 + j).
inline M::Fields Packet(double t, size_t n = 2) {
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

/// Replaces a field of the packet.
inline M::Fields With(M::Fields packet, const std::string& field, matvar_t* value) {
  for (auto& [name, old] : packet) {
    if (name != field) continue;
    Mat_VarFree(old);
    old = value;
  }
  return packet;
}

inline M::Fields Without(M::Fields packet, const std::string& field) {
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

/// A .mat to write and open.
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
    EXPECT_THAT(fault, ::testing::StartsWith(path_ + ": "));
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

}  // namespace tagtwist::internal

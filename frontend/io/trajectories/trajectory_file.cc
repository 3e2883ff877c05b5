#include "frontend/io/trajectories/trajectory_file.h"

#include <optional>
#include <string_view>
#include <utility>

#include "frontend/base/files/input_file.h"
#include "frontend/base/number_text.h"
#include "frontend/io/mat/mat_file.h"
#include "frontend/io/trajectories/mat_truth.h"
#include "frontend/io/trajectories/trajectory_text.h"
#include "frontend/io/trajectories/truth_parts.h"

namespace tagtwist {

using namespace internal;

Result<TrajectoryFile> ReadTrajectoryFile(const std::string& path, const std::string& body,
                                          const Limits& limits) {
  if (IsMatFile(path)) {
    auto samples = ReadMatTruth(path, limits);
    if (!samples) return samples.error();
    return TrajectoryFile{std::move(*samples), "course .mat", {}};
  }
  auto text = ReadWholeFile(path, limits);
  if (!text) return text.error();
  return ReadTrajectoryText(std::move(*text), path, body, limits);
}

Result<std::vector<TruthSample>> ReadGroundTruth(const std::string& path, const Limits& limits) {
  auto file = ReadTrajectoryFile(path, "", limits);
  if (!file) return file.error();
  return std::move(file->samples);
}

std::string FormatGroundTruthCsv(const std::vector<TruthSample>& truth) {
  const bool with_twist = AllHaveTwist(truth);
  std::string out = "t,x,y,z,qx,qy,qz,qw";
  if (with_twist) out += ",vx_world,vy_world,vz_world,wx_body,wy_body,wz_body";
  out += "\n";
  for (const TruthSample& sample : truth) {
    out += FormatSeconds(sample.t_ns);
    for (const double x : sample.world_from_body.translation()) out += "," + FormatNumber(x);
    const Eigen::Vector4d q = sample.world_from_body.rotation().coeffs();
    for (const double x : q) out += "," + FormatNumber(x);
    if (with_twist) {
      for (const double x : sample.twist->v_world) out += "," + FormatNumber(x);
      for (const double x : sample.twist->omega_body) out += "," + FormatNumber(x);
    }
    out += "\n";
  }
  return out;
}

std::string FormatTumLine(int64_t t_ns, const Pose& world_from_body) {
  std::string out = FormatSeconds(t_ns);
  for (const double x : world_from_body.translation()) out += " " + FormatNumber(x);
  const Eigen::Vector4d q = world_from_body.rotation().coeffs();  // rotation() is a temporary
  for (const double x : q) out += " " + FormatNumber(x);
  return out + "\n";
}

std::string FormatTum(const std::vector<TruthSample>& trajectory) {
  std::string out = "# t x y z qx qy qz qw\n";
  for (const TruthSample& sample : trajectory) {
    out += FormatTumLine(sample.t_ns, sample.world_from_body);
  }
  return out;
}

}  // namespace tagtwist

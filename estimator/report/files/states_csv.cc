#include "estimator/report/files/states_csv.h"

#include <array>
#include <charconv>
#include <cmath>

#include "frontend/base/number_text.h"

namespace tagtwist::internal {
namespace {

constexpr int kDigits = 10, kSigmaDigits = 7, kCovarianceDigits = 12;

const char* const kStatesHeader =
    "t,x,y,z,qx,qy,qz,qw,vx_world,vy_world,vz_world,wx_body,wy_body,wz_body,"
    "cf_x,cf_y,cf_z,cf_qx,cf_qy,cf_qz,cf_qw,"
    "cf_vx_world,cf_vy_world,cf_vz_world,cf_wx_body,cf_wy_body,cf_wz_body,"
    "sigma_rx,sigma_ry,sigma_rz,sigma_x,sigma_y,sigma_z,"
    "sigma_vx,sigma_vy,sigma_vz,sigma_wx,sigma_wy,sigma_wz,n_tags,n_tracks,status\n";

const std::array<const char*, 12> kErrorStateNames = {"rx", "ry", "rz", "x",  "y",  "z",
                                                      "vx", "vy", "vz", "wx", "wy", "wz"};

// ",value"; a value that is not finite is an empty cell.
void AppendCell(std::string* out, double value, int digits) {
  out->push_back(',');
  if (!std::isfinite(value)) return;
  std::array<char, 40> text;
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value,
                                 std::chars_format::general, digits);
  out->append(text.data(), end.ptr);
}

template <typename Vector>
void AppendCells(std::string* out, const Vector& values, int digits) {
  for (Eigen::Index i = 0; i < values.size(); ++i) AppendCell(out, values(i), digits);
}

void AppendPose(std::string* out, const Pose& pose) {
  AppendCells(out, pose.translation(), kDigits);
  const double sign = pose.params(3) < 0 ? -1 : 1;
  AppendCells(out, Eigen::Vector4d(sign * pose.params.head<4>()), kDigits);
}

void AppendTwist(std::string* out, const Twist& twist) {
  AppendCells(out, twist.v_world, kDigits);
  AppendCells(out, twist.omega_body, kDigits);
}

void AppendRow(std::string* out, const FrameEstimate& f) {
  const bool has_state = f.status != FrameStatus::kNoFix;
  *out += FormatSeconds(f.t_ns);
  if (has_state) {
    AppendPose(out, f.state.world_from_body);
    AppendTwist(out, f.state.twist);
  } else {
    out->append(13, ',');
  }
  const ClosedForm& cf = f.closed_form;
  if (cf.world_from_body) AppendPose(out, *cf.world_from_body);
  if (!cf.world_from_body) out->append(7, ',');
  if (cf.twist_low_pass) AppendTwist(out, *cf.twist_low_pass);
  if (!cf.twist_low_pass) out->append(6, ',');
  if (has_state) {
    AppendCells(out, StateVector(f.covariance.diagonal().cwiseSqrt()), kSigmaDigits);
  } else {
    out->append(12, ',');
  }
  *out += "," + std::to_string(f.n_tags) + "," + std::to_string(f.n_tracks) + "," +
          ToString(f.status) + "\n";
}

}  // namespace

std::string StatesCsvHeader() { return kStatesHeader; }

std::string FormatStatesRow(const FrameEstimate& frame) {
  std::string out;
  AppendRow(&out, frame);
  return out;
}

std::string FormatStatesCsv(const std::vector<FrameEstimate>& frames) {
  std::string out = kStatesHeader;
  out.reserve(out.size() + 640 * frames.size());
  for (const FrameEstimate& f : frames) AppendRow(&out, f);
  return out;
}

std::string FormatCovarianceCsv(const std::vector<FrameEstimate>& frames) {
  std::string out = "t";
  for (size_t i = 0; i < 12; ++i) {
    for (size_t j = i; j < 12; ++j) {
      out += std::string(",") + kErrorStateNames[i] + "_" + kErrorStateNames[j];
    }
  }
  out += "\n";
  for (const FrameEstimate& f : frames) {
    if (f.status != FrameStatus::kNoFix) out += FormatCovarianceRow(f);
  }
  return out;
}

std::string FormatCovarianceRow(const FrameEstimate& frame) {
  std::string out = FormatSeconds(frame.t_ns);
  for (int i = 0; i < 12; ++i) {
    for (int j = i; j < 12; ++j) AppendCell(&out, frame.covariance(i, j), kCovarianceDigits);
  }
  return out + "\n";
}

}  // namespace tagtwist::internal

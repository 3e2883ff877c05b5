#include "estimator/report/files/calibration_text.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "frontend/base/format_text.h"
#include "frontend/types/so3.h"
#include "residuals/lens.h"

namespace tagtwist::internal {
namespace {

constexpr double kReportedSigmas = 3;  // sigmas from which on a change is told
constexpr double kDegree = M_PI / 180;
constexpr size_t kTagsReported = 5;

// How many sigmas the entries [first, first + n) changed by, together: sqrt(e' P^-1 e); 0 where
// they did not.
double Significance(const Calibration& c, int first, int n) {
  const Eigen::VectorXd e = c.change.segment(first, n);
  const Eigen::MatrixXd p = c.covariance.block(first, first, n, n);
  if (e.isZero(0) || !(p.diagonal().minCoeff() > 0)) return 0;
  return std::sqrt(std::max(0.0, e.dot(p.ldlt().solve(e))));
}

void AddLens(const Calibration& c, std::vector<std::string>* out) {
  const double focal = Significance(c, kLogFocal, 1);
  if (focal > kReportedSigmas) {
    const double percent = 100 * std::expm1(c.change(kLogFocal));
    out->push_back(
        Format("focal length %+.2f %% (%.0f sigma)%s", percent, focal,
               std::abs(percent) > 0.5 ? ": the configured K belongs to another camera" : ""));
  }
  if (const double sigmas = Significance(c, kLogAspect, 1); sigmas > kReportedSigmas) {
    out->push_back(
        Format("fy/fx %+.3f %% (%.0f sigma)", 100 * std::expm1(c.change(kLogAspect)), sigmas));
  }
  if (const double sigmas = Significance(c, kCentreX, 2); sigmas > kReportedSigmas) {
    out->push_back(Format("principal point %+.2f, %+.2f px (%.0f sigma)", c.change(kCentreX),
                          c.change(kCentreY), sigmas));
  }
  const std::vector<std::string> names = DistortionNames(c.given.camera);
  for (size_t i = 0; i < names.size(); ++i) {
    const int entry = kFirstDistortion + static_cast<int>(i);
    if (const double sigmas = Significance(c, entry, 1); sigmas > kReportedSigmas) {
      out->push_back(
          Format("distortion %s %+.5f (%.0f sigma)", names[i].c_str(), c.change(entry), sigmas));
    }
  }
}

void AddShutter(const Calibration& c, std::vector<std::string>* out) {
  const int entry = LayoutOf(c.given).line_time();
  if (!c.applied[static_cast<size_t>(entry)]) return;
  out->push_back(
      Format("rolling shutter: %.2f us +- %.2f from row to row, %+.2f against the "
             "configuration; %.1f ms an image",
             1e6 * c.refined.line_time_s, 1e6 * c.sigma(entry), 1e6 * c.change(entry),
             1e3 * std::abs(c.refined.line_time_s) * c.given.camera.height));
}

void AddPose(const Calibration& c, int first, const char* name, std::vector<std::string>* out) {
  const double turn = Significance(c, first, 3), way = Significance(c, first + 3, 3);
  if (turn > kReportedSigmas) {
    out->push_back(Format("%s turned by %.2f deg (%.0f sigma)", name,
                          c.change.segment<3>(first).norm() / kDegree, turn));
  }
  if (way > kReportedSigmas) {
    out->push_back(Format("%s moved by %.1f, %.1f, %.1f mm (%.0f sigma)", name,
                          1e3 * c.change(first + 3), 1e3 * c.change(first + 4),
                          1e3 * c.change(first + 5), way));
  }
}

void AddTruth(const Calibration& c, std::vector<std::string>* out) {
  const CalibrationLayout layout = LayoutOf(c.given);
  if (const double sigmas = Significance(c, layout.scale(), 1); sigmas > kReportedSigmas) {
    out->push_back(Format("print scale %+.2f %% (%.0f sigma): measure a printed tag",
                          100 * std::expm1(c.change(layout.scale())), sigmas));
  }
  AddPose(c, layout.mount(), "mount (cam_from_body)", out);
  AddPose(c, layout.world(), "the ground truth's world against the map", out);
  if (const double sigmas = Significance(c, layout.clock(), 1); sigmas > kReportedSigmas) {
    const double ms = 1e3 * c.change(layout.clock());
    out->push_back(Format("stamps are %.1f ms %s against the ground truth (%.0f sigma)",
                          std::abs(ms), ms < 0 ? "late" : "early", sigmas));
  }
}

void AddTags(const Calibration& c, std::vector<std::string>* out) {
  std::vector<TagMove> moves = TagMoves(c);
  if (moves.empty()) return;
  double squares = 0, up_squares = 0;
  for (const TagMove& move : moves) {
    squares += move.up_m * move.up_m + move.within_m * move.within_m;
    up_squares += move.up_m * move.up_m;
  }
  const auto n = static_cast<double>(moves.size());
  out->push_back(
      Format("tags lie %.1f mm RMS from where the map has them, %.1f mm RMS above or below",
             1e3 * std::sqrt(squares / n), 1e3 * std::sqrt(up_squares / n)));
  std::stable_sort(moves.begin(), moves.end(), [](const TagMove& a, const TagMove& b) {
    return std::abs(a.up_m) > std::abs(b.up_m);
  });
  for (size_t i = 0; i < std::min(kTagsReported, moves.size()); ++i) {
    const TagMove& move = moves[i];
    if (!(std::abs(move.up_m) > kReportedSigmas * move.up_sigma_m)) continue;
    out->push_back(Format("tag %d lies %.1f mm %s where the map has it (%.0f sigma)", move.id,
                          1e3 * std::abs(move.up_m), move.up_m > 0 ? "above" : "below",
                          std::abs(move.up_m) / move.up_sigma_m));
  }
}

void AddBends(const Calibration& c, std::vector<std::string>* out) {
  std::vector<TagBend> bends = TagBends(c);
  if (bends.empty()) return;
  double squares = 0;
  for (const TagBend& bend : bends) squares += bend.bend_m * bend.bend_m;
  out->push_back(Format("tags are bent by %.2f mm RMS, two opposite corners up, two down",
                        1e3 * std::sqrt(squares / static_cast<double>(bends.size()))));
  std::stable_sort(bends.begin(), bends.end(), [](const TagBend& a, const TagBend& b) {
    return std::abs(a.bend_m) > std::abs(b.bend_m);
  });
  for (size_t i = 0; i < std::min(kTagsReported, bends.size()); ++i) {
    const TagBend& bend = bends[i];
    if (!(std::abs(bend.bend_m) > kReportedSigmas * bend.sigma_m)) continue;
    out->push_back(Format("tag %d is bent by %.1f mm, %s up (%.0f sigma)", bend.id,
                          1e3 * std::abs(bend.bend_m), bend.bend_m > 0 ? "p1 and p3" : "p2 and p4",
                          std::abs(bend.bend_m) / bend.sigma_m));
  }
}

void AddValidation(const Calibration& c, std::vector<std::string>* out) {
  const HeldOutJudgement &given = c.validation.given, &refined = c.validation.refined;
  out->push_back(
      Format("corners of frames not fitted to miss by %.3f px as configured, %.3f px "
             "refined (robust sigma of a coordinate, poses free)",
             given.corner_sigma_px, refined.corner_sigma_px));
  if (c.has_truth) {
    out->push_back(
        Format("frames not fitted to lie %.1f mm, %.2f deg (median) from the ground "
               "truth as configured, %.1f mm, %.2f deg refined",
               1e3 * given.truth_median_m, given.truth_median_rad / kDegree,
               1e3 * refined.truth_median_m, refined.truth_median_rad / kDegree));
  }
  for (const GroupVerdict& verdict : c.validation.verdicts) {
    if (verdict.applied) continue;
    out->push_back(
        Format("%s: not applied, for it does not help frames that it was not fitted to "
               "(half squares a block lower by %.2f +- %.2f)",
               ToString(verdict.group), verdict.gain, verdict.gain_sigma));
  }
}

double FramesOfAnError(const CalibrationNoise& noise) {
  const double persistence =
      std::max(noise.truth_position_persistence, noise.truth_rotation_persistence);
  return persistence * persistence;
}

void AddUnseen(const Calibration& c, std::vector<std::string>* out) {
  if (!c.has_truth) {
    out->push_back(
        "without ground truth: print scale, mount and clock stay as configured; the map "
        "as a whole stays where the configuration has it (prior of its tags)");
  }
  // Directions of the same parts are told together.
  std::map<std::string, int> counts;
  std::vector<std::pair<std::string, std::string>> lines;
  for (const UnseenDirection& direction : c.unseen) {
    std::string text;
    for (const auto& part : direction.parts) {
      if (part.share < 0.2 && !text.empty()) continue;
      text += (text.empty() ? "" : " with ") + part.kind;
    }
    if (text.empty()) text = "a mixture of many";
    const std::string show = direction.parts.empty() ? "" : direction.parts[0].kind;
    if (counts[text]++ == 0) lines.emplace_back(text, show);
  }
  for (const auto& [text, kind] : lines) {
    out->push_back(Format(
        "this recording does not show %s (%d direction%s): stays at its prior; %s "
        "would show it",
        text.c_str(), counts[text], counts[text] == 1 ? "" : "s", WhatWouldShow(kind).c_str()));
  }
}

}  // namespace

std::vector<TagMove> TagMoves(const Calibration& c) {
  const CalibrationLayout layout = LayoutOf(c.given);
  // Without what all tags have in common: x - B B' x, an entry in its own unit, B of whole motions.
  const Eigen::VectorXd units =
      (c.prior_sigmas.array() > 0).select(Eigen::VectorXd::Ones(c.prior_sigmas.size()), 0.0);
  const Eigen::MatrixXd common = RigidMotionsOfMap(c.given, units);
  const Eigen::VectorXd change = c.change - common * (common.transpose() * c.change);
  const Eigen::MatrixXd half = c.covariance - common * (common.transpose() * c.covariance);
  const Eigen::MatrixXd covariance = half - (half * common) * common.transpose();
  std::vector<TagMove> out;
  for (int i = 0; i < layout.n_tags; ++i) {
    const int first = layout.tag(i) + 3;
    if (!c.applied[static_cast<size_t>(first)]) continue;
    const Tag& tag = c.given.tags[static_cast<size_t>(i)];
    const Eigen::Vector3d normal = tag.world_from_tag.rotation() * Eigen::Vector3d::UnitZ();
    const Eigen::Vector3d move = change.segment<3>(first);
    const Eigen::Matrix3d p = covariance.block<3, 3>(first, first);
    TagMove of;
    of.id = tag.id;
    of.up_m = normal.dot(move);
    of.up_sigma_m = std::sqrt(std::max(0.0, normal.dot(p * normal)));
    of.within_m = (move - of.up_m * normal).norm();
    of.position_sigma_m = std::sqrt(std::max(0.0, p.diagonal().maxCoeff()));
    of.turn_rad = change.segment<3>(first - 3).norm();
    out.push_back(of);
  }
  return out;
}

std::vector<TagBend> TagBends(const Calibration& c) {
  const CalibrationLayout layout = LayoutOf(c.given);
  std::vector<TagBend> out;
  for (int i = 0; i < layout.n_tags; ++i) {
    const int entry = layout.bend(i);
    if (!c.applied[static_cast<size_t>(entry)]) continue;
    const Tag& tag = c.refined.tags[static_cast<size_t>(i)];
    out.push_back({tag.id, tag.bend_m, c.sigma(entry)});
  }
  return out;
}

ScaleAndFocal CompareScaleAndFocal(const Calibration& c) {
  const Eigen::VectorXd direction = MapScaleDirection(c.given, c.prior_sigmas);
  const Eigen::VectorXd by_others = c.covariance * direction;
  ScaleAndFocal out;
  out.scale = direction.dot(c.change);
  out.scale_sigma = std::sqrt(std::max(0.0, direction.dot(by_others)));
  out.focal = std::expm1(c.change(kLogFocal));
  out.focal_sigma = c.sigma(kLogFocal);
  const double product = out.scale_sigma * out.focal_sigma;
  if (product > 0) out.correlation = by_others(kLogFocal) / product;
  return out;
}

std::vector<std::string> CalibrationText(const Calibration& c) {
  std::vector<std::string> out;
  std::string noise = Format("calibrated by %d frames, %d tags seen; corner noise %.3f px",
                             c.frames, c.views, c.noise.corner_sigma_px);
  if (c.has_truth) {
    noise +=
        Format("; ground truth %.2f mm, %.3f deg an axis", 1e3 * c.noise.truth_position_sigma_m,
               c.noise.truth_rotation_sigma_rad / kDegree);
    if (const double frames = FramesOfAnError(c.noise); frames > 1) {
      noise += Format(", each error over about %.0f frames", frames);
    }
  }
  out.push_back(noise);
  AddValidation(c, &out);
  AddLens(c, &out);
  AddShutter(c, &out);
  AddTruth(c, &out);
  AddTags(c, &out);
  AddBends(c, &out);
  const ScaleAndFocal both = CompareScaleAndFocal(c);
  if (both.scale != 0 && both.focal != 0) {
    out.push_back(
        Format("map scale %+.3f %% +- %.3f, focal length %+.3f %% +- %.3f: correlation "
               "%.2f",
               100 * both.scale, 100 * both.scale_sigma, 100 * both.focal, 100 * both.focal_sigma,
               both.correlation));
  }
  AddUnseen(c, &out);
  return out;
}

}  // namespace tagtwist::internal

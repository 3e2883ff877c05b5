#include "tests/support/situations/situations.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <utility>

#include "frontend/tags/filter_tags.h"
#include "tests/support/flights/exact_model.h"
#include "tests/support/flights/tag_scene.h"
#include "tests/support/situations/lone_tag_scenes.h"
#include "tests/support/situations/phantoms.h"
#include "tests/support/situations/rolling_tags.h"
#include "tests/support/situations/situation_stamps.h"

namespace tagtwist::internal {
namespace {

constexpr double kDurationS = 16, kPi2 = 6.283185307179586;
using Path = std::function<double(double)>;  // [m] at [s], along one line

double Step(double x) {
  const double y = std::clamp(x, 0.0, 1.0);
  return y * y * y * (10 - 15 * y + 6 * y * y);
}

// Bang-bang acceleration from rest to a speed and back, forth and back, a leg each period.
Path Legs(double acceleration, double ramp_s, double cruise_s, double rest_s, double period_s) {
  return [=](double t) {
    const double leg = std::floor(t / period_s), speed = acceleration * ramp_s;
    const double u = std::clamp(t - period_s * leg - rest_s, 0.0, 2 * ramp_s + cruise_s);
    const double up = std::min(u, ramp_s), flat = std::clamp(u - ramp_s, 0.0, cruise_s),
                 down = std::max(0.0, u - ramp_s - cruise_s);
    const double x = 0.5 * acceleration * up * up + speed * flat + speed * down -
                     0.5 * acceleration * down * down;
    const double whole = speed * (ramp_s + cruise_s);
    return static_cast<int>(leg) % 2 == 0 ? x : whole - x;
  };
}

Path Trapezoid(Rng* rng) {
  const double ramp_s = Draw(rng, 0.2, 0.5), cruise_s = Draw(rng, 0.3, 0.8),
               period_s = Draw(rng, 3, 5);
  return Legs(0.3 / (ramp_s * (ramp_s + cruise_s)), ramp_s, cruise_s, 1, period_s);
}

Path Gantry(Rng* rng) {
  const double acceleration = Draw(rng, 1, 4), ramp_s = Draw(rng, 0.1, 0.3),
               cruise_s = Draw(rng, 0.2, 0.6), rest_s = Draw(rng, 0.2, 0.6);
  return Legs(acceleration, ramp_s, cruise_s, rest_s, rest_s + 2 * ramp_s + cruise_s);
}

// Sticks for a while, then slips within some hundredths of a second.
Path StickSlip(Rng* rng) {
  const double stick_s = Draw(rng, 0.2, 0.8), slip_m = Draw(rng, 2e-3, 10e-3),
               slip_s = Draw(rng, 0.03, 0.1);
  return [=](double t) {
    const double slips = std::floor(t / stick_s), u = t - stick_s * slips;
    const double part = 0.5 - 0.5 * std::cos(0.5 * kPi2 * std::min(1.0, u / slip_s));
    return slip_m * (slips + part);
  };
}

Path PathOf(Situation situation, Rng* rng) {
  const double a = Draw(rng, 0.1, 0.2), f = Draw(rng, 0.15, 0.4), start = Draw(rng, 5, 9);
  const Path sway = [=](double t) { return a * std::sin(kPi2 * f * t); };
  const double buzz_m = Draw(rng, 0.5e-3, 2e-3), buzz_hz = Draw(rng, 4, 9);
  const double push_m = Draw(rng, 0.05, 0.2), stop_s = Draw(rng, 1.5, 3);
  switch (situation) {
    case Situation::kRest:
      return [](double) { return 0.0; };
    case Situation::kTakeOff:
      return [=](double t) { return Step((t - start) / 1.5) * (0.1 + sway(t - start)); };
    case Situation::kTrapezoid:
      return Trapezoid(rng);
    case Situation::kGantry:
      return Gantry(rng);
    case Situation::kStickSlip:
      return StickSlip(rng);
    case Situation::kRollingTurn: {
      const double rate = Draw(rng, 2, 6);  // as if metres were radians
      return [=](double t) { return rate * std::max(0.0, t - start); };
    }
    case Situation::kStopAndGo:
    case Situation::kRolling:
      return [=](double t) {
        const double u = std::fmod(t, 2 * stop_s) - stop_s;
        return u > 0 ? a * std::sin(kPi2 * u) * Step(u / 0.5) * Step((stop_s - u) / 0.5) : 0;
      };
    case Situation::kHit:
      return [=](double t) { return t > start ? push_m * (1 - std::exp((start - t) / 0.05)) : 0; };
    case Situation::kVibration:
      return [=](double t) {
        return sway(t) + (t > start ? buzz_m * std::sin(kPi2 * buzz_hz * (t - start)) : 0);
      };
    case Situation::kKidnapped:
      return [=](double t) { return sway(t) + (t > start ? 0.9 : 0); };
    default:
      return sway;
  }
}

// Along a line, turning about another as it goes.
struct Motion {
  Path path;
  Eigen::Vector3d along, turn;
  double height_m = 1.1;
  Pose At(double t) const {
    const double x = path(t);
    return Hover(Eigen::Vector3d(0.9, 0.9, height_m) + x * along, 0.3 + x * turn.z(),
                 {0.05 + x * turn.x(), 0.04 + x * turn.y(), 0});
  }
};

Motion MotionOf(Situation situation, Rng* rng) {
  // Who is carried is carried to where the mat is.
  const double angle = Draw(rng, 0, situation == Situation::kKidnapped ? kPi2 / 4 : kPi2);
  Motion out{PathOf(situation, rng),
             Eigen::Vector3d(std::cos(angle), std::sin(angle), Draw(rng, -0.3, 0.3)),
             {Draw(rng, -0.5, 0.5), Draw(rng, -0.5, 0.5), Draw(rng, -1, 1)},
             situation == Situation::kFarTag ? 2.5 : 1.1};
  if (situation == Situation::kRollingTurn) {  // on the spot
    out.along.setZero();
    out.turn = Eigen::Vector3d::UnitZ();
  }
  return out;
}

// Of three tags of the mat, the last of which has the first one's id.
void MakeTwin(double t, bool apart, const std::vector<int>& ids, const EstimatorSetup& setup,
              FrameMeasurements* m) {
  constexpr double kPeriodS = 6;
  const double phase = std::fmod(t, kPeriodS);
  std::vector<TagDetection> seen;
  for (TagDetection tag : m->tags) {
    const bool is_first = tag.id == ids[0], is_other = tag.id == ids[1], is_twin = tag.id == ids[2];
    if (apart && ((is_first && phase > 3) || (is_twin && phase <= 3) ||
                  (is_other && phase > 4.5 && phase < 5.5))) {
      continue;
    }
    if (is_twin) tag.id = ids[0];
    if (is_first || is_other || is_twin) seen.push_back(tag);
  }
  m->doubled_ids = DoubledIds(seen, setup.map);
  m->tags = FilterTags(seen, setup.map, setup.camera, 0);
}

constexpr int kLone = 40;

std::function<Pose(double t)> PoseAtOf(Situation situation, const TagMap& map, const Motion& motion,
                                       Rng* rng) {
  if (situation == Situation::kOrbit) {
    return OrbitAbout(map.Find(kLone)->world_from_tag.translation(), rng);
  }
  return [motion](double t) { return motion.At(t); };
}

}  // namespace

BodyState StateAlong(const std::function<Pose(double t)>& pose_at, double t) {
  constexpr double kDt = 1e-5;
  const Pose before = pose_at(t - kDt), after = pose_at(t + kDt);
  BodyState out;
  out.world_from_body = pose_at(t);
  out.twist.v_world = (after.translation() - before.translation()) / (2 * kDt);
  out.twist.omega_body = LogSo3(before.rotation().conjugate() * after.rotation()) / (2 * kDt);
  return out;
}

std::string NameOf(Situation situation) {
  const char* const names[] = {"smooth",  "rest",         "take-off", "trapezoid", "stop and go",
                               "hit",     "vibration",    "gaps",     "phantoms",  "kidnapped",
                               "far tag", "jitter",       "bursts",   "twin",      "twin apart",
                               "gantry",  "stick-slip",   "repeated", "noisy",     "one tag",
                               "rolling", "rolling turn", "late",     "lone tag",  "alone at times",
                               "orbit"};
  return names[static_cast<size_t>(situation)];
}

std::vector<Situation> AllSituations() {
  std::vector<Situation> out;
  for (int i = 0; i <= static_cast<int>(Situation::kOrbit); ++i) {
    out.push_back(static_cast<Situation>(i));
  }
  return out;
}

SituationDraw DrawSituation(Situation situation, unsigned seed, double rate_hz) {
  if (situation == Situation::kOneTag) {
    return BeforeOneTag(DrawSituation(Situation::kStopAndGo, seed, rate_hz));
  }
  if (situation == Situation::kLoneTag || situation == Situation::kLoneAtTimes) {
    return WithLoneTag(DrawSituation(Situation::kStopAndGo, seed, rate_hz),
                       situation == Situation::kLoneAtTimes);
  }
  Rng rng(1000 * seed + static_cast<unsigned>(situation));
  SituationDraw out;
  out.setup = CourseSetup();
  if (SituationStamps::AreWrong(situation)) out.judged_from = 60;
  const Motion motion = MotionOf(situation, &rng);
  const auto pose_at = PoseAtOf(situation, out.setup.map, motion, &rng);
  const bool is_rolling = situation == Situation::kRolling || situation == Situation::kRollingTurn;
  if (is_rolling) out.setup.line_time_s = 20e-3 / out.setup.camera.height;
  std::vector<int> twins;
  SituationStamps stamps(situation, rate_hz, seed);
  const double gap_from = Draw(&rng, 4, 8), gap_to = gap_from + std::pow(10, Draw(&rng, -1, 0.7));
  for (int k = 0; k < static_cast<int>(kDurationS * rate_hz); ++k) {
    const double t = k / rate_hz;
    const BodyState truth = StateAlong(pose_at, t);
    FrameMeasurements m;
    m.t_ns = stamps.Next(k);
    const bool is_noisy = situation == Situation::kNoisy && t > gap_from && t < gap_from + 5;
    const double noise_px = is_noisy ? 0.8 : 0.2;
    m.tags = SeeTags(out.setup.map, out.setup.camera,
                     out.setup.cam_from_body * Inverse(truth.world_from_body), noise_px,
                     static_cast<unsigned>(rng()));
    if (is_rolling)
      RollTags(
          out.setup, [&](double s) { return pose_at(t + s); }, &m.tags);
    if (situation == Situation::kFarTag || situation == Situation::kOrbit) {
      const auto other = [](const TagDetection& tag) { return tag.id != kLone; };
      m.tags.erase(std::remove_if(m.tags.begin(), m.tags.end(), other), m.tags.end());
    }
    if (situation == Situation::kGaps && t > gap_from && t < gap_to) m.tags.clear();
    if (situation == Situation::kPhantoms) {
      m.tags.resize(std::min<size_t>(m.tags.size(), 3));
      if (Draw(&rng, 0, 1) < 0.1) AddPhantom(out.setup.map, &rng, &m.tags);
    }
    if (situation == Situation::kRepeated && k > 0) {
      // One frame in twenty, and once half a second's.
      const bool stalls = t > gap_from && t < gap_from + 0.5;
      if (stalls || Draw(&rng, 0, 1) < 0.05) m.tags = out.measurements.back().tags;
    }
    if (situation == Situation::kTwin || situation == Situation::kTwinApart) {
      if (k == 0) {
        const auto of_seen = [&](size_t tenths) { return m.tags[m.tags.size() * tenths / 10].id; };
        twins = {of_seen(3), of_seen(5), of_seen(9)};
      }
      MakeTwin(t, situation == Situation::kTwinApart, twins, out.setup, &m);
    }
    out.truth.push_back(truth);
    out.measurements.push_back(std::move(m));
  }
  return out;
}

bool IsBeyondFiveSigma(const BodyState& truth, const FrameEstimate& frame) {
  constexpr double kFiveSigma = 31.8;  // of three dimensions
  const StateVector e = Difference(truth, frame.state);
  for (int part = 0; part < 12; part += 3) {
    const Eigen::Vector3d d = e.segment<3>(part);
    if (!(d.dot(frame.covariance.block<3, 3>(part, part).llt().solve(d)) < kFiveSigma)) return true;
  }
  return false;
}

SituationScore Judge(const SituationDraw& draw, const std::vector<FrameEstimate>& frames) {
  SituationScore out;
  for (size_t i = draw.judged_from; i < frames.size(); ++i) {
    if (frames[i].status == FrameStatus::kNoFix) {
      if (draw.measurements[i].tags.size() > 1) ++out.without;
      continue;
    }
    ++out.frames;
    const StateVector e = Difference(draw.truth[i], frames[i].state);
    const StateCovariance& p = frames[i].covariance;
    out.nees += e.dot(p.llt().solve(e)) / 12;
    out.beyond += IsBeyondFiveSigma(draw.truth[i], frames[i]) ? 1 : 0;
    out.position_rms_m += e.segment<3>(3).squaredNorm();
    out.velocity_rms_mps += e.segment<3>(6).squaredNorm();
  }
  const auto n = static_cast<double>(out.frames);
  out.nees /= n;
  out.beyond /= n;
  out.position_rms_m = std::sqrt(out.position_rms_m / n);
  out.velocity_rms_mps = std::sqrt(out.velocity_rms_mps / n);
  return out;
}

}  // namespace tagtwist::internal

#include "tests/support/situations/situations.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

#include "tests/support/flights/exact_model.h"
#include "tests/support/flights/tag_scene.h"

namespace tagtwist::internal {
namespace {

constexpr double kDurationS = 16, kPi2 = 6.283185307179586;
using Path = std::function<double(double)>;  // [m] at [s], along one line
using Rng = std::mt19937_64;

double Draw(Rng* rng, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(*rng);
}

double Step(double x) {
  const double y = std::clamp(x, 0.0, 1.0);
  return y * y * y * (10 - 15 * y + 6 * y * y);
}

// Bang-bang acceleration to a speed and back to rest, forth and back.
Path Trapezoid(Rng* rng) {
  const double ramp_s = Draw(rng, 0.2, 0.5), cruise_s = Draw(rng, 0.3, 0.8),
               period_s = Draw(rng, 3, 5), acceleration = 0.3 / (ramp_s * (ramp_s + cruise_s));
  return [=](double t) {
    const double leg = std::floor(t / period_s), speed = acceleration * ramp_s;
    const double u = std::clamp(t - period_s * leg - 1, 0.0, 2 * ramp_s + cruise_s);
    const double up = std::min(u, ramp_s), flat = std::clamp(u - ramp_s, 0.0, cruise_s),
                 down = std::max(0.0, u - ramp_s - cruise_s);
    const double x = 0.5 * acceleration * up * up + speed * flat + speed * down -
                     0.5 * acceleration * down * down;
    const double whole = speed * (ramp_s + cruise_s);
    return static_cast<int>(leg) % 2 == 0 ? x : whole - x;
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
    case Situation::kStopAndGo:
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
  BodyState StateAt(double t) const {
    constexpr double kDt = 1e-5;
    const Pose before = At(t - kDt), after = At(t + kDt);
    BodyState out;
    out.world_from_body = At(t);
    out.twist.v_world = (after.translation() - before.translation()) / (2 * kDt);
    out.twist.omega_body = LogSo3(before.rotation().conjugate() * after.rotation()) / (2 * kDt);
    return out;
  }
};

// Random corners under an id of the map.
TagDetection Phantom(const TagMap& map, Rng* rng) {
  TagDetection out;
  out.id =
      map.tags()[static_cast<size_t>(Draw(rng, 0, 0.999) * static_cast<double>(map.tags().size()))]
          .id;
  const Eigen::Vector2d centre(Draw(rng, 60, 300), Draw(rng, 60, 180));
  const double size = Draw(rng, 15, 40), turn = Draw(rng, 0, kPi2);
  for (size_t c = 0; c < 4; ++c) {
    const double angle = turn - kPi2 / 4 * static_cast<double>(c);
    out.corners[c] = centre + size * Eigen::Vector2d(std::cos(angle) * Draw(rng, 0.8, 1.2),
                                                     std::sin(angle) * Draw(rng, 0.8, 1.2));
  }
  return out;
}

void AddPhantom(const TagMap& map, Rng* rng, std::vector<TagDetection>* tags) {
  const TagDetection phantom = Phantom(map, rng);
  const auto same = [&](const TagDetection& tag) { return tag.id == phantom.id; };
  tags->erase(std::remove_if(tags->begin(), tags->end(), same), tags->end());
  tags->push_back(phantom);
}

}  // namespace

std::string NameOf(Situation situation) {
  const char* const names[] = {"smooth",    "rest", "take-off", "trapezoid", "stop and go", "hit",
                               "vibration", "gaps", "phantoms", "kidnapped", "far tag"};
  return names[static_cast<size_t>(situation)];
}

SituationDraw DrawSituation(Situation situation, unsigned seed, double rate_hz) {
  Rng rng(1000 * seed + static_cast<unsigned>(situation));
  SituationDraw out;
  out.setup = CourseSetup();
  // Who is carried is carried to where the mat is.
  const double angle = Draw(&rng, 0, situation == Situation::kKidnapped ? kPi2 / 4 : kPi2);
  const Motion motion{PathOf(situation, &rng),
                      Eigen::Vector3d(std::cos(angle), std::sin(angle), Draw(&rng, -0.3, 0.3)),
                      {Draw(&rng, -0.5, 0.5), Draw(&rng, -0.5, 0.5), Draw(&rng, -1, 1)},
                      situation == Situation::kFarTag ? 2.5 : 1.1};
  const double gap_from = Draw(&rng, 4, 8), gap_to = gap_from + std::pow(10, Draw(&rng, -1, 0.7));
  for (int k = 0; k < static_cast<int>(kDurationS * rate_hz); ++k) {
    const double t = k / rate_hz;
    const BodyState truth = motion.StateAt(t);
    FrameMeasurements m;
    m.t_ns = 1'000'000'000 + static_cast<int64_t>(std::llround(1e9 * t));
    m.tags = SeeTags(out.setup.map, out.setup.camera,
                     out.setup.cam_from_body * Inverse(truth.world_from_body), 0.2,
                     static_cast<unsigned>(rng()));
    if (situation == Situation::kFarTag) {
      const auto other = [](const TagDetection& tag) { return tag.id != 40; };
      m.tags.erase(std::remove_if(m.tags.begin(), m.tags.end(), other), m.tags.end());
    }
    if (situation == Situation::kGaps && t > gap_from && t < gap_to) m.tags.clear();
    if (situation == Situation::kPhantoms) {
      m.tags.resize(std::min<size_t>(m.tags.size(), 3));
      if (Draw(&rng, 0, 1) < 0.1) AddPhantom(out.setup.map, &rng, &m.tags);
    }
    out.truth.push_back(truth);
    out.measurements.push_back(std::move(m));
  }
  return out;
}

SituationScore Judge(const SituationDraw& draw, const std::vector<FrameEstimate>& frames) {
  SituationScore out;
  for (size_t i = 0; i < frames.size(); ++i) {
    if (frames[i].status == FrameStatus::kNoFix) {
      if (draw.measurements[i].tags.size() > 1) ++out.without;
      continue;
    }
    ++out.frames;
    const StateVector e = Difference(draw.truth[i], frames[i].state);
    const StateCovariance& p = frames[i].covariance;
    out.nees += e.dot(p.llt().solve(e)) / 12;
    bool beyond = false;
    for (int part = 0; part < 12; part += 3) {
      const Eigen::Vector3d d = e.segment<3>(part);
      constexpr double kFiveSigma = 31.8;  // of three dimensions
      beyond = beyond || !(d.dot(p.block<3, 3>(part, part).llt().solve(d)) < kFiveSigma);
    }
    out.beyond += beyond ? 1 : 0;
    out.position_rms_m += e.segment<3>(3).squaredNorm();
  }
  const auto n = static_cast<double>(out.frames);
  out.nees /= n;
  out.beyond /= n;
  out.position_rms_m = std::sqrt(out.position_rms_m / n);
  return out;
}

}  // namespace tagtwist::internal

#include "frontend/simulation/scribble.h"

#include <algorithm>
#include <cmath>

#include "frontend/base/statistics/random_stream.h"
#include "frontend/base/units.h"

namespace tagtwist::internal {
namespace {

constexpr uint64_t kPurpose = 1;  // of the random stream
constexpr double kTurnRad = 1.3;  // largest turn of a polyline

// Papers on the floor as discs around their centres first, squares second.
class PaperFinder {
 public:
  explicit PaperFinder(const std::vector<Patch>& papers) {
    for (const Patch& paper : papers) {
      const double lowest =
          std::abs(paper.centre.z()) - std::abs(paper.half_u.z()) - std::abs(paper.half_v.z());
      if (lowest < kNearFloorM) papers_.push_back(paper);
    }
  }

  // True when a disc on the floor touches a paper.
  bool Touches(const Eigen::Vector2d& centre, double radius) const {
    return std::any_of(papers_.begin(), papers_.end(), [&](const Patch& paper) {
      const Eigen::Vector3d offset(centre.x() - paper.centre.x(), centre.y() - paper.centre.y(), 0);
      const double half = paper.half_u.norm();
      if (offset.squaredNorm() > std::pow(1.5 * half + radius, 2)) return false;
      const double limit = half + radius;
      return std::abs(offset.dot(paper.half_u)) < limit * half &&
             std::abs(offset.dot(paper.half_v)) < limit * half;
    });
  }

 private:
  std::vector<Patch> papers_;
};

Patch MakeStroke(const Eigen::Vector2d& from, const Eigen::Vector2d& to, double half_width,
                 double grey) {
  const Eigen::Vector2d along = 0.5 * (to - from), centre = 0.5 * (from + to);
  const Eigen::Vector2d across = Eigen::Vector2d(-along.y(), along.x()).normalized() * half_width;
  Patch out;
  out.centre << centre, 0;
  out.half_u << along, 0;
  out.half_v << across, 0;
  out.grey = grey;
  return out;
}

// A polyline that ends where it would touch a paper.
void AddPolyline(Eigen::Vector2d point, const PaperFinder& papers, RandomStream* random,
                 std::vector<Patch>* out) {
  const double half_width = random->Uniform(0.0012, 0.003), grey = random->Uniform(20, 120);
  const auto pieces = 1 + random->Below(4);
  double heading = random->Uniform(0, 2 * kPi);
  for (uint64_t i = 0; i < pieces; ++i) {
    const double length = random->Uniform(0.012, 0.045);
    const Eigen::Vector2d direction(std::cos(heading), std::sin(heading));
    heading += random->Uniform(-kTurnRad, kTurnRad);
    const int discs = 2 + static_cast<int>(length / half_width);
    for (int k = 0; k < discs; ++k) {
      if (papers.Touches(point + k * half_width * direction, 2 * half_width)) return;
    }
    out->push_back(MakeStroke(point, point + length * direction, half_width, grey));
    point += length * direction;
  }
}

void AddBlob(const Eigen::Vector2d& centre, const PaperFinder& papers, RandomStream* random,
             std::vector<Patch>* out) {
  const double radius = random->Uniform(0.003, 0.011), narrow = radius * random->Uniform(0.4, 1);
  const double heading = random->Uniform(0, 2 * kPi), grey = random->Uniform(20, 130);
  const bool round = random->Uniform() < 0.5;
  if (papers.Touches(centre, std::hypot(radius, narrow))) return;
  const Eigen::Vector2d along = radius * Eigen::Vector2d(std::cos(heading), std::sin(heading));
  Patch blob = MakeStroke(centre - along, centre + along, narrow, grey);
  if (round) blob.shape = Patch::Shape::kEllipse;
  out->push_back(blob);
}

}  // namespace

std::vector<Patch> MakeScribbles(const Eigen::Vector2d& low, const Eigen::Vector2d& high,
                                 const std::vector<Patch>& papers, const SceneOptions& options,
                                 uint64_t plane) {
  RandomStream random(options.random_seed, kPurpose, plane);
  const PaperFinder finder(papers);
  std::vector<Patch> out;
  const double area_m2 = (high - low).prod();
  const auto count = static_cast<int>(std::lround(area_m2 * options.scribbles_per_m2));
  for (int i = 0; i < count; ++i) {
    const double y = random.Uniform(low.y(), high.y()), x = random.Uniform(low.x(), high.x());
    const Eigen::Vector2d place(x, y);
    if (random.Uniform() < 0.6) {
      AddPolyline(place, finder, &random, &out);
    } else {
      AddBlob(place, finder, &random, &out);
    }
  }
  return out;
}

}  // namespace tagtwist::internal

#include "estimator/window/imu/imu_learning.h"

#include <algorithm>
#include <utility>

namespace tagtwist::internal {
namespace {

// After which noise is learned, too; after which that is enough; and when it ends at last.
constexpr double kNoiseS = 4, kEnoughS = 32, kMostS = 512;
constexpr size_t kFewestKept = 12, kMostKept = 200;

// Well enough for what is left open to be small.
bool IsKnown(const ImuResult& found) {
  constexpr double kGravityRad = 0.1, kClockS = 0.02;
  return found.gravity_sigma_rad < kGravityRad && found.time_offset_sigma_s < kClockS;
}

}  // namespace

std::vector<TagDetection> TagsOfState(const FrameMeasurements& measurement,
                                      const WindowOutput& out) {
  std::vector<TagDetection> tags;
  for (const TagDetection& tag : measurement.tags) {
    const auto& used = out.used_tags;
    if (std::find(used.begin(), used.end(), tag.id) != used.end()) tags.push_back(tag);
  }
  return tags;
}

void ImuLearning::Add(const ImuSample& sample) {
  imu_.samples.push_back(sample);
  constexpr int64_t kWaitNs = 2'000'000'000;
  if (kept_.empty()) DropBefore(sample.t_ns - kWaitNs);
}

// Once they are worth moving the others.
void ImuLearning::DropBefore(int64_t t_ns) {
  constexpr std::ptrdiff_t kWorthIt = 1000;
  const auto old = std::find_if(imu_.samples.begin(), imu_.samples.end(),
                                [&](const ImuSample& sample) { return sample.t_ns >= t_ns; });
  if (old - imu_.samples.begin() > kWorthIt) imu_.samples.erase(imu_.samples.begin(), old);
}

// Frames by tags, not too near to one another, and always the newest one.
void ImuLearning::Keep(const FrameMeasurements& measurement, const WindowOutput& out) {
  if (out.current.status != FrameStatus::kOk) return;
  const size_t n = kept_.size();
  if (n > 1 && kept_[n - 1].t_ns - kept_[n - 2].t_ns < kept_spacing_ns_) kept_.pop_back();
  GraphFrame frame;
  frame.t_ns = measurement.t_ns;
  frame.state = out.current.state;
  frame.tags = TagsOfState(measurement, out);
  kept_.push_back(std::move(frame));
}

// Every second of the frames that are kept, for as long as it goes on.
void ImuLearning::ThinOut() {
  if (kept_.size() <= kMostKept) return;
  std::vector<GraphFrame> fewer;
  for (size_t k = kept_.size() % 2 == 0 ? 1 : 0; k < kept_.size(); k += 2) {
    fewer.push_back(std::move(kept_[k]));  // the newest is among them
  }
  kept_ = std::move(fewer);
  kept_spacing_ns_ *= 2;
}

std::optional<ImuSolution> ImuLearning::Add(const EstimatorSetup& setup, const NoiseModel& noise,
                                            const FrameMeasurements& measurement,
                                            const WindowOutput& out) {
  if (!goes_on_) return std::nullopt;
  Keep(measurement, out);
  if (solver_) return GoOn();
  if (kept_.size() < kFewestKept || kept_.back().t_ns != measurement.t_ns) return std::nullopt;
  solved_s_ = ToSeconds(kept_.back().t_ns - kept_.front().t_ns);
  if (solved_s_ < next_s_) return std::nullopt;
  ThinOut();
  // Its noise is learned now and then alone: that takes the longest.
  const bool learns_noise = solved_s_ >= kNoiseS && turn_ % 2 == 0;
  ++turn_;
  next_s_ *= 2;
  solver_.emplace(setup, noise, imu_, kept_, model_, learns_noise);
  return std::nullopt;
}

// A piece of what is being solved.
std::optional<ImuSolution> ImuLearning::GoOn() {
  const auto done = solver_->Advance();
  if (done && !*done) return std::nullopt;
  std::optional<ImuSolution> solved;
  if (done) solved = std::move(*solver_).Finish();
  solver_.reset();
  if (solved) model_ = solved->model;
  const bool is_known = solved && IsKnown(solved->found);
  refusal_ = done ? "the motion did not tell its clock and gravity" : done.error().message;
  if ((is_known && solved_s_ >= kEnoughS) || solved_s_ >= kMostS) {
    goes_on_ = false;
    kept_ = std::vector<GraphFrame>();
  }
  return is_known ? std::move(solved) : std::nullopt;
}

}  // namespace tagtwist::internal

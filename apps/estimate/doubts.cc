#include "apps/estimate/doubts.h"

#include <algorithm>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "apps/estimate/sources.h"
#include "estimator/calibration/set_up/set_up_fault.h"
#include "estimator/evaluation/plausibility.h"
#include "estimator/evaluation/truth_fault.h"
#include "estimator/jobs/find_family.h"
#include "estimator/online/recording_options.h"
#include "frontend/base/format_text.h"
#include "frontend/types/tag_family.h"

namespace tagtwist::internal {
namespace {

// Of frames with a pose that their own tags give.
std::vector<TimedPose> PosesOf(const Estimate& estimate) {
  std::vector<TimedPose> out;
  for (const FrameEstimate& frame : estimate.frames) {
    if (frame.status == FrameStatus::kOk && frame.closed_form.world_from_body) {
      out.push_back({frame.t_ns, *frame.closed_form.world_from_body});
    }
  }
  return out;
}

// Families that may be meant: any where few frames show tags of the map; where some lack them,
// those of the same codes in the other border, which now and then are read through it.
std::vector<std::string> FamiliesInDoubt(const TagMap& map, const TagSample& sample) {
  const size_t count = sample.count(), with_two = sample.with_two();
  if (map.tags().size() == 1) return {};
  if (count == 0 || 2 * with_two <= count) return TagFamilyNames();
  if (20 * with_two > 19 * count) return {};
  if (map.family() == "tag36h11") return {kKalibrFamily};
  return map.family() == kKalibrFamily ? std::vector<std::string>{"tag36h11"}
                                       : std::vector<std::string>();
}

// Where the images show few tags of the map they are looked at again.
std::optional<Fault> OtherTags(const EstimateJob& job, const Config& config,
                               const TagSample& sample) {
  if (job.run.use_detections || IsCamera(job.dataset)) return std::nullopt;
  const std::vector<std::string> families = FamiliesInDoubt(config.set_up.map, sample);
  if (families.empty()) return std::nullopt;
  DataSourceOptions options;
  options.topic = job.topic;
  options.limits = job.config.limits;
  auto source = OpenDataSource(job.dataset, options);
  if (!source) return std::nullopt;
  return FindOtherTags(source->get(), config.set_up.map, families);
}

// An error that says what went wrong, not why.
bool IsMute(const std::string& error) {
  return error.find("positive definite") != std::string::npos ||
         error.find("shows a tag") != std::string::npos;
}

// Corners of one camera.
struct CornerCount {
  size_t off = 0, all = 0;  // off its image, and all

  void Add(const std::vector<TagDetection>& tags, const Camera& camera) {
    for (const TagDetection& tag : tags) {
      for (const Eigen::Vector2d& corner : tag.corners) {
        ++all;
        off += camera.Contains(corner, -1) ? 0 : 1;
      }
    }
  }
};

// Corners where a camera's image ends: its size is another's, or width and height are exchanged.
// Of given detections: those are passed over in silence before anything is measured.
void AddOffTheImage(const EstimateJob& job, const Config& config, Doubts* out) {
  constexpr double kMostShare = 0.02;
  constexpr size_t kFrames = 500;
  if (!job.run.use_detections || IsCamera(job.dataset)) return;
  const std::vector<RigCamera>& cameras = config.set_up.rig.cameras;
  auto source = OpenRecording(job.dataset, config, SourceOptions(job, config));
  if (!source) return;
  std::vector<CornerCount> counts(cameras.size());
  const auto count = [&](const Frame& frame) {
    const auto i = static_cast<size_t>(frame.camera);
    counts[i].Add(frame.detections, cameras[i].camera);
  };
  for (size_t i = 0; i < kFrames; ++i) {
    const auto frame = (*source)->Next();
    if (!frame || !*frame) break;
    count(**frame);
    for (const Frame& other : (*frame)->others) count(other);
  }
  for (size_t i = 0; i < counts.size(); ++i) {
    const Camera& camera = cameras[i].camera;
    const auto [off, all] = std::pair(counts[i].off, counts[i].all);
    if (!(static_cast<double>(off) > kMostShare * static_cast<double>(all))) continue;
    const std::string whose =
        cameras.size() > 1 ? "camera " + cameras[i].name + "'s" : "the camera's";
    out->push_back({Format("%zu of %zu corners lie off ", off, all) + whose +
                        Format(" image of %d x %d px.", camera.width, camera.height),
                    "It is of images of another size, or width and height are exchanged."});
  }
}

// Of each camera; several are named.
Doubts ImplausibleRig(const SetUp& set_up) {
  if (!set_up.rig.IsOfSeveral()) return ImplausibleSetUp(set_up.rig.front().camera, set_up.map);
  Doubts out;
  for (const RigCamera& mounted : set_up.rig.cameras) {
    for (Fault& fault : ImplausibleSetUp(mounted.camera, set_up.map)) {
      fault.fact = "camera " + mounted.name + ": " + fault.fact;
      out.push_back(std::move(fault));
    }
  }
  return out;
}

void Add(std::optional<Fault> fault, Doubts* out) {
  if (fault) out->push_back(*fault);
}

}  // namespace

Doubts DoubtsOf(const EstimateJob& job, const Config& config, const TagSample& sample,
                const std::vector<TruthSample>& truth, const Estimate* estimate,
                const std::string& error) {
  Doubts out = ImplausibleRig(config.set_up);
  AddOffTheImage(job, config, &out);
  if (estimate == nullptr && !IsMute(error)) return out;
  const bool is_of_one = config.recordings.empty();  // what follows looks through one camera
  if (is_of_one) Add(OtherTags(job, config, sample), &out);
  if (out.empty() && is_of_one) {
    Add(FindSetUpFault(sample.frames(), config.set_up.rig.front().camera,
                       config.set_up.rig.front().line_time_s, config.set_up.map),
        &out);
  }
  if (estimate == nullptr) return out;
  for (const Fault& fault : ImplausibleMotion(PosesOf(*estimate))) out.push_back(fault);
  if (!truth.empty() && out.empty() && is_of_one && config.set_up.rig.IsOneOnTheBody()) {
    constexpr double kMaxGapS = 0.1;
    Add(FindTruthFault(EstimatedSeries(estimate->frames), truth,
                       config.set_up.rig.front().cam_from_body, kMaxGapS),
        &out);
  }
  return out;
}

std::string TextOf(const Fault& fault) {
  return fault.fact + (fault.advice.empty() ? "" : " " + fault.advice);
}

Error WithDoubts(const Error& error, const Inputs& inputs, const Doubts& doubts) {
  std::string out = error.message;
  for (const std::string& warning : inputs.warnings) out += "; " + warning;
  for (const Fault& fault : doubts) out += "; " + TextOf(fault);
  return Error{out};
}

}  // namespace tagtwist::internal

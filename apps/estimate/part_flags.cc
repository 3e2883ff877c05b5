#include "apps/estimate/part_flags.h"

#include <gflags/gflags.h>

#include <string>
#include <tuple>
#include <utility>
#include <vector>

DEFINE_string(from, "",
              "Frames before this one are not taken: 3000 (counted from 0), or a share of the "
              "recording, 12.5%.");
DEFINE_string(to, "", "The frame, or share, that the run ends before.");
DEFINE_bool(only_detections, false,
            "The corners of the frames --from to --to are measured, and written as a piece "
            "(piece.json, detections.csv): several runs share a long recording.");
DEFINE_string(pieces, "",
              "Folder of the pieces of all frames, as --only_detections has written them: the "
              "same estimate as without them, without searching the images (batch).");
namespace tagtwist::internal {
namespace {

// What the flag of a part, or of pieces, cannot go together with.
Status CheckAlone(const EstimateJob& job, const std::string& flag, bool is_a_range) {
  std::vector<std::pair<bool, const char*>> others = {{IsCamera(job.dataset), "a camera"},
                                                      {job.map_unknown_tags, "--map_unknown_tags"}};
  if (!is_a_range) {
    others.insert(others.end(), {{job.run.sliding_window, "--sliding_window"},
                                 {job.calibrate, "--calibrate"},
                                 {job.run.use_detections, "--use_detections"}});
  }
  for (const auto& [is_asked, other] : others) {
    if (is_asked) return Error{flag + ": excludes " + other};
  }
  return Ok();
}

}  // namespace

Status PartFromFlags(EstimateJob* job) {
  for (const auto& [flag, text, mark] :
       {std::tuple("--from: ", FLAGS_from, &job->from), std::tuple("--to: ", FLAGS_to, &job->to)}) {
    if (text.empty()) continue;
    const auto parsed = ParseFrameMark(text);
    if (!parsed) return Error{flag + parsed.error().message};
    *mark = *parsed;
  }
  job->only_detections = FLAGS_only_detections;
  job->pieces = FLAGS_pieces;
  const bool is_part = job->from || job->to;
  if (!job->pieces.empty() && (is_part || job->only_detections)) {
    return Error{"--pieces: excludes --from, --to and --only_detections"};
  }
  if (job->only_detections) return CheckAlone(*job, "--only_detections", false);
  if (!job->pieces.empty()) return CheckAlone(*job, "--pieces", false);
  return is_part ? CheckAlone(*job, "--from, --to", true) : Ok();
}

}  // namespace tagtwist::internal

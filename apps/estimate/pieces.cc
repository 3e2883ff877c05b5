#include "apps/estimate/pieces.h"

#include <algorithm>
#include <iostream>
#include <memory>
#include <utility>

#include "apps/estimate/sources.h"
#include "estimator/jobs/pieces/measure_corners.h"
#include "estimator/report/files/corner_piece.h"
#include "frontend/base/files/input_digest.h"
#include "frontend/base/format_text.h"
#include "frontend/base/number_text.h"
#include "frontend/base/printable.h"

namespace tagtwist::internal {
namespace {

// A piece of a recording, still without a range.
CornerPiece PieceOf(const EstimateJob& job, const Config& config,
                    const std::vector<int64_t>& stamps_ns) {
  CornerPiece out;
  out.dataset = job.dataset;
  out.measured_with = DigestText(SearchText(config, job.run.detection));
  out.frames = stamps_ns.size();
  if (stamps_ns.empty()) return out;
  out.first_ns = stamps_ns.front();
  out.last_ns = stamps_ns.back();
  return out;
}

}  // namespace

Status MeasurePiece(const EstimateJob& job, const Config& config) {
  auto source = OpenDataSource(job.dataset, SourceOptions(job, config));
  if (!source) return source.error();
  for (const std::string& note : (*source)->notes()) {
    std::cerr << "tagtwist_estimate: warning: " << Printable(note) << "\n";
  }
  CornerPiece piece = PieceOf(job, config, (*source)->stamps_ns());
  const auto range = RangeOf(job.from, job.to, piece.frames);
  if (!range) return Error{job.dataset + ": " + range.error().message};
  piece.from = range->from;
  piece.to = range->to;
  const auto corners = MeasureCorners(std::move(*source), *range, config, job.run);
  if (!corners) return corners.error();
  if (auto written = WritePiece(job.output, piece, *corners); !written) return written;
  std::cout << Format("frames %zu to %zu of %zu: ", piece.from, piece.to - 1, piece.frames)
            << std::count(corners->begin(), corners->end(), '\n') - 1 << " rows, in " << job.output
            << "/detections.csv\n";
  return Ok();
}

Status AddPieces(const EstimateJob& job, const Config& config, const DataSource& source,
                 RunOptions* options) {
  if (job.pieces.empty()) return Ok();
  const std::vector<int64_t>& stamps_ns = source.stamps_ns();
  auto tags = ReadPieces(job.pieces, PieceOf(job, config, stamps_ns));
  if (!tags) return tags.error();
  for (const auto& [t_ns, of_frame] : *tags) {
    if (std::binary_search(stamps_ns.begin(), stamps_ns.end(), t_ns)) continue;
    return Error{job.pieces + ": has " + std::to_string(of_frame.tags.size()) + " tags at " +
                 FormatSeconds(t_ns) + " s, where " + job.dataset + " has no frame"};
  }
  options->measured = std::make_shared<const MeasuredTags>(std::move(*tags));
  return Ok();
}

}  // namespace tagtwist::internal

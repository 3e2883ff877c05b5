#include "apps/estimate/live_run.h"

#include <algorithm>
#include <iterator>
#include <ostream>
#include <utility>
#include <vector>

#include "apps/estimate/sources.h"
#include "apps/estimate/state_stream.h"
#include "estimator/jobs/online_run.h"
#include "estimator/live/live_feed.h"
#include "estimator/publish/publisher.h"
#include "frontend/base/format_text.h"
#include "frontend/base/statistics/quantile.h"

namespace tagtwist::internal {
namespace {

Result<std::unique_ptr<Publisher>> OpenPublisher(const EstimateJob& job, const Config& config) {
  if (!job.publish.IsAsked()) return std::unique_ptr<Publisher>();
  PublishedRun run;
  run.set_up = config.set_up;
  run.dataset = job.dataset;
  run.body = BodyNames(config).front();
  run.others = config.bodies;
  auto publisher = Publisher::Start(job.publish, run);
  if (!publisher) return publisher;
  for (const std::string& link : (*publisher)->Links()) Messages(job) << link << "\n";
  Messages(job) << std::flush;
  return publisher;
}

FramePtr FrameToPublish(const OnlineFrame& frame) {
  return std::make_shared<const PublishedFrame>(
      PublishedFrame{frame.bodies, frame.images, frame.age_ms, frame.frames_dropped});
}

void WriteRows(const OnlineFrame& frame, const std::vector<std::string>& bodies,
               StateStream* stream) {
  for (size_t i = 0; i < frame.bodies.size(); ++i) {
    stream->Write(frame.bodies[i].state, bodies[i]);
  }
}

// What did not go out: files that were asked for fail the run, all else is told.
void TakeLosses(const std::string& problem, bool failed, std::string* lost,
                std::vector<std::string>* warnings) {
  if (problem.empty()) return;
  if (!failed) {
    warnings->push_back(problem);
  } else if (lost->empty()) {
    *lost = problem;
  }
}

}  // namespace

void MakeLive(const EstimateJob& job, std::unique_ptr<DataSource>* source, RunOptions* options,
              CleanEnd* end) {
  LiveFeed::Options feed_options;
  feed_options.paced = job.realtime;
  feed_options.stop = end->AskFirst();
  auto made = std::make_unique<LiveFeed>(std::move(*source), feed_options);
  LiveFeed* const feed = made.get();
  *source = std::move(made);
  options->threads = 1;  // frames that are measured ahead would be waited for
  options->age_ms = [feed](int64_t t_ns) { return feed->AgeMs(t_ns); };
  options->frames_dropped = [feed] { return feed->dropped(); };
}

std::string LiveText(const LiveRun& live, size_t n_frames) {
  return Format("live: %zu frames, %zu dropped; latency %.1f ms (p99 %.1f)", n_frames,
                live.frames_dropped, Quantile(live.latency_ms, 0.5),
                Quantile(live.latency_ms, 0.99));
}

Result<RunResult> RunAndPublish(const EstimateJob& job, DataSource* source, const Config& config,
                                const RunOptions& options, std::string* lost) {
  const std::vector<std::string> bodies = BodyNames(config);
  std::unique_ptr<StateStream> stream;
  if (!job.stream.empty()) {
    auto opened = StateStream::Open(job.stream, bodies.size() > 1);
    if (!opened) return opened.error();
    stream = std::move(*opened);
  }
  auto publisher = OpenPublisher(job, config);
  if (!publisher) return publisher.error();
  auto run = OnlineRun::Create(job.dataset, source, config, options);
  if (!run) return run.error();
  while (true) {
    const auto state = run->Next();
    if (!state) return state.error();
    if (*state == nullptr) break;
    if (*publisher) (*publisher)->Publish(FrameToPublish(run->frame()));
    if (stream) WriteRows(run->frame(), bodies, stream.get());
  }
  auto out = run->Finish();
  std::vector<std::string> warnings;
  if (stream) TakeLosses(stream->problem(), stream->failed(), lost, &warnings);
  if (*publisher) {
    const Publisher::Losses losses = (*publisher)->Finish();
    TakeLosses(losses.failure, true, lost, &warnings);
    warnings.insert(warnings.end(), losses.warnings.begin(), losses.warnings.end());
  }
  if (out) std::move(warnings.begin(), warnings.end(), std::back_inserter(out->estimate.warnings));
  return out;
}

}  // namespace tagtwist::internal

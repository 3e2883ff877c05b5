#include "estimator/publish/live_verdict.h"

#include <algorithm>

#include "estimator/publish/json_text.h"
#include "frontend/base/format_text.h"
#include "frontend/base/number_text.h"
#include "frontend/base/statistics/quantile.h"

namespace tagtwist::internal {
namespace {

constexpr int64_t kSpanNs = 10'000'000'000;
constexpr size_t kMostEntries = 20'000;  // whatever the stamps say
constexpr size_t kLeastFrames = 20;

std::string Percent(double share) { return Format("%.0f %%", 100 * share); }

}  // namespace

void LiveVerdict::Add(const PublishedFrame& frame, size_t body, const PictureNumbers& numbers) {
  const SeenBody& seen = frame.bodies[body];
  const FrameEstimate& state = seen.state;
  Entry entry{state.t_ns,       state.status,         static_cast<int>(seen.tags.size()),
              frame.latency_ms, frame.frames_dropped, {}};
  if (state.status != FrameStatus::kNoFix) {
    for (const TagDetection& tag : seen.tags) {
      const bool is_used = IsUsed(seen, tag.id);
      entry.tags.emplace_back(tag.id, is_used);
      if (!is_used) why_[tag.id] = numbers.WhySetAside(frame, body, tag);
    }
  }
  entries_.push_back(std::move(entry));
  while (entries_.size() > kMostEntries || entries_.front().t_ns < state.t_ns - kSpanNs) {
    entries_.pop_front();
  }
}

double LiveVerdict::Share(FrameStatus status) const {
  const auto n = std::count_if(entries_.begin(), entries_.end(),
                               [status](const Entry& entry) { return entry.status == status; });
  return static_cast<double>(n) / static_cast<double>(std::max<size_t>(entries_.size(), 1));
}

std::string LiveVerdict::Text() const {
  constexpr double kMany = 0.1;
  if (entries_.empty()) return "No frame has come yet.";
  const Entry& last = entries_.back();
  if (last.status == FrameStatus::kNoFix) {
    if (last.n_seen == 0) return "No state: no tag of the map is in view.";
    return "No state: what the tags in view say leaves the pose open. Show more of them, or move.";
  }
  if (entries_.size() < kLeastFrames) return "Too early to judge.";
  const double blind = Share(FrameStatus::kNoFix) + Share(FrameStatus::kPredicted);
  if (blind > kMany) {
    return Percent(blind) + " of the last frames have no tag to go by: keep the tags in view.";
  }
  if (const auto aside = Aside(); !aside.empty()) {
    return Format("Not to be relied on as it is: tag %d %s", aside.front().id,
                  aside.front().why.c_str()) +
           (aside.size() > 1 ? Format(", and %zu more are set aside.", aside.size() - 1) : ".");
  }
  const size_t dropped = last.dropped - std::min(last.dropped, entries_.front().dropped);
  const double share =
      static_cast<double>(dropped) / static_cast<double>(dropped + entries_.size());
  if (share > kMany) return Percent(share) + " of the frames are dropped: the machine is too slow.";
  if (const double hurried = Share(FrameStatus::kHurried); hurried > kMany) {
    return Percent(hurried) + " of the frames were cut short by the deadline.";
  }
  return "Nothing in the last seconds speaks against it.";
}

std::vector<SetAside> LiveVerdict::Aside() const {
  constexpr double kLeastShare = 0.1;
  std::map<int, std::pair<int, int>> counts;  // seen, left out
  for (const Entry& entry : entries_) {
    for (const auto& [id, is_used] : entry.tags) {
      ++counts[id].first;
      if (!is_used) ++counts[id].second;
    }
  }
  std::vector<SetAside> out;
  for (const auto& [id, count] : counts) {
    const double share = static_cast<double>(count.second) / count.first;
    if (share >= kLeastShare && count.second > 2) out.push_back({id, why_.at(id), share});
  }
  return out;
}

double LiveVerdict::LatencyMs(double quantile) const {
  std::vector<double> latencies;
  for (const Entry& entry : entries_) latencies.push_back(entry.latency_ms);
  return latencies.empty() ? 0 : Quantile(latencies, quantile);
}

double LiveVerdict::RateHz() const {
  if (entries_.size() < 2) return 0;
  const double span_s = ToSeconds(entries_.back().t_ns - entries_.front().t_ns);
  return span_s > 0 ? static_cast<double>(entries_.size() - 1) / span_s : 0;
}

LiveVerdicts::LiveVerdicts(const PublishedRun& run) : verdicts_(run.n_bodies()) {
  for (size_t i = 0; i < run.n_bodies(); ++i) names_.push_back(run.BodyName(i));
}

void LiveVerdicts::Add(const PublishedFrame& frame, const PictureNumbers& numbers) {
  for (size_t i = 0; i < verdicts_.size(); ++i) verdicts_[i].Add(frame, i, numbers);
}

std::string LiveVerdicts::Text() const {
  if (verdicts_.size() == 1) return verdicts_.front().Text();
  std::string out;
  for (size_t i = 0; i < verdicts_.size(); ++i) {
    out += (i == 0 ? "" : " ") + names_[i] + ": " + verdicts_[i].Text();
  }
  return out;
}

std::string LiveVerdicts::FactsJson(const PublishedFrame& last,
                                    const std::string& recording_json) const {
  const LiveVerdict& first = verdicts_.front();
  JsonText json;
  json.Open('{').Key("type").String("facts").Key("t").Raw(FormatSeconds(last.t_ns()));
  json.Key("status").Open('{');
  for (size_t i = 0; i < names_.size(); ++i) {
    json.Key(names_[i]).String(ToString(last.bodies[i].state.status));
  }
  json.Close('}').Key("verdict").String(Text());
  json.Key("rate_hz").Number(first.RateHz(), 4);
  json.Key("latency_ms").Open('{').Key("p50").Number(first.LatencyMs(0.5), 4);
  json.Key("p99").Number(first.LatencyMs(0.99), 4).Close('}');
  json.Key("frames_dropped").Integer(static_cast<int64_t>(last.frames_dropped));
  json.Key("set_aside").Open('[');
  for (const LiveVerdict& verdict : verdicts_) {
    for (const SetAside& tag : verdict.Aside()) {
      json.Open('{').Key("id").Integer(tag.id).Key("why").String(tag.why);
      json.Key("share").Number(tag.share, 3).Close('}');
    }
  }
  return json.Close(']').Key("recording").Raw(recording_json).Close('}').text();
}

}  // namespace tagtwist::internal

#include "apps/estimate/publish_flags.h"

#include <gflags/gflags.h>

#include <sstream>

#include "apps/support/port_text.h"

DEFINE_string(
    page, "",
    "A page that shows the run, on this machine alone unless --listen is given: PORT, 8765 "
    "where none is said, 0 for any that is free (live).");
DEFINE_string(listen, "",
              "IP address to serve --page and foxglove at, 0.0.0.0 for all of the machine's; who "
              "wants in needs the token of the link that is told.");
DEFINE_string(
    publish, "",
    "Where each frame's state goes as soon as it is known (window): udp://HOST:PORT (JSON), "
    "mcap:FILE, foxglove (Foxglove's WebSocket, on the page's port; live), csv:FILE or csv:- (what "
    "--stream does). May be given several times.");
DEFINE_string(record, "",
              "New folder or FILE.mkv (lossless) for the images as they come, with their stamps, "
              "which --dataset reads (window); the page can stop and go on with it.");

namespace tagtwist::internal {
namespace {

bool TakeAfter(const std::string& prefix, const std::string& text, std::string* rest) {
  if (text.rfind(prefix, 0) != 0) return false;
  *rest = text.substr(prefix.size());
  return true;
}

Status BadPlace(const std::string& place) {
  return Error{
      "--publish: expected udp://HOST:PORT, mcap:FILE, foxglove, csv:FILE or csv:-, got '" + place +
      "'"};
}

Status TakePlace(const std::string& place, PublishFlags* out) {
  std::string rest;
  if (place == "foxglove") {
    out->options.foxglove = true;
  } else if (TakeAfter("udp://", place, &rest)) {
    const size_t colon = rest.rfind(':');
    const bool has_host = colon != std::string::npos && colon > 0;
    if (!has_host || !PortOf(rest.substr(colon + 1), 1)) return BadPlace(place);
    out->options.udp.push_back(rest);
  } else if (TakeAfter("mcap:", place, &rest)) {
    if (rest.empty()) return BadPlace(place);
    if (!out->options.mcap.empty()) return Error{"--publish: mcap given twice: one run writes one"};
    out->options.mcap = rest;
  } else if (TakeAfter("csv:", place, &rest)) {
    if (rest.empty()) return BadPlace(place);
    if (!out->csv.empty()) return Error{"--publish: csv given twice: one run writes one"};
    out->csv = rest;
  } else {
    return BadPlace(place);
  }
  return Ok();
}

Status CheckUse(const EstimateJob& job, bool is_live, const PublishFlags& flags) {
  const PublishOptions& asked = flags.options;
  if ((asked.IsAsked() || !flags.csv.empty()) && !job.run.sliding_window) {
    return Error{"--page, --publish, --record: need --sliding_window"};
  }
  if (!flags.csv.empty() && !job.stream.empty()) {
    return Error{"--publish csv: --stream is given, too: one run writes one"};
  }
  if ((asked.page || asked.foxglove) && !is_live) {
    return Error{"--page, --publish foxglove: need a camera or --realtime"};
  }
  if (asked.listen && !asked.page && !asked.foxglove) {
    return Error{"--listen: needs --page or --publish foxglove"};
  }
  if (!asked.record.empty() && !job.read_images) {
    return Error{"--record: needs images, which --use_detections without tracks does not read"};
  }
  return Ok();
}

}  // namespace

Result<PublishFlags> PublishFromFlags(const EstimateJob& job, bool is_live) {
  PublishFlags out;
  out.options.port = kUsualPort;
  out.options.waits = !is_live;
  out.options.record = FLAGS_record;
  if (!FLAGS_page.empty()) {
    const auto port = PortOf(FLAGS_page, 0);
    if (!port) return Error{"--page: expected a port, 0 to 65535, got '" + FLAGS_page + "'"};
    out.options.page = true;
    out.options.port = *port;
  }
  if (!FLAGS_listen.empty()) out.options.listen = FLAGS_listen;
  std::istringstream places(FLAGS_publish);
  for (std::string place; std::getline(places, place);) {
    if (const Status taken = TakePlace(place, &out); !taken) return taken.error();
  }
  if (const Status fine = CheckUse(job, is_live, out); !fine) return fine.error();
  return out;
}

}  // namespace tagtwist::internal

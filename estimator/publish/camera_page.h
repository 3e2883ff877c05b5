#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "estimator/jobs/camera/guide_camera.h"
#include "estimator/publish/web/web_place.h"
#include "estimator/publish/web/web_server.h"
#include "estimator/publish/worker.h"
#include "frontend/base/result.h"

namespace tagtwist::internal {

/// How a calibration ended, for those who watched it.
struct CameraVerdictToShow {
  bool is_good = false;
  std::string text;                        // "good: nothing speaks against it"
  std::shared_ptr<const LensFound> found;  // empty: none
};

/// A page on which a live calibration is watched: the image with the corners found, where the image
/// was covered so far, what to show next, the lens' numbers with their sigmas as they shrink, and
/// the verdict. Sent by a thread of its own: whoever shows something never waits.
class CameraPage {
 public:
  struct Options {
    uint16_t port = 0;                  // 0: any that is free
    std::optional<std::string> listen;  // an IP address, with a token; nullopt: this machine alone
    std::string recording;              // as the user named it
  };
  /// "127.0.0.1:8765: Address already in use".
  static Result<std::unique_ptr<CameraPage>> Start(const Options& options);
  ~CameraPage();
  CameraPage(const CameraPage&) = delete;
  CameraPage& operator=(const CameraPage&) = delete;

  /// "page       http://127.0.0.1:8765/"
  std::string Link() const;
  void Show(const GuideView& view);
  /// The last word, once; nothing may be shown afterwards.
  void End(const CameraVerdictToShow& verdict);

 private:
  // What a lens was known to when so many frames were kept.
  struct Known {
    size_t kept = 0;
    std::shared_ptr<const LensFound> lens;
  };
  CameraPage() = default;
  void Send(const GuideView& view);
  void SendFacts(const GuideView& view, const std::string& verdict_json);

  WebPlace place_;
  std::unique_ptr<WebServer> server_;
  std::vector<Known> known_;  // the latest last
  GuideView last_;
  std::unique_ptr<Worker<std::shared_ptr<const GuideView>>> worker_;  // last member
};

/// The page: one HTML file that needs no other.
std::string CameraPageHtml();

}  // namespace tagtwist::internal

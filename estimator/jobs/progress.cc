#include "estimator/jobs/progress.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <utility>

namespace tagtwist::internal {

std::string ProgressLine(const std::string& label, size_t done, size_t total, double elapsed_s) {
  if (total == 0) return label + "  " + std::to_string(done);
  constexpr size_t kBarWidth = 30;
  const double fraction = std::min(1.0, static_cast<double>(done) / static_cast<double>(total));
  const auto filled = static_cast<size_t>(fraction * kBarWidth);
  std::string percent = std::to_string(static_cast<int>(100 * fraction));
  percent.insert(0, 3 - percent.size(), ' ');
  std::string out = label + " [" + std::string(filled, '#') + std::string(kBarWidth - filled, '.') +
                    "] " + percent + "%  " + std::to_string(done) + "/" + std::to_string(total);
  if (done > 0 && done < total) {
    const double left_s = elapsed_s * (1 - fraction) / fraction;
    out += "  " + std::to_string(std::lround(std::ceil(left_s))) + " s left";
  }
  return out;
}

Progress::Progress(std::string label, size_t total)
    : label_(std::move(label)),
      total_(total),
      on_terminal_(isatty(STDERR_FILENO) == 1),
      start_(std::chrono::steady_clock::now()),
      last_drawn_(start_) {}

Progress::~Progress() {
  if (on_terminal_) std::cerr << "\r\033[K" << std::flush;
}

void Progress::Update(size_t done) {
  if (!on_terminal_) return;
  const auto now = std::chrono::steady_clock::now();
  if (now - last_drawn_ < std::chrono::milliseconds(100)) return;
  last_drawn_ = now;
  const double elapsed_s = std::chrono::duration<double>(now - start_).count();
  std::cerr << "\r" << ProgressLine(label_, done, total_, elapsed_s) << "\033[K" << std::flush;
}

}  // namespace tagtwist::internal

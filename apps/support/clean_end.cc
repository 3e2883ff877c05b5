#include "apps/support/clean_end.h"

#include <fcntl.h>
#include <sys/eventfd.h>
#include <sys/poll.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <iostream>
#include <utility>

#include "frontend/base/files/file_set.h"
#include "frontend/base/files/partial.h"
#include "frontend/base/printable.h"

namespace tagtwist::internal {
namespace {

// Those that would end the process: one that is ignored (nohup, a job in the background) stays so.
sigset_t Interrupts() {
  sigset_t out;
  sigemptyset(&out);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    struct sigaction current = {};
    ::sigaction(signal, nullptr, &current);
    if (current.sa_handler != SIG_IGN) sigaddset(&out, signal);
  }
  return out;
}

void TellLeftovers(const std::string& program, const Outputs& outputs) {
  std::vector<std::string> lines;
  if (!outputs.set_folder.empty()) {
    const auto recovered = RecoverFileSet(outputs.set_folder);
    if (recovered) lines = *recovered;
    if (!recovered) lines.push_back(recovered.error().message);
  }
  for (const std::string& file : outputs.files) {
    for (const std::string& left : RemoveLeftovers(file)) {
      lines.push_back(left + ": left by a run that was ended: removed");
    }
  }
  for (const std::string& line : lines) std::cerr << program << ": " << Printable(line) << "\n";
}

}  // namespace

CleanEnd::CleanEnd(const Usage& usage, Outputs outputs)
    : program_(usage.program), outputs_(std::move(outputs)) {
  auto& files = outputs_.files;
  files.erase(std::remove(files.begin(), files.end(), ""), files.end());
  TellLeftovers(program_, outputs_);
  const sigset_t interrupts = Interrupts();
  pthread_sigmask(SIG_BLOCK, &interrupts, nullptr);
  signals_ = ::signalfd(-1, &interrupts, SFD_CLOEXEC);
  wake_ = ::eventfd(0, EFD_CLOEXEC);
  watcher_ = std::thread([this] { Watch(); });
}

CleanEnd::~CleanEnd() {
  const uint64_t one = 1;
  while (::write(wake_, &one, sizeof(one)) != sizeof(one)) {
  }
  watcher_.join();
  ::close(signals_);
  ::close(wake_);
  const sigset_t interrupts = Interrupts();
  pthread_sigmask(SIG_UNBLOCK, &interrupts, nullptr);
}

std::function<bool()> CleanEnd::AskFirst() {
  ask_first_ = true;
  return [this] { return asked_.load(); };
}

void CleanEnd::Watch() {
  while (true) {
    std::array<pollfd, 2> ready = {{{signals_, POLLIN, 0}, {wake_, POLLIN, 0}}};
    if (::poll(ready.data(), ready.size(), -1) < 0) continue;
    if (ready[1].revents != 0) return;
    signalfd_siginfo signal{};
    if (::read(signals_, &signal, sizeof(signal)) != sizeof(signal)) continue;
    if (!ask_first_ || asked_.exchange(true)) End(static_cast<int>(signal.ssi_signo));
  }
}

void CleanEnd::End(int signal) {
  const std::string line = program_ + ": interrupted, nothing half-written is left\n";
  const bool told = ::write(STDERR_FILENO, line.data(), line.size()) > 0;
  // What the other threads would say of files that go from under them is nobody's concern.
  const int nowhere = ::open("/dev/null", O_WRONLY | O_CLOEXEC);
  if (told && nowhere >= 0) ::dup2(nowhere, STDERR_FILENO);
  for (const std::string& file : outputs_.files) RemoveOwnPartials(file);
  if (!outputs_.set_folder.empty()) {
    RemoveOwnPartials(outputs_.set_folder);
    RemoveOwnPartials(outputs_.set_folder + "/results");
    constexpr int kMostWaits = 500;
    for (int i = 0; i < kMostWaits && !IsFileSetWhole(outputs_.set_folder); ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    RemoveOwnPartials(outputs_.set_folder + "/results");
  }
  std::signal(signal, SIG_DFL);
  const sigset_t interrupts = Interrupts();
  pthread_sigmask(SIG_UNBLOCK, &interrupts, nullptr);
  ::raise(signal);
  ::_exit(128 + signal);
}

}  // namespace tagtwist::internal

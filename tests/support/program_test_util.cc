#include "tests/support/program_test_util.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <random>
#include <thread>

#include "estimator/online/config.h"
#include "frontend/simulation/named_flights.h"
#include "frontend/simulation/simulator.h"
#include "tests/support/test_files.h"

namespace tagtwist::internal {
namespace {

namespace fs = std::filesystem;

// The environment with the sanitizers' exit status moved away from the programs' own.
std::vector<std::string> ProgramEnvironment() {
  std::vector<std::string> out = {"ASAN_OPTIONS=exitcode=99"};
  for (char** entry = environ; *entry != nullptr; ++entry) {
    if (std::string(*entry).rfind("ASAN_OPTIONS=", 0) != 0) out.emplace_back(*entry);
  }
  return out;
}

std::vector<char*> Pointers(std::vector<std::string>* texts) {
  std::vector<char*> out;
  out.reserve(texts->size() + 1);
  for (std::string& text : *texts) out.push_back(text.data());
  out.push_back(nullptr);
  return out;
}

SplineTrajectory ShortFlight(const TagMap& map) {
  FlightOptions options;
  options.duration_s = 2;
  auto trajectory = FlightPath("figure8", map, options);
  if (!trajectory) throw std::runtime_error(trajectory.error().message);
  return *trajectory;
}

Simulator PlainSimulator(bool images) {
  const Config config = DefaultConfig();
  SimulatorOptions options;
  options.images = images;
  options.exposure_s = 0;
  options.renderer.supersampling = 2;
  options.renderer.scene.scribbles_per_m2 = 0;
  const auto simulator = Simulator::Make(config.set_up, ShortFlight(config.set_up.map), options);
  if (!simulator) throw std::runtime_error(simulator.error().message);
  return *simulator;
}

void ThrowUnless(const Status& status) {
  if (!status) throw std::runtime_error(status.error().message);
}

}  // namespace

ProgramRun RunProgram(const std::string& folder, const std::string& program,
                      const std::vector<std::string>& arguments,
                      const std::function<bool()>& interrupt_when, const Surroundings& around) {
  const TempFolder capture;
  const std::string out_path = around.out.empty() ? capture / "out" : around.out,
                    err_path = capture / "err";
  std::vector<std::string> words = {TAGTWIST_PROGRAM_DIR "/" + program};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<std::string> environment = ProgramEnvironment();
  environment.insert(environment.end(), around.environment.begin(), around.environment.end());

  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, 1, out_path.c_str(), O_WRONLY | O_CREAT, 0600);
  posix_spawn_file_actions_addopen(&actions, 2, err_path.c_str(), O_WRONLY | O_CREAT, 0600);
  posix_spawn_file_actions_addchdir_np(&actions, folder.c_str());
  pid_t pid = 0;
  const int failed = posix_spawn(&pid, words[0].c_str(), &actions, nullptr, Pointers(&words).data(),
                                 Pointers(&environment).data());
  posix_spawn_file_actions_destroy(&actions);
  ProgramRun run;
  if (failed != 0) {
    run.err = words[0] + ": cannot start\n";
    return run;
  }
  const auto began = std::chrono::steady_clock::now();
  int wait_status = 0;
  rusage usage{};
  while (interrupt_when && wait4(pid, &wait_status, WNOHANG, &usage) == 0) {
    if (interrupt_when()) {
      kill(pid, around.signal);
      break;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  wait4(pid, &wait_status, 0, &usage);
  // The kernel counts what a program's process had before it became the program: this one's.
  rusage own{};
  getrusage(RUSAGE_SELF, &own);
  if (usage.ru_maxrss > own.ru_maxrss) {
    run.peak_rss_mib = static_cast<double>(usage.ru_maxrss) / 1024;  // Linux counts KiB
  }
  run.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  if (WIFEXITED(wait_status)) run.status = WEXITSTATUS(wait_status);
  if (around.out.empty()) run.out = ReadText(out_path);
  run.err = ReadText(err_path);
  return run;
}

bool IsOneLine(const std::string& text) {
  return text.size() > 1 && text.find('\n') == text.size() - 1;
}

std::string MakeRecording(const std::string& folder, const std::string& name, DatasetFormat format,
                          bool images) {
  std::string path = folder + "/" + name;
  const Simulator simulator = PlainSimulator(images);
  const auto writer = CreateDatasetWriter(path, format);
  if (!writer) throw std::runtime_error(writer.error().message);
  std::vector<TruthSample> truth;
  for (uint64_t i = 0; i < 6; ++i) {
    const SimulatedFrame frame =
        simulator.MakeFrame(i, simulator.trajectory().first_ns() + 20'000'000 * int64_t(i));
    ThrowUnless((*writer)->Add({frame.t_ns, frame.image, frame.detections}));
    truth.push_back({frame.t_ns, frame.truth.world_from_body, frame.truth.twist});
  }
  ThrowUnless((*writer)->Finish(truth, simulator.MakeImu(truth.front().t_ns, truth.back().t_ns)));
  return path;
}

void ReplaceLine(const std::string& path, size_t number, const std::string& line) {
  std::istringstream text(ReadText(path));
  std::vector<std::string> lines;
  for (std::string each; std::getline(text, each);) lines.push_back(each);
  if (number > lines.size()) {
    lines.push_back(line);
  } else {
    lines[number - 1] = line;
  }
  std::string out;
  for (const std::string& each : lines) out.append(each).append("\n");
  WriteText(path, out);
}

void Truncate(const std::string& path, long bytes) {
  const auto size = static_cast<long>(fs::file_size(path));
  fs::resize_file(path, static_cast<uintmax_t>(bytes < 0 ? size + bytes : std::min(size, bytes)));
}

std::string Garbage() {
  std::mt19937 rng(7);
  std::string out;
  for (int i = 0; i < 4096; ++i) out += static_cast<char>(rng() & 0xff);
  return out;
}

std::vector<std::string> ListTree(const std::string& folder) {
  std::vector<std::string> out;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    out.push_back(fs::relative(entry.path(), folder).string());
  }
  std::sort(out.begin(), out.end());
  return out;
}

bool HasNoResults(const std::string& folder) {
  namespace fs = std::filesystem;
  if (!fs::exists(folder)) return true;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().filename() != "summary.json") return false;
    if (ReadText(entry.path()).find("\"status\": \"failed\"") == std::string::npos) return false;
  }
  return true;
}

}  // namespace tagtwist::internal

#include "app/guard/stop_run.h"

#include <fmt/format.h>
#include <poll.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <future>
#include <optional>
#include <thread>

#include "app/guard/safety_net.h"
#include "app/run/exit_status.h"
#include "app/run/output.h"

namespace skein::app {
namespace {

using namespace std::chrono_literals;

constexpr double hears_within = 0.3;    // a run that lives [s]
constexpr auto ends_within = 300ms;     // after SIGTERM
constexpr auto killed_within = 2000ms;  // after SIGKILL
constexpr auto guard_within = 1500ms;   // it waits 1 s for answers on the lines, then listens

/// A process that cannot be mistaken for a later one of the same number.
class Process {
 public:
  explicit Process(pid_t process) : descriptor_(static_cast<int>(::syscall(SYS_pidfd_open, process, 0))) {}
  ~Process() {
    if (descriptor_ >= 0) ::close(descriptor_);
  }
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  bool known() const noexcept { return descriptor_ >= 0; }
  void send(int signal) const noexcept { ::syscall(SYS_pidfd_send_signal, descriptor_, signal, nullptr, 0); }
  bool ends(std::chrono::milliseconds within) const noexcept {
    pollfd polled{descriptor_, POLLIN, 0};
    return ::poll(&polled, 1, static_cast<int>(within.count())) > 0;
  }

 private:
  int descriptor_;
};

bool is_there(const RunMarker& run) {
  return ::access(run.path.c_str(), F_OK) == 0;
}

std::vector<StopResult> all_of(const RunMarker& run, bool stopped, const std::string& reason) {
  std::vector<StopResult> all;
  for (const comms::LinkAddress& robot : run.robots) all.push_back({comms::to_text(robot), stopped, reason});
  return all;
}

/// A run that ended without a word: its guard says, or its marker is gone, since all robots stand.
StoppedRun ask_guard(const RunMarker& run) {
  const auto give_up = std::chrono::steady_clock::now() + guard_within;
  do {
    if (!is_there(run)) return {all_of(run, true, {}), false};
    const StopAnswer answer = ask_run(run.socket(), "stop", hears_within);
    if (answer.robots) return {*answer.robots, false};
    std::this_thread::sleep_for(10ms);
  } while (std::chrono::steady_clock::now() < give_up);
  return {all_of(run, false, "it has no guard"), true};
}

void say(const StopResult& robot) {
  if (robot.stopped)
    print_out(fmt::format("{}: stopped\n", robot.address));
  else
    complain(fmt::format("{}: NOT known to be stopped: {}", robot.address, robot.reason));
}

}  // namespace

StoppedRun stop_run(const RunMarker& run) {
  const StopAnswer answer = ask_run(run.socket(), "stop", hears_within);
  if (answer.robots) return {*answer.robots, false};
  // It may have been frozen in the middle of the answer.
  if (answer.reached && !answer.ended && answer.process > 0) {
    const Process process(answer.process);
    if (process.known()) {
      complain(fmt::format("the run \"{}\" (process {}) does not respond to STOP: ending it", run.experiment,
                           answer.process));
      process.send(SIGTERM);
      if (!process.ends(ends_within)) process.send(SIGKILL);
      process.ends(killed_within);
    }
  }
  if (!answer.reached && !run.alive() && is_there(run)) return {all_of(run, false, "its run has ended"), true};
  return ask_guard(run);
}

bool stop_left_behind(const std::vector<RunMarker>& runs) {
  bool all_stand = true;
  for (const RunMarker& run : runs) {
    const StoppedRun result = stop_run(run);
    const bool stand = result.by_hand ? stop_all(run.robots)
                                      : std::all_of(result.robots.begin(), result.robots.end(),
                                                    [](const StopResult& robot) { return robot.stopped; });
    if (stand && !run.alive()) run.forget();
    all_stand = all_stand && stand;
  }
  return all_stand;
}

int stop_runs() {
  const std::vector<RunMarker> runs = all_markers();
  std::vector<std::future<StopAnswer>> answers;
  for (const RunMarker& run : runs)
    answers.push_back(std::async(std::launch::async, [&run] { return ask_run(run.socket(), "stop", hears_within); }));
  int status = done, reached = 0;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const StopAnswer answer = answers[i].get();
    if (!answer.reached) continue;
    ++reached;
    if (answer.robots) {
      print_out(fmt::format("the run \"{}\" is stopped\n", runs[i].experiment));
      for (const StopResult& robot : *answer.robots) {
        say(robot);
        if (!robot.stopped) status = device_failed;
      }
    } else if (!answer.heard) {
      complain(fmt::format("the run \"{}\" does not respond to STOP: `skein robots stop` ends it", runs[i].experiment));
      status = device_failed;
    } else {
      print_out(fmt::format("the run \"{}\" has ended\n", runs[i].experiment));
    }
  }
  if (reached == 0) print_out("no run is active\n");
  return status;
}

int forget_runs() {
  for (const RunMarker& run : all_markers()) {
    if (run.alive()) continue;
    ask_run(run.socket(), "forget", hears_within);
    run.dismiss();
    print_out(fmt::format("the run \"{}\" is forgotten:", run.experiment));
    for (const comms::LinkAddress& robot : run.robots) print_out(" " + comms::to_text(robot));
    print_out("\n");
  }
  return done;
}

}  // namespace skein::app

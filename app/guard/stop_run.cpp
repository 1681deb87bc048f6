#include "app/guard/stop_run.h"

#include <fmt/format.h>
#include <poll.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <future>
#include <iterator>
#include <memory>
#include <optional>
#include <thread>
#include <utility>

#include "app/guard/safety_net.h"
#include "app/run/exit_status.h"
#include "app/run/interrupted.h"
#include "app/run/output.h"
#include "app/run/terminal_text.h"
#include "comms/link_supervisor.h"

namespace skein::app {
namespace {

using namespace std::chrono_literals;

using Clock = std::chrono::steady_clock;

constexpr double hears_within = 0.3;    // a run that lives [s]
constexpr auto ends_within = 300ms;     // after SIGTERM
constexpr auto killed_within = 2000ms;  // after SIGKILL
constexpr auto guard_within = 1500ms;   // it waits 1 s for answers on the lines, then listens
constexpr auto ask_again = 20ms;

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
  all.reserve(run.robots.size());
  for (const comms::LinkAddress& robot : run.robots) all.push_back({comms::to_text(robot), stopped, reason});
  return all;
}

/// The guard of this run, frozen or not.
std::unique_ptr<Process> guard_of(const RunMarker& run) {
  namespace fs = std::filesystem;
  const std::string marker = fmt::format("{}={}", marker_variable, run.path);
  std::error_code gone;
  for (const fs::directory_entry& entry : fs::directory_iterator("/proc", gone)) {
    const std::string name = entry.path().filename();
    pid_t number = 0;
    if (std::from_chars(name.data(), name.data() + name.size(), number).ptr != name.data() + name.size()) continue;
    auto process = std::make_unique<Process>(number);  // first: the number may be another's a moment later
    std::ifstream environment(entry.path() / "environ");
    std::string first;
    std::getline(environment, first, '\0');
    if (process->known() && first == marker) return process;
  }
  return nullptr;
}

/// What the present listener says: the run, or its guard once it has ended.
StopAnswer ask(const RunMarker& run) {
  StopAnswer answer = ask_run(run.socket(), "stop", hears_within);
  // A run may have been frozen in the middle of the answer.
  if (answer.robots || !answer.reached || answer.ended || answer.process <= 0 || interrupted()) return answer;
  const Process process(answer.process);
  if (!process.known()) return answer;
  complain(
      fmt::format("the run \"{}\" (process {}) does not respond to STOP: ending it", run.experiment, answer.process));
  process.send(SIGTERM);
  if (!process.ends(ends_within)) process.send(SIGKILL);
  process.ends(killed_within);
  return answer;
}

void say(const StopResult& robot) {
  if (robot.stopped)
    print_out(fmt::format("{}: stopped\n", robot.address));
  else
    complain(fmt::format("{}: NOT known to be stopped: {}", robot.address, robot.reason));
}

}  // namespace

StoppedRun stop_run(const RunMarker& run) {
  const auto give_up = Clock::now() + std::chrono::duration<double>(comms::reach_patience(run.robots));
  const auto tell_at = Clock::now() + silent_for;
  bool told = false;
  std::vector<StopResult> robots = all_of(run, false, "neither its run nor its guard has answered");
  // A guard that is frozen goes on at once: it holds the connections, and the run may be frozen as well.
  const auto waking = std::async(std::launch::async | std::launch::deferred, [&run] {
    if (const auto guard = guard_of(run)) guard->send(SIGCONT);
  });
  if (waking.wait_for(0s) == std::future_status::deferred) waking.wait();  // no thread could be started
  for (auto heard = Clock::now();; std::this_thread::sleep_for(ask_again)) {
    if (!is_there(run)) return {all_of(run, true, {}), false};  // its guard has stopped all of them
    const StopAnswer answer = ask(run);
    if (answer.reached) heard = Clock::now();
    if (answer.robots) {
      robots = *answer.robots;
      // A guard names those alone that it had to reach anew.
      if (all_stand(robots)) return {robots.size() < run.robots.size() ? all_of(run, true, {}) : robots, false};
    }
    if (interrupted() || Clock::now() > give_up) return {robots, false};
    if (Clock::now() > tell_at && !std::exchange(told, true))
      for (const StopResult& robot : robots)
        if (!robot.stopped) complain_of_waiting(robot.address, robot.reason);
    if (answer.reached) continue;
    const std::unique_ptr<Process> guard = run.alive() ? nullptr : guard_of(run);
    if (!guard && !run.alive() && is_there(run)) return {robots, true};
    if (Clock::now() - heard < guard_within) continue;
    if (guard) {
      complain(fmt::format("the guard of the run \"{}\" does not respond: ending it", run.experiment));
      guard->send(SIGKILL);
      guard->ends(killed_within);
    }
    return {robots, true};
  }
}

bool stop_left_behind(const std::vector<RunMarker>& runs) {
  bool every_run_stands = true;
  for (const RunMarker& run : runs) {
    const StoppedRun result = stop_run(run);
    const bool stand = result.by_hand ? stop_all(run.robots) : all_stand(result.robots);
    if (stand && !run.alive()) run.forget();
    every_run_stands = every_run_stands && stand;
  }
  return every_run_stands;
}

int stop_runs() {
  const auto [runs, unreadable] = find_markers();
  std::vector<std::future<StopAnswer>> answers;
  answers.reserve(runs.size());
  // One after the other where no thread can be started.
  for (const RunMarker& run : runs)
    answers.push_back(std::async(std::launch::async | std::launch::deferred,
                                 [&run] { return ask_run(run.socket(), "stop", hears_within); }));
  int status = done, reached = 0;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const StopAnswer answer = answers[i].get();
    if (!answer.reached && !is_there(runs[i])) continue;
    ++reached;
    if (!answer.reached) {
      complain(fmt::format(
          "the run \"{}\" cannot be reached, and its robots may still drive: `skein robots stop` stops them",
          shown(runs[i].experiment)));
      status = device_failed;
    } else if (answer.robots) {
      print_out(fmt::format("the run \"{}\" is stopped\n", shown(runs[i].experiment)));
      for (const StopResult& robot : *answer.robots) {
        say(robot);
        if (!robot.stopped) status = device_failed;
      }
    } else if (!answer.heard) {
      complain(fmt::format("the run \"{}\" does not respond to STOP: `skein robots stop` ends it", runs[i].experiment));
      status = device_failed;
    } else {
      print_out(fmt::format("the run \"{}\" has ended\n", shown(runs[i].experiment)));
    }
  }
  if (!unreadable.empty()) {
    complain(unreadable);
    status = device_failed;
  } else if (reached == 0) {
    print_out("no run is active\n");
  }
  return status;
}

void forget_left_behind(const std::vector<RunMarker>& runs) {
  for (const RunMarker& run : runs) {
    if (run.alive()) continue;
    ask_run(run.socket(), "forget", hears_within);
    run.dismiss();
  }
}

int forget_runs() {
  const std::vector<RunMarker> runs = bad_ends();
  forget_left_behind(runs);
  for (const RunMarker& run : runs) {
    print_out(fmt::format("the run \"{}\" is forgotten:", shown(run.experiment)));
    for (const comms::LinkAddress& robot : run.robots) print_out(" " + comms::to_text(robot));
    print_out("\n");
  }
  return done;
}

}  // namespace skein::app

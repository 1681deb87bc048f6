#include "app/guard/safety_net.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <spawn.h>
#include <sys/eventfd.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <future>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>

#include "app/guard/run_marker.h"
#include "app/run/interrupted.h"
#include "app/run/output.h"
#include "comms/link_supervisor.h"
#include "comms/power_down_delay.h"
#include "comms/watchdog.h"

extern char** environ;

namespace skein::app {
namespace {

using comms::GuardMessage;

constexpr double stop_timeout = 2.0;                    // [s]
constexpr int poll_every = 100, poll_often = 20;        // [ms]
constexpr std::int64_t frozen_after = 800'000'000;      // a guard that has not beaten for so long does not guard [ns]
constexpr std::int64_t between_guards = 1'000'000'000;  // one that cannot live is not started all the time [ns]
constexpr std::int64_t awaited_for = 1'000'000'000;     // the first guard, before the run opens a line [ns]

}  // namespace

/// Everything but the guard's process; its thread uses it, so that it cannot move.
class SafetyNet::Keeper {
 public:
  explicit Keeper(const Run& run) : run_(run) {}
  ~Keeper();
  Keeper(const Keeper&) = delete;
  Keeper& operator=(const Keeper&) = delete;

  tl::expected<void, std::string> begin();
  void on_stop(Stop stop, std::function<std::vector<StopResult>()> results);
  void done(const std::vector<StopResult>& robots);
  std::vector<std::string> alarms() {
    const std::lock_guard lock(mutex_);
    return std::exchange(alarms_, {});
  }
  pid_t process() const {
    const pid_t guard = page_ ? page_->guard_process.load() : 0;
    return guard > 0 ? guard : -1;
  }

 private:
  tl::expected<void, std::string> start_guard();
  void await_guard() const;
  void drop_guard();
  void dismiss_guard();
  bool guard_has_ended() const;
  void forget_starter();
  void run();
  void look_after_guard();
  void alarm(const std::string& sentence);
  void end_thread();
  void stop(const std::string& why);
  void heed_power_down();
  std::vector<StopResult> results();

  const Run run_;
  RunMarker marker_;
  int lock_ = -1;  // the marker's
  std::optional<StopSocket> socket_;
  std::optional<comms::PowerDownDelay> power_down_;  // until the robots stand after an announcement
  bool powers_down_ = false;
  comms::HeartbeatPage* page_ = nullptr;
  int memory_ = -1, guard_socket_ = -1, wake_ = -1;
  pid_t starter_ = -1;  // this process's child, which the guard leaves at once; -1: it has been waited for
  std::int64_t started_at_ = 0;
  std::jthread thread_;

  std::recursive_mutex calls_;  // held while a callback runs
  Stop stop_;
  std::function<std::vector<StopResult>()> results_;
  std::string why_;  // of the STOP; empty: none has come
  std::mutex mutex_;
  std::vector<std::string> alarms_;  // guarded by mutex_
  std::string last_alarm_;           // likewise; the same is not said every second
};

tl::expected<void, std::string> SafetyNet::Keeper::begin() {
  wake_ = ::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC);
  marker_ = {{}, run_.name, run_.robots};
  const auto written = write_marker(marker_);
  if (!written) return tl::unexpected(written.error());
  lock_ = written->lock;
  if (!written->problem.empty()) alarm(written->problem);
  if (auto socket = StopSocket::listen(marker_.socket()))
    socket_ = std::move(*socket);
  else
    alarm(socket.error());
  if (!run_.robots.empty()) {
    memory_ = ::memfd_create("skein-guard", MFD_CLOEXEC);
    void* memory = MAP_FAILED;
    if (memory_ >= 0 && ::ftruncate(memory_, sizeof(comms::HeartbeatPage)) == 0)
      memory = ::mmap(nullptr, sizeof(comms::HeartbeatPage), PROT_READ | PROT_WRITE, MAP_SHARED, memory_, 0);
    if (memory == MAP_FAILED) return tl::unexpected(fmt::format("no guard: {}", std::strerror(errno)));
    page_ = new (memory) comms::HeartbeatPage;
    if (const auto guarded = start_guard(); !guarded) alarm(guarded.error());  // and is tried again
    await_guard();
  }
  if (!run_.robots.empty()) power_down_.emplace(run_.name);
  thread_ = std::jthread([this] { run(); });
  return {};
}

tl::expected<void, std::string> SafetyNet::Keeper::start_guard() {
  const auto failed = [](int error) { return tl::unexpected(fmt::format("no guard: {}", std::strerror(error))); };
  started_at_ = comms::monotonic_ns();
  page_->guard.store(0);
  page_->guard_process.store(0);
  int ends[2];
  if (::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends) != 0) return failed(errno);
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_adddup2(&files, ends[0], STDIN_FILENO);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t nothing, defaults;
  sigemptyset(&nothing);
  sigfillset(&defaults);
  posix_spawnattr_setsigmask(&attributes, &nothing);
  posix_spawnattr_setsigdefault(&attributes, &defaults);
  // A session of its own: Ctrl-C and the end of the terminal are for the run.
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSID | POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
  const std::string executable = run_.program.empty() ? "/proc/self/exe" : run_.program;
  std::string name = guard_name, word = "guard", marker = fmt::format("{}={}", marker_variable, marker_.path);
  char* const arguments[] = {name.data(), word.data(), nullptr};
  std::vector<char*> environment{marker.data()};
  for (char** variable = environ; *variable != nullptr; ++variable) environment.push_back(*variable);
  environment.push_back(nullptr);
  pid_t process = -1;
  const int error = ::posix_spawn(&process, executable.c_str(), &files, &attributes, arguments, environment.data());
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&files);
  ::close(ends[0]);
  if (error != 0) {
    ::close(ends[1]);
    return failed(error);
  }
  starter_ = process;
  guard_socket_ = ends[1];
  GuardMessage page;
  page.kind = GuardMessage::Kind::page;
  comms::send_to_guard(guard_socket_, page, memory_);
  comms::attach_guard(guard_socket_, *page_);
  return {};
}

/// Until then, whatever kills this program's children kills the guard as well. One that takes longer holds up no run.
void SafetyNet::Keeper::await_guard() const {
  while (guard_socket_ >= 0 && process() < 0 && !guard_has_ended() && comms::monotonic_ns() - started_at_ < awaited_for)
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
}

void SafetyNet::Keeper::drop_guard() {
  if (guard_socket_ < 0) return;
  comms::detach_guard(guard_socket_);
  ::close(std::exchange(guard_socket_, -1));
  page_->guard_process.store(0);
}

/// Ends a guard that does nothing. When it woke, it would take this run for ended, and stop the robots.
void SafetyNet::Keeper::dismiss_guard() {
  GuardMessage all_is_well;
  comms::send_to_guard(guard_socket_, all_is_well, -1);
  if (const pid_t guard = process() > 0 ? process() : starter_; guard > 0 && !guard_has_ended()) ::kill(guard, SIGKILL);
  drop_guard();
}

bool SafetyNet::Keeper::guard_has_ended() const {
  char nothing = 0;
  return guard_socket_ >= 0 && ::recv(guard_socket_, &nothing, 1, MSG_DONTWAIT) == 0;
}

void SafetyNet::Keeper::forget_starter() {
  if (starter_ > 0 && ::waitpid(starter_, nullptr, WNOHANG) == starter_) starter_ = -1;
}

SafetyNet::Keeper::~Keeper() {
  end_thread();
  drop_guard();
  // The page stays mapped, 400 bytes a run: another thread's heart may be about to beat in it.
  for (const int descriptor : {lock_, memory_, wake_})
    if (descriptor >= 0) ::close(descriptor);
}

void SafetyNet::Keeper::end_thread() {
  if (!thread_.joinable()) return;
  thread_.request_stop();
  const std::uint64_t one = 1;
  [[maybe_unused]] const auto written = ::write(wake_, &one, sizeof one);
  thread_.join();
}

void SafetyNet::Keeper::run() {
  while (!thread_.get_stop_token().stop_requested()) {
    pollfd polled[] = {
        {guard_socket_, POLLIN, 0}, {socket_ ? socket_->descriptor() : -1, POLLIN, 0}, {wake_, POLLIN, 0}};
    ::poll(polled, std::size(polled), socket_ && socket_->waits() ? poll_often : poll_every);
    try {
      const auto heard = [this](std::string_view word) {
        if (word == "stop") stop("STOP from outside this program (`skein stop`, `skein robots stop`)");
      };
      if (socket_) socket_->turn(heard, [this] { return results(); });
      if (!run_.robots.empty()) look_after_guard();
      if (power_down_) heed_power_down();
    } catch (const std::exception& error) {
      alarm(error.what());
    }
  }
}

void SafetyNet::Keeper::alarm(const std::string& sentence) {
  const std::lock_guard lock(mutex_);
  if (std::exchange(last_alarm_, sentence) != sentence) alarms_.push_back(sentence);
}

void SafetyNet::Keeper::look_after_guard() {
  const std::int64_t now = comms::monotonic_ns();
  const std::int64_t beat = page_->guard.load();
  forget_starter();
  std::string what;
  if (guard_has_ended()) {
    what = "the guard has died";
  } else if (guard_socket_ >= 0 && beat != 0 && now - beat > frozen_after) {
    what = "the guard is frozen";
  } else if (guard_socket_ >= 0 && beat == 0 &&
             1e-9 * static_cast<double>(now - started_at_) > run_.guard_begins_within) {
    what = fmt::format("the guard has not begun within {:.0f} s", run_.guard_begins_within);
  }
  if (!what.empty()) dismiss_guard();
  if (guard_socket_ >= 0 || (what.empty() && now - started_at_ < between_guards)) return;
  const bool too_soon = now - started_at_ < between_guards;
  const auto started = too_soon ? tl::expected<void, std::string>{} : start_guard();
  if (!what.empty() || !started)
    alarm(fmt::format("{}{}", what.empty() ? "the guard is gone" : what,
                      too_soon  ? ", as soon as it was started: the robots have no guard now"
                      : started ? ": a new guard has been started"
                                : ": " + started.error()));
}

void SafetyNet::Keeper::heed_power_down() {
  using Announced = comms::PowerDownDelay::Announced;
  switch (power_down_->turn()) {
    case Announced::nothing:
      break;
    case Announced::suspend:
      powers_down_ = true;
      stop("STOP: this machine is about to be suspended");
      break;
    case Announced::shutdown:
      powers_down_ = true;
      stop("STOP: this machine is about to be shut down");
      break;
  }
  if (powers_down_ && all_stand(results())) power_down_.reset();
}

void SafetyNet::Keeper::on_stop(Stop stop, std::function<std::vector<StopResult>()> results) {
  const std::lock_guard lock(calls_);
  stop_ = std::move(stop);
  results_ = std::move(results);
  if (!why_.empty() && stop_) stop_(why_);
}

void SafetyNet::Keeper::stop(const std::string& why) {
  const std::lock_guard lock(calls_);
  why_ = why;
  if (stop_) stop_(why);
}

std::vector<StopResult> SafetyNet::Keeper::results() {
  const std::lock_guard lock(calls_);
  if (results_) return results_();
  std::vector<StopResult> all;
  all.reserve(run_.robots.size());
  for (const comms::LinkAddress& robot : run_.robots)
    all.push_back({comms::to_text(robot), false, "the run has not begun"});
  return all;
}

void SafetyNet::Keeper::done(const std::vector<StopResult>& robots) {
  on_stop({}, {});
  end_thread();
  const bool well = all_stand(robots);
  if (well) {
    GuardMessage all_is_well;
    if (guard_socket_ >= 0) comms::send_to_guard(guard_socket_, all_is_well, -1);
    marker_.forget();
  } else if (lock_ >= 0) {
    RunMarker rest = marker_;
    for (std::size_t i = robots.size(); i-- > 0;)
      if (robots[i].stopped && robots.size() == rest.robots.size()) rest.robots[i].device.clear();
    std::erase_if(rest.robots, [](const comms::LinkAddress& robot) { return robot.device.empty(); });
    rewrite_marker(lock_, rest);
  }
  if (socket_) socket_->turn([](std::string_view) {}, [&] { return robots; }, /*last=*/true);
  socket_.reset();
  ::close(std::exchange(lock_, -1));
  // It ends at once, unless it is frozen; this is not waited for.
  for (int look = 0; well && guard_socket_ >= 0 && look < 500 && !guard_has_ended(); ++look)
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  drop_guard();
  forget_starter();
}

SafetyNet::SafetyNet() = default;
SafetyNet::SafetyNet(SafetyNet&& other) noexcept = default;
SafetyNet& SafetyNet::operator=(SafetyNet&& other) noexcept = default;
SafetyNet::~SafetyNet() = default;

tl::expected<SafetyNet, std::string> SafetyNet::spread(const Run& run) {
  SafetyNet net;
  net.keeper_ = std::make_unique<Keeper>(run);
  if (auto begun = net.keeper_->begin(); !begun) return tl::unexpected(begun.error());
  return net;
}

void SafetyNet::on_stop(Stop stop, std::function<std::vector<StopResult>()> results) {
  if (keeper_) keeper_->on_stop(std::move(stop), std::move(results));
}
std::vector<std::string> SafetyNet::alarms() {
  return keeper_ ? keeper_->alarms() : std::vector<std::string>{};
}
pid_t SafetyNet::guard_process() const {
  return keeper_ ? keeper_->process() : -1;
}
void SafetyNet::done(const std::vector<StopResult>& robots) {
  if (keeper_) keeper_->done(robots);
  keeper_.reset();
}

std::string unguarded_sentence(const std::string& why) {
  return fmt::format("{}: if this program is killed, nothing stops the robots", why);
}

tl::expected<comms::LinkAddress, std::string> link_of(const Experiment& experiment, std::size_t robot) {
  const RobotSpec& spec = experiment.robots[robot];
  auto address = comms::parse_link_address(spec.address);
  if (!address) return tl::unexpected(fmt::format("{}: {}", robot_name(experiment, robot), address.error()));
  address->adapter = spec.adapter;
  address->name = robot_name(experiment, robot);
  return comms::spoken_by(std::move(*address), spec.type->protocol);
}

tl::expected<std::vector<comms::LinkAddress>, std::string> real_robots(const Experiment& experiment) {
  std::vector<comms::LinkAddress> addresses;
  std::map<std::string, std::string> robots;  // where a link leads -> whose it is
  for (std::size_t i = 0; i < experiment.robots.size(); ++i) {
    if (experiment.robots[i].simulated()) continue;
    auto address = link_of(experiment, i);
    if (!address) return tl::unexpected(address.error());
    // Two names of one host are known to be that only now; a name that nobody knows is the link's to report.
    const std::string place = comms::canonical_text(comms::resolve(*address).value_or(*address));
    if (const auto [other, unique] = robots.emplace(place, address->name); !unique)
      return tl::unexpected(
          fmt::format("{}: link \"{}\" leads to {}, as that of {} does; allowed: a different robot for "
                      "each link",
                      address->name, experiment.robots[i].address, place, other->second));
    addresses.push_back(std::move(*address));
  }
  return addresses;
}

std::vector<StopResult> stop_results(const Experiment& experiment, const std::vector<RobotStatus>& robots) {
  std::vector<StopResult> results;
  for (std::size_t i = 0; i < experiment.robots.size(); ++i) {
    if (experiment.robots[i].simulated()) continue;
    const bool known = i < robots.size();
    results.push_back({experiment.robots[i].address, known && robots[i].stop_acknowledged,
                       known && !robots[i].reason.empty() ? robots[i].reason : "it has not acknowledged its stop"});
  }
  return results;
}

std::string stop_one(const std::vector<comms::LinkAddress>& robots, std::size_t robot,
                     const std::function<void(const std::string& reason)>& still_tries) {
  comms::LinkOptions options;
  options.close_timeout = stop_timeout;
  options.connect_timeout = comms::connect_patience(robots, robot, options.connect_timeout);
  comms::LinkSupervisor link({robots[robot]}, options);  // one each: none waits for another
  const auto tell_at = std::chrono::steady_clock::now() + silent_for;
  bool told = !still_tries;
  const auto started = link.start(comms::reach_patience(robots), [&] {
    if (!told && std::chrono::steady_clock::now() >= tell_at) {
      told = true;
      const comms::LinkStatus status = link.status().at(0);
      still_tries(status.reason.empty() ? fmt::format("its link is {}", word(status.state)) : status.reason);
    }
    return !interrupted();
  });
  const comms::LinkStatus status = link.close(stop_timeout).at(0);
  if (status.stop_acknowledged) return {};
  if (!status.reason.empty()) return status.reason;
  return started ? "it has not acknowledged its stop" : started.error();
}

void complain_of_waiting(const std::string& address, const std::string& reason) {
  complain(fmt::format("{}: not stopped yet: {}; still trying", address, reason));
}

bool stop_all(const std::vector<comms::LinkAddress>& robots) {
  const auto stop = [&robots](std::size_t i) {
    const std::string name = comms::to_text(robots[i]);
    const std::string failure =
        stop_one(robots, i, [&name](const std::string& reason) { complain_of_waiting(name, reason); });
    if (failure.empty())
      print_out(fmt::format("{}: stopped\n", name));
    else
      complain(fmt::format("{}: NOT known to be stopped: {}", name, failure));
    return failure.empty();
  };
  std::vector<std::future<bool>> stops;
  for (std::size_t i = 0; i < robots.size(); ++i) stops.push_back(std::async(std::launch::async, stop, i));
  bool all = true;
  for (std::future<bool>& stopped : stops) all = stopped.get() && all;
  return all;
}

}  // namespace skein::app

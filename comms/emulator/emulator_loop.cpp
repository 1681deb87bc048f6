#include "comms/emulator/emulator_loop.h"

#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <condition_variable>
#include <cstdint>
#include <exception>
#include <limits>
#include <mutex>
#include <optional>
#include <span>
#include <system_error>
#include <thread>
#include <utility>

#include "comms/emulator/emulated_epuck.h"

namespace skein::comms {
namespace {

constexpr double listen_again = 0.5;  // [s]

}  // namespace

class EmulatorLoop::Loop {
 public:
  Loop(std::vector<EmulatorLoop::Robot> robots, WheelsTold on_wheels, std::function<double()> clock,
       const std::vector<Fault>& faults, std::uint64_t seed)
      : on_wheels_(std::move(on_wheels)), clock_(std::move(clock)) {
    const double now = clock_();
    for (std::size_t i = 0; i < robots.size(); ++i) {
      addresses_.push_back(robots[i].endpoint->address());
      EmulatorLoop::Robot& robot = robots[i];
      if (robot.firmware)
        robots_.emplace_back(EmulatedEpuck(std::move(robot.firmware), now, faults_of(faults, i), seed + i),
                             std::move(robot.endpoint));
      else
        robots_.emplace_back(EmulatedEpuck(robot.model, now, faults_of(faults, i), seed + i, robot.protocol),
                             std::move(robot.endpoint));
    }
    wake_ = ::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC);
    if (wake_ < 0) throw std::system_error(errno, std::generic_category(), "eventfd");
    thread_ = std::thread([this] { run(); });
  }
  ~Loop() {
    ask([this] { ending_ = true; });
    thread_.join();
    ::close(wake_);
  }
  Loop(const Loop&) = delete;
  Loop& operator=(const Loop&) = delete;

  std::size_t size() const noexcept { return robots_.size(); }
  std::string address(std::size_t robot) const { return addresses_.at(robot); }

  core::WheelSpeeds wheels(std::size_t robot) const {
    const std::lock_guard lock(mutex_);
    return robots_.at(robot).wheels;
  }

  void hang_up(std::size_t robot) {
    ask([this, robot] { robots_.at(robot).endpoint->hang_up(); });
  }
  void reboot(std::size_t robot) {
    ask([this, robot] {
      robots_.at(robot).epuck.reboot();
      let_time_pass(robot);
    });
  }
  void silence(std::size_t robot, bool silent) {
    ask([this, robot, silent] { robots_.at(robot).silent = silent; });
  }
  void say(std::size_t robot, const std::string& bytes) {
    ask([this, robot, &bytes] {
      robots_.at(robot).endpoint->write({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
    });
  }

 private:
  struct Robot {
    Robot(EmulatedEpuck robot, std::unique_ptr<Endpoint> where) : epuck(std::move(robot)), endpoint(std::move(where)) {}
    EmulatedEpuck epuck;                 // the thread's own
    std::uint64_t breaks = 0;            // the thread's own: how many of its connection's breaks the endpoint has seen
    std::unique_ptr<Endpoint> endpoint;  // the thread's own
    bool silent = false;                 // the thread's own
    std::uint64_t times_told = 0;        // the thread's own
    core::WheelSpeeds wheels;            // guarded by mutex_
  };

  // Has the thread do something between two turns, and waits until it is done.
  void ask(std::function<void()> what) {
    const std::lock_guard one_at_a_time(asking_);
    std::unique_lock lock(mutex_);
    request_ = std::move(what);
    ring();
    answered_.wait(lock, [this] { return !request_; });
    if (failure_) std::rethrow_exception(std::exchange(failure_, nullptr));
  }

  void run() {
    std::vector<pollfd> polled;
    while (!ending_) {
      polled.assign(1, {.fd = wake_, .events = POLLIN, .revents = 0});
      for (const Robot& robot : robots_) {
        robot.endpoint->admit(robot.epuck.admits());
        polled.push_back({.fd = robot.endpoint->descriptor(), .events = POLLIN, .revents = 0});
      }
      const std::optional<timespec> wait = until_next_event();
      if (::ppoll(polled.data(), polled.size(), wait ? &*wait : nullptr, nullptr) < 0) continue;
      for (std::size_t i = 0; i < robots_.size(); ++i) {
        if (polled[i + 1].revents != 0) serve(i);
        if (wait) let_time_pass(i);
      }
      if (polled[0].revents != 0) answer_request();
    }
  }

  void answer_request() {
    std::uint64_t rings = 0;
    [[maybe_unused]] const auto read = ::read(wake_, &rings, sizeof rings);
    std::function<void()> request;
    {
      const std::lock_guard lock(mutex_);
      request = request_;
    }
    std::exception_ptr failure;
    try {
      if (request) request();
    } catch (...) {
      failure = std::current_exception();
    }
    {
      const std::lock_guard lock(mutex_);
      request_ = nullptr;
      failure_ = failure;
    }
    answered_.notify_all();
  }

  // How long nothing happens by itself; nothing: for ever, as without faults.
  std::optional<timespec> until_next_event() const {
    double next = std::numeric_limits<double>::infinity();
    for (const Robot& robot : robots_) {
      next = std::min(next, robot.epuck.deadline());
      // It should be listening, and the system would not have it: an adapter is gone, say.
      if (robot.epuck.admits() && robot.endpoint->descriptor() < 0) next = std::min(next, clock_() + listen_again);
    }
    if (std::isinf(next)) return {};
    const double seconds = std::clamp(next - clock_(), 0.0, 3600.0);
    return timespec{static_cast<time_t>(seconds), static_cast<long>((seconds - std::floor(seconds)) * 1e9)};
  }

  void serve(std::size_t i) {
    Robot& robot = robots_[i];
    std::array<std::uint8_t, 512> bytes;
    const Endpoint::Arrival arrival = robot.endpoint->read(bytes);
    if (arrival.host) robot.epuck.accept();
    if (arrival.bytes == 0 || robot.silent) return;
    robot.epuck.receive(std::span(bytes).first(arrival.bytes), clock_());
    let_time_pass(i);
  }

  void let_time_pass(std::size_t i) {
    Robot& robot = robots_[i];
    robot.epuck.advance(clock_());
    publish(i);
    if (std::exchange(robot.breaks, robot.epuck.breaks()) != robot.epuck.breaks()) robot.endpoint->hang_up();
    const std::vector<std::uint8_t> reply = robot.epuck.take();
    if (!robot.silent && !reply.empty()) robot.endpoint->write(reply);
  }

  void publish(std::size_t i) {
    Robot& robot = robots_[i];
    const std::uint64_t told = robot.epuck.times_told();
    if (std::exchange(robot.times_told, told) == told) return;
    {
      const std::lock_guard lock(mutex_);
      robot.wheels = robot.epuck.wheels();
    }
    if (on_wheels_) on_wheels_(i, robot.epuck.told());
  }

  void ring() noexcept {
    const std::uint64_t one = 1;
    [[maybe_unused]] const auto written = ::write(wake_, &one, sizeof one);
  }

  WheelsTold on_wheels_;
  std::function<double()> clock_;
  std::vector<std::string> addresses_;
  std::vector<Robot> robots_;
  int wake_ = -1;  // eventfd
  bool ending_ = false;

  mutable std::mutex mutex_;
  std::condition_variable answered_;
  std::function<void()> request_;  // guarded by mutex_; empty: none
  std::exception_ptr failure_;     // guarded by mutex_; of the last request
  std::mutex asking_;
  std::thread thread_;
};

EmulatorLoop::EmulatorLoop(std::vector<Robot> robots, WheelsTold on_wheels, std::function<double()> clock,
                           const std::vector<Fault>& faults, std::uint64_t seed)
    : loop_(std::make_unique<Loop>(std::move(robots), std::move(on_wheels), std::move(clock), faults, seed)) {}
EmulatorLoop::~EmulatorLoop() = default;

std::size_t EmulatorLoop::size() const noexcept {
  return loop_->size();
}
std::string EmulatorLoop::address(std::size_t robot) const {
  return loop_->address(robot);
}
core::WheelSpeeds EmulatorLoop::wheels(std::size_t robot) const {
  return loop_->wheels(robot);
}
void EmulatorLoop::hang_up(std::size_t robot) {
  loop_->hang_up(robot);
}
void EmulatorLoop::reboot(std::size_t robot) {
  loop_->reboot(robot);
}
void EmulatorLoop::silence(std::size_t robot, bool silent) {
  loop_->silence(robot, silent);
}
void EmulatorLoop::say(std::size_t robot, const std::string& bytes) {
  loop_->say(robot, bytes);
}

}  // namespace skein::comms

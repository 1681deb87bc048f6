#include "comms/emulator/emulate.h"

#include <fmt/format.h>
#include <pthread.h>

#include <chrono>
#include <csignal>
#include <cstdio>
#include <map>
#include <optional>
#include <system_error>
#include <utility>
#include <vector>

#include "comms/emulator/emulator_loop.h"
#include "comms/emulator/make_firmware.h"

namespace skein::comms {
namespace {

/// SIGINT, SIGTERM and, except under nohup, SIGHUP held back from this thread and those that it starts, to be waited
/// for.
class HeldSignals {
 public:
  HeldSignals() {
    sigemptyset(&signals_);
    sigaddset(&signals_, SIGINT);
    sigaddset(&signals_, SIGTERM);
    struct sigaction hangup {};
    if (::sigaction(SIGHUP, nullptr, &hangup) == 0 && hangup.sa_handler != SIG_IGN) sigaddset(&signals_, SIGHUP);
    pthread_sigmask(SIG_BLOCK, &signals_, &before_);
  }
  ~HeldSignals() { pthread_sigmask(SIG_SETMASK, &before_, nullptr); }
  HeldSignals(const HeldSignals&) = delete;
  HeldSignals& operator=(const HeldSignals&) = delete;

  void wait() const {
    int which = 0;
    while (sigwait(&signals_, &which) != 0) {
    }
  }

 private:
  sigset_t signals_{};
  sigset_t before_{};
};

void print_line(const std::string& line) {
  fmt::print("{}\n", line);
  std::fflush(stdout);  // for a script that waits for the line at the other end of a pipe
}

void print_mistake(const std::string& line) {
  fmt::print(stderr, "{}\n", line);
}

}  // namespace

int emulate(const EmulateOptions& options) {
  const auto say = options.say ? options.say : print_line;
  const auto complain = options.complain ? options.complain : print_mistake;
  if (options.robots < 1) {
    complain(fmt::format("{} robots; allowed: 1 or more", options.robots));
    return 2;
  }
  std::vector<ListenAddress> listen;
  for (const std::string& text : options.listen) {
    const auto address = parse_listen_address(text);
    if (!address) {
      complain(address.error());
      return 2;
    }
    listen.push_back(*address);
  }
  const HeldSignals signals;
  const auto start = std::chrono::steady_clock::now();
  const auto clock = [start] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  };
  WheelsTold on_wheels;
  if (options.verbose) {
    // Only what is new: a host may tell the same speed 25 times a second.
    on_wheels = [&clock, &say, last = std::map<std::size_t, core::WheelSpeeds>()](
                    std::size_t robot, const core::WheelSpeeds& told) mutable {
      if (std::exchange(last[robot], told) == told) return;
      say(fmt::format("{:.3f} robot {}: wheels {:.1f} {:.1f} steps/s", clock(), robot + 1, told.left, told.right));
    };
  }
  try {
    std::optional<DeviceNames> names;
    std::vector<EmulatorLoop::Robot> robots;
    for (const ListenAddress& address : listen) {
      constexpr const core::RobotType& epuck2 = *core::find_robot_type("epuck2");
      constexpr const core::RobotType& open = *core::find_robot_type("open");
      const core::RobotType* type = options.model;
      EpuckProgram program = EpuckProgram::asercom;
      switch (address.kind) {
        case LinkKind::serial:
        case LinkKind::rfcomm:
          break;
        case LinkKind::tcp:
          type = &epuck2;
          program = EpuckProgram::wifi;
          break;
        case LinkKind::udp:
          type = &open;
          break;
      }
      robots.push_back({type->motor, program, make_socket_endpoint(address), make_firmware(*type)});
    }
    if (listen.empty()) {
      names.emplace(options.directory);
      for (std::size_t i = 0; i < options.robots; ++i)
        robots.push_back(
            {options.model->motor, EpuckProgram::asercom, make_pty_endpoint(*names, i), make_firmware(*options.model)});
    }
    const EmulatorLoop emulator(std::move(robots), on_wheels, clock, options.faults, options.seed);
    for (std::size_t i = 0; i < emulator.size(); ++i) {
      const auto plain = parse_link_address(emulator.address(i));
      const bool stream = plain && (plain->kind == LinkKind::serial || plain->kind == LinkKind::rfcomm);
      const auto spoken = stream ? spoken_by(*plain, options.model->protocol) : plain;
      say(fmt::format("robot {}: {}", i + 1, spoken ? to_text(*spoken) : emulator.address(i)));
    }
    signals.wait();
  } catch (const std::system_error& error) {
    complain(error.what());
    return 3;
  }
  return 0;
}

}  // namespace skein::comms

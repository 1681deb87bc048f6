#include "comms/robot_check.h"

#include <fmt/format.h>
#include <poll.h>

#include <array>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <thread>

#include "comms/asercom.h"
#include "comms/link_supervisor.h"
#include "comms/transport.h"

namespace skein::comms {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int speed = 200;                   // [steps/s]
constexpr double turning_time = 0.4;         // 80 steps, 10 mm [s]
constexpr double command_period = 0.04;      // below the silence that stops the robot [s]
constexpr int quiet_ms = 300;                // a robot that says nothing for this long has finished its answer
constexpr double acknowledge_timeout = 2.0;  // [s]

bool wait_for(const Transport& line, short events, int milliseconds) {
  pollfd waiting{.fd = line.descriptor(), .events = events, .revents = 0};
  return ::poll(&waiting, 1, milliseconds) > 0;
}

/// Sends and collects what comes back until the robot is quiet.
tl::expected<std::string, TransportError> ask(Transport& line, std::span<const std::uint8_t> request) {
  while (!request.empty()) {
    const auto written = line.write(request);
    if (!written) return tl::unexpected(written.error());
    request = request.subspan(*written);
    if (!request.empty() && !wait_for(line, POLLOUT, 1000)) break;
  }
  std::string answer;
  const auto end = Clock::now() + std::chrono::seconds(3);  // for one that talks without end
  while (Clock::now() < end && wait_for(line, POLLIN, quiet_ms)) {
    std::array<std::uint8_t, 256> bytes;
    const auto count = line.read(bytes);
    if (!count) return tl::unexpected(count.error());
    answer.append(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(*count));
  }
  return answer;
}

tl::expected<std::string, TransportError> ask(Transport& line, char letter) {
  const std::string request = ascii_request(letter);
  return ask(line, {reinterpret_cast<const std::uint8_t*>(request.data()), request.size()});
}

/// The rest of the line that begins with "x,", or nothing.
std::string line_of(const std::string& answer, char letter) {
  const std::size_t begin = answer.find(std::string(1, letter) + ',');
  if (begin == std::string::npos || (begin > 0 && answer[begin - 1] != '\n')) return {};
  return answer.substr(begin + 2, answer.find_first_of("\r\n", begin) - begin - 2);
}

/// Version and battery, over a connection of its own: text and binary requests on one would get into each other's way.
tl::expected<void, TransportError> introduce(const LinkAddress& address, double timeout_s, RobotCheck& check) {
  auto line = Transport::open(address);
  if (!line) return tl::unexpected(line.error());
  if (line->connecting()) {
    if (!wait_for(*line, POLLOUT, static_cast<int>(1e3 * timeout_s)))
      return tl::unexpected(TransportError{fmt::format("no connection within {:g} s", timeout_s)});
    if (const auto connected = line->finish_connecting(); !connected) return tl::unexpected(connected.error());
  }
  if (const auto stopped = ask(*line, stop_sequence()); !stopped) return tl::unexpected(stopped.error());
  const auto version = ask(*line, 'V');
  if (!version) return tl::unexpected(version.error());
  const auto battery = ask(*line, 'b');
  if (!battery) return tl::unexpected(battery.error());
  check.version = line_of(*version, 'v');
  check.battery = line_of(*battery, 'b');
  return {};
}

struct Steps {
  int left = 0, right = 0;
};

/// What both counters do while the wheels are told these speeds.
tl::expected<Steps, std::string> turn(LinkSupervisor& link, int left, int right) {
  const auto counters = [&link]() -> tl::expected<Steps, std::string> {
    link.command(0, 0, 0);
    if (!link.wait_acknowledged(acknowledge_timeout))
      return tl::unexpected(fmt::format("no answer within {:g} s", acknowledge_timeout));
    const LinkStatus status = link.status().at(0);
    return Steps{static_cast<int>(status.left_steps), static_cast<int>(status.right_steps)};
  };
  const auto before = counters();
  if (!before) return before;
  const int ticks = static_cast<int>(std::lround(turning_time / command_period));
  for (int i = 0; i < ticks; ++i) {
    link.command(0, left, right);
    std::this_thread::sleep_for(std::chrono::duration<double>(command_period));
  }
  const auto after = counters();
  if (!after) return after;
  return Steps{after->left - before->left, after->right - before->right};
}

/// What is wrong with a wheel that was told to turn alone.
void judge(const char* wheel, int its_own, int other, std::vector<std::string>& faults) {
  constexpr int few = static_cast<int>(speed * turning_time / 4);  // a loaded machine does not turn for long
  if (std::abs(its_own) < few && std::abs(other) < few)
    faults.push_back(fmt::format("the {} wheel's encoder is silent: {} steps", wheel, its_own));
  else if (std::abs(other) >= few && std::abs(its_own) < few)
    faults.push_back(fmt::format("the wheels are swapped: the {} wheel's command turns the other", wheel));
  else if (std::abs(other) >= few)
    faults.push_back(fmt::format("the {} wheel's command turns both wheels", wheel));
  else if (its_own < 0)
    faults.push_back(fmt::format("the {} wheel turns backwards: {} steps", wheel, its_own));
}

}  // namespace

tl::expected<RobotCheck, std::string> check_robot(const LinkAddress& address, double timeout_s) {
  RobotCheck check;
  if (const auto introduced = introduce(address, timeout_s, check); !introduced)
    return tl::unexpected(introduced.error().reason);
  LinkSupervisor link({address});
  if (auto started = link.start(timeout_s); !started) return tl::unexpected(started.error());
  const auto left = turn(link, speed, 0);
  if (!left) return tl::unexpected(left.error());
  const auto right = turn(link, 0, speed);
  if (!right) return tl::unexpected(right.error());
  check.left_steps = left->left;
  check.right_steps = right->right;
  judge("left", left->left, left->right, check.faults);
  judge("right", right->right, right->left, check.faults);
  if (!link.close(acknowledge_timeout).at(0).stop_acknowledged)
    check.faults.push_back("it has not acknowledged the stop afterwards");
  return check;
}

}  // namespace skein::comms

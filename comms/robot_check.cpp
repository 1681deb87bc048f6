#include "comms/robot_check.h"

#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <cstdlib>
#include <thread>

#include "comms/link_supervisor.h"

namespace skein::comms {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int speed = 200;                   // [steps/s]
constexpr double turning_time = 0.4;         // 80 steps, 10 mm [s]
constexpr double command_period = 0.04;      // below the silence that stops the robot [s]
constexpr double acknowledge_timeout = 2.0;  // [s]

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
  LinkSupervisor link({address}, {.battery_period = 1.0, .ask_version = true});
  if (const auto started = link.start(timeout_s); !started) {
    const std::string reason = link.status().at(0).reason;
    return tl::unexpected(reason.empty() ? started.error() : reason);
  }
  const auto left = turn(link, speed, 0);
  if (!left) return tl::unexpected(left.error());
  const auto right = turn(link, 0, speed);
  if (!right) return tl::unexpected(right.error());
  check.left_steps = left->left;
  check.right_steps = right->right;
  judge("left", left->left, left->right, check.faults);
  judge("right", right->right, right->left, check.faults);
  const LinkStatus end = link.close(acknowledge_timeout).at(0);
  check.version = end.version;
  check.battery = end.battery;
  if (!end.stop_acknowledged) check.faults.push_back("it has not acknowledged the stop afterwards");
  return check;
}

}  // namespace skein::comms

#include "app/session/wheel_check.h"

#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <thread>
#include <tuple>
#include <utility>

namespace skein::app {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double command_period = 0.04;      // below the silence that stops the robot [s]
constexpr double acknowledge_timeout = 2.0;  // [s]

struct Steps {
  int left = 0, right = 0;
};

/// One robot and the only one who tells it anything.
struct Examined {
  comms::LinkSupervisor& links;
  std::size_t robot;
  const std::function<std::string()>& keep_on;

  /// Tells the wheels these speeds again and again until `over` says so.
  template <typename Over>
  tl::expected<void, std::string> tell(int left, int right, Over&& over) const {
    do {
      if (std::string reason = keep_on(); !reason.empty()) return tl::unexpected(std::move(reason));
      links.command(robot, left, right);
      std::this_thread::sleep_for(std::chrono::duration<double>(command_period));
    } while (!over());
    return {};
  }

  /// The counters, read while the robot stands.
  tl::expected<Steps, std::string> counters() const {
    constexpr std::uint64_t fresh = 3;  // exchanges: one may have been under way, one tells it to stand, one reads
    const std::uint64_t before = links.status().at(robot).exchanges;
    const auto give_up = Clock::now() + std::chrono::duration<double>(acknowledge_timeout);
    const auto read = [&] { return links.status().at(robot).exchanges >= before + fresh; };
    if (const auto told = tell(0, 0, [&] { return read() || Clock::now() > give_up; }); !told)
      return tl::unexpected(told.error());
    if (!read()) return tl::unexpected(fmt::format("no answer within {:g} s", acknowledge_timeout));
    const comms::LinkStatus status = links.status().at(robot);
    return Steps{static_cast<int>(status.left_steps), static_cast<int>(status.right_steps)};
  }

  /// What both counters do while the wheels are told these speeds.
  tl::expected<Steps, std::string> turn(int left, int right) const {
    const auto before = counters();
    if (!before) return before;
    int ticks = static_cast<int>(std::lround(one_wheel_time / command_period));
    if (const auto told = tell(left, right, [&] { return --ticks <= 0; }); !told) {
      links.command(robot, 0, 0);
      return tl::unexpected(told.error());
    }
    const auto after = counters();
    if (!after) return after;
    return Steps{after->left - before->left, after->right - before->right};
  }
};

}  // namespace

double steps_of(const core::RobotType& type, double epuck_steps) noexcept {
  return std::round(epuck_steps * core::DifferentialDrive{}.metres_per_step() / type.wheels.metres_per_step());
}

std::string wheel_fault(const char* wheel, double its_own, double other, double expected, const char* still,
                        const char* unit) {
  const double few = expected / 4;  // a loaded machine does not turn for long
  if (std::abs(its_own) < few && std::abs(other) < few)
    return fmt::format("the {} wheel{}: {:.3g} {}", wheel, still, its_own, unit);
  if (std::abs(its_own) < few)
    return fmt::format("the wheels are swapped: the {} wheel's command turns the other wheel", wheel);
  if (std::abs(other) >= few) return fmt::format("the {} wheel's command turns both wheels", wheel);
  if (its_own < 0) return fmt::format("the {} wheel turns backwards: {:.3g} {}", wheel, its_own, unit);
  return {};
}

std::vector<std::string> encoder_faults(double left, double right_with_left, double right, double left_with_right,
                                        double expected) {
  std::vector<std::string> faults;
  for (const auto& [wheel, its_own, other] :
       {std::tuple("left", left, right_with_left), std::tuple("right", right, left_with_right)})
    if (std::string fault = wheel_fault(wheel, its_own, other, expected, "'s encoder is silent", "steps");
        !fault.empty())
      faults.push_back(std::move(fault));
  return faults;
}

tl::expected<WheelCheck, std::string> check_wheels(comms::LinkSupervisor& links, std::size_t link,
                                                   const core::RobotType& type,
                                                   const std::function<std::string()>& keep_on) {
  const Examined examined{links, link, keep_on};
  const int speed = static_cast<int>(steps_of(type, one_wheel_speed));
  const auto left = examined.turn(speed, 0);
  if (!left) return tl::unexpected(left.error());
  const auto right = examined.turn(0, speed);
  if (!right) return tl::unexpected(right.error());
  WheelCheck check;
  check.left_steps = left->left;
  check.right_steps = right->right;
  check.faults = encoder_faults(left->left, left->right, right->right, right->left, speed * one_wheel_time);
  const comms::LinkStatus status = links.status().at(link);
  check.version = status.version;
  check.battery = status.battery.volts;
  check.battery_low = status.battery.low;
  return check;
}

}  // namespace skein::app

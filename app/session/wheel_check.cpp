#include "app/session/wheel_check.h"

#include <fmt/format.h>

#include <algorithm>
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
constexpr double far = 2.0;                  // times the steps expected

struct Steps {
  int left = 0, right = 0;
};

double most_steps(const OneWheelTurn& turn, double speed) {
  return speed * std::max(turn.seconds, one_wheel_time);
}

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

  OneWheelTurn since(const Steps& before, Clock::time_point begun) const {
    const comms::LinkStatus status = links.status().at(robot);
    return {static_cast<double>(status.left_steps - before.left),
            static_cast<double>(status.right_steps - before.right),
            std::chrono::duration<double>(Clock::now() - begun).count()};
  }

  /// What both counters do while the wheels are commanded these speeds.
  tl::expected<OneWheelTurn, std::string> turn(int left, int right) const {
    const auto before = counters();
    if (!before) return tl::unexpected(before.error());
    const auto begun = Clock::now();
    int ticks = static_cast<int>(std::lround(one_wheel_time / command_period));
    const auto over = [&] { return --ticks <= 0 || since(*before, begun).too_far(std::max(left, right)); };
    if (const auto told = tell(left, right, over); !told) {
      links.command(robot, 0, 0);
      return tl::unexpected(told.error());
    }
    const double seconds = std::chrono::duration<double>(Clock::now() - begun).count();
    const auto after = counters();
    if (!after) return tl::unexpected(after.error());
    return OneWheelTurn{static_cast<double>(after->left - before->left),
                        static_cast<double>(after->right - before->right), seconds};
  }
};

}  // namespace

double steps_of(const core::RobotType& type, double epuck_steps) noexcept {
  return std::round(epuck_steps * core::DifferentialDrive{}.metres_per_step() / type.wheels.metres_per_step());
}

bool OneWheelTurn::too_far(double speed) const noexcept {
  return std::max(std::abs(left), std::abs(right)) > far * most_steps(*this, speed);
}

std::string wheel_fault(const char* wheel, const WheelMotion& motion, const char* still) {
  const auto& [its_own, other, expected, most, unit] = motion;
  const double few = expected / 4;  // a loaded machine does not turn for long
  if (std::abs(its_own) < few && std::abs(other) < few)
    return fmt::format("the {} wheel{}: {:.3g} {}", wheel, still, its_own, unit);
  if (std::abs(its_own) < few)
    return fmt::format("the wheels are swapped: the {} wheel's command turns the other wheel", wheel);
  if (std::abs(other) >= few) return fmt::format("the {} wheel's command turns both wheels", wheel);
  if (its_own < 0) return fmt::format("the {} wheel turns backwards: {:.3g} {}", wheel, its_own, unit);
  if (its_own > far * most)
    return fmt::format("the {} wheel turned at least {:.1f} times too far: {:.3g} {} instead of {:.3g}", wheel,
                       its_own / most, its_own, unit, most);
  return {};
}

std::vector<std::string> encoder_faults(const OneWheelTurn& left, const OneWheelTurn& right, double speed) {
  std::vector<std::string> faults;
  const double expected = speed * one_wheel_time;
  for (const auto& [wheel, its_own, other, most] :
       {std::tuple("left", left.left, left.right, most_steps(left, speed)),
        std::tuple("right", right.right, right.left, most_steps(right, speed))})
    if (std::string fault = wheel_fault(wheel, {its_own, other, expected, most, "steps"}, "'s encoder is silent");
        !fault.empty())
      faults.push_back(std::move(fault));
  return faults;
}

std::string speed_fault(std::uint64_t times) {
  if (times == 0) return {};
  return fmt::format("{} times it took speeds other than those sent, and was stopped", times);
}

tl::expected<WheelCheck, std::string> check_wheels(comms::LinkSupervisor& links, std::size_t link,
                                                   const core::RobotType& type,
                                                   const std::function<std::string()>& keep_on) {
  const Examined examined{links, link, keep_on};
  const int speed = static_cast<int>(steps_of(type, one_wheel_speed));
  const std::uint64_t wrong_before = links.status().at(link).wrong_speeds;
  const auto left = examined.turn(speed, 0);
  if (!left) return tl::unexpected(left.error());
  const auto right = examined.turn(0, speed);
  if (!right) return tl::unexpected(right.error());
  WheelCheck check;
  check.left_steps = static_cast<int>(left->left);
  check.right_steps = static_cast<int>(right->right);
  check.faults = encoder_faults(*left, *right, speed);
  const comms::LinkStatus status = links.status().at(link);
  if (std::string fault = speed_fault(status.wrong_speeds - wrong_before); !fault.empty())
    check.faults.push_back(std::move(fault));
  check.version = status.version;
  check.battery = status.battery.volts;
  check.battery_low = status.battery.low;
  return check;
}

}  // namespace skein::app

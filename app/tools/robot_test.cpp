#include "app/tools/robot_test.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "app/experiment/toml_places.h"
#include "app/session/wheel_check.h"
#include "core/math/elementary.h"

namespace skein::app {
namespace {

// Speeds in an e-puck's steps (steps_of).
constexpr double epuck_way_speed = 300, way_time = 1.6;    // 62 mm
constexpr double epuck_turn_speed = 250, turn_time = 1.6;  // 52 mm of each wheel: 110 degrees of an e-puck
constexpr double standing = 0.6, settled = 0.2;            // how long it stands; from when on its poses count [s]
constexpr double first_sight = 10.0, all_parts = 1.6;      // a camera opens; the tracker looks everywhere once [s]
constexpr double turned_at_least = 0.05;                   // a tag on a robot that turns 0.19 rad; noise is 0.001 [rad]
constexpr double elbow_room = 0.09;                        // between two robots' midpoints [m]
constexpr double diameter_tolerance = 0.02, track_tolerance = 0.03;

bool known(const core::Pose& pose) {
  return !std::isnan(pose.x);
}

std::string in_mm(double metres) {
  return fmt::format("{:.2f} mm", 1e3 * metres);
}

}  // namespace

double RobotTest::Moved::forward() const {
  const double dx = after.x - before.x, dy = after.y - before.y, half = 0.5 * turned();
  const double heading = before.theta + half;
  const double chord = dx * core::math::cos(heading) + dy * core::math::sin(heading);
  return std::abs(half) < 1e-6 ? chord : chord * half / core::math::sin(half);  // along the arc
}

RobotTest::RobotTest(Plant& plant, SessionClock& clock, const Experiment& believed, std::function<bool()> keep_on)
    : plant_(plant),
      clock_(clock),
      believed_(believed),
      loop_(plant, clock, believed, std::move(keep_on)),
      wanted_(plant.tags()),
      resting_(wanted_.size(), core::Pose{none, none, none}) {}

tl::expected<void, std::string> RobotTest::stand() {
  loop_.stand();
  const double begun = clock_.now();
  std::vector<core::Pose> sums(wanted_.size());
  std::vector<double> heading(wanted_.size()), last(wanted_.size(), -1e9);
  std::vector<int> counts(wanted_.size());
  while (clock_.now() < begun + standing) {
    if (auto ticked = loop_.tick(); !ticked) return ticked;
    for (std::size_t i = 0; plant_.cameras() && i < wanted_.size(); ++i) {
      const core::Measurement& seen = loop_.newest()[i];
      if (seen.captured_at < begun + settled || seen.captured_at <= last[i]) continue;
      last[i] = seen.captured_at;
      if (counts[i]++ == 0) heading[i] = seen.pose.theta;
      sums[i].x += seen.pose.x;
      sums[i].y += seen.pose.y;
      sums[i].theta += core::wrap_angle(seen.pose.theta - heading[i]);
    }
  }
  for (std::size_t i = 0; i < wanted_.size(); ++i) {
    const double n = counts[i];
    resting_[i] = counts[i] == 0
                      ? core::Pose{none, none, none}
                      : core::Pose{sums[i].x / n, sums[i].y / n, core::wrap_angle(heading[i] + sums[i].theta / n)};
  }
  return {};
}

/// Until its counters were asked for after it has stood: over a slow radio their answer comes later than the rest of
/// the tests takes, and older ones would blame a good robot's encoders.
tl::expected<void, std::string> RobotTest::read_counters(std::size_t robot) {
  if (!clock_.wall()) return {};
  const double stood = clock_.now(), patience = std::max(1.0, 4.0 * believed_.links.reply_timeout);
  const auto read = [&] { return plant_.robots().at(robot).count.since >= stood; };
  while (!read() && clock_.now() < stood + patience)
    if (auto ticked = loop_.tick(); !ticked) return ticked;
  return loop_.tick();  // which takes them
}

tl::expected<RobotTest::Manoeuvre, std::string> RobotTest::drive(std::size_t robot, double left, double right,
                                                                 double seconds) {
  const std::vector<core::Pose> before = resting_;
  const LinkRecord begun = loop_.link(robot);
  const double since = clock_.now();
  const bool one_wheel = left == 0.0 || right == 0.0;
  const auto counted = [&] {
    const LinkRecord& now = loop_.link(robot);
    return OneWheelTurn{now.left_steps - begun.left_steps, now.right_steps - begun.right_steps, clock_.now() - since};
  };
  loop_.command(robot, {left, right});
  for (int ticks = static_cast<int>(std::lround(seconds / believed_.period())); ticks > 0; --ticks) {
    if (auto ticked = loop_.tick(); !ticked) return tl::unexpected(ticked.error());
    if (one_wheel && counted().too_far(std::max(left, right))) break;
  }
  const double driven = clock_.now() - since + believed_.period();  // the next tick tells it to stand
  if (auto stood = stand(); !stood) return tl::unexpected(stood.error());
  if (auto read = read_counters(robot); !read) return tl::unexpected(read.error());
  Manoeuvre result{counted(), {}};
  result.wheels.seconds = driven;
  for (std::size_t i = 0; i < wanted_.size(); ++i)
    if (known(before[i]) && known(resting_[i])) result.tags.push_back({wanted_[i], before[i], resting_[i]});
  return result;
}

std::string RobotTest::whose(int tag) const {
  for (std::size_t i = 0; i < believed_.robots.size(); ++i)
    if (believed_.robots[i].tag == tag) return fmt::format(", which is that of {}", robot_name(believed_, i));
  return {};
}

/// What a fault adds on a tag that is not seen: the reason; empty: the robot has no tag.
std::string RobotTest::why_not_seen(std::size_t robot) const {
  const int expected = believed_.robots[robot].tag;
  if (expected < 0) return {};
  const UnseenTag why = plant_.cameras()->why_lost()[robot];
  if (why.tag == expected && !why.sentence.empty()) return ": " + why.sentence;
  return fmt::format(": is its tag {} covered, or outside the picture?", expected);
}

/// Which tag turned with the robot, and what it says of the wheels.
void RobotTest::judge_camera(std::size_t robot, const Manoeuvre& left, const Manoeuvre& right,
                             RobotTestResult& result) const {
  const int expected = believed_.robots[robot].tag;
  const bool seen = std::any_of(left.tags.begin(), left.tags.end(), [&](const Moved& m) { return m.tag == expected; });
  std::vector<const Moved*> turned;
  for (const Moved& tag : left.tags)
    if (std::abs(tag.turned()) > turned_at_least) turned.push_back(&tag);
  const auto its_own =
      std::find_if(turned.begin(), turned.end(), [&](const Moved* moved) { return moved->tag == expected; });
  if (turned.empty()) {
    result.tag_fault = true;
    result.faults.push_back(
        seen ? fmt::format(
                   "its tag {} is seen but does not turn with it: do its wheels turn, or is the tag on another robot?",
                   expected)
             : "no visible tag turns with it" + why_not_seen(robot));
    return;
  }
  const Moved& with_left = its_own == turned.end() ? *turned.front() : **its_own;
  result.tag = with_left.tag;
  if (turned.size() > 1)
    result.notes.push_back(fmt::format("{} tags turned at once: was a robot moved by hand?", turned.size()));
  if (expected >= 0 && result.tag != expected) {
    result.tag_fault = true;
    result.faults.push_back(
        fmt::format("the wrong tag: it carries tag {}{}, instead of tag {}", result.tag, whose(result.tag), expected));
  }
  const auto with_right =
      std::find_if(right.tags.begin(), right.tags.end(), [&](const Moved& m) { return m.tag == result.tag; });
  if (with_right == right.tags.end()) {
    result.notes.push_back(fmt::format("its tag {} was lost on the way", result.tag));
    return;
  }
  // What each wheel rolled, from how the tag turned and went ahead.
  const core::DifferentialDrive& drive = believed_.robots[robot].drive;
  const core::RobotType& type = *believed_.robots[robot].type;
  const double way_a_second = steps_of(type, one_wheel_speed) * drive.metres_per_step() * 1e3;
  for (const auto& [moved, is_left] : {std::pair(&with_left, true), std::pair(&*with_right, false)}) {
    const double arc = 0.5 * moved->turned() * drive.track, way = moved->forward();
    const double rolled_left = 1e3 * (way - arc), rolled_right = 1e3 * (way + arc);
    const char* const wheel = is_left ? "left" : "right";
    const double most = way_a_second * std::max(one_wheel_time, (is_left ? left : right).wheels.seconds);
    const std::string wrong = wheel_fault(wheel,
                                          {is_left ? rolled_left : rolled_right, is_left ? rolled_right : rolled_left,
                                           way_a_second * one_wheel_time, most, "mm"},
                                          " does not turn");
    const bool said = std::any_of(result.faults.begin(), result.faults.end(), [&](const std::string& fault) {
      return fault.find(wheel + std::string(" wheel")) != std::string::npos;
    });
    if (!wrong.empty() && !said) result.faults.push_back(fmt::format("{}, according to the camera", wrong));
  }
}

/// Whether no other tag is where the robot with this one would drive, straight ahead or (negative) back.
bool RobotTest::free_way(int tag, double distance, double radius) const {
  const auto own = std::find(wanted_.begin(), wanted_.end(), tag) - wanted_.begin();
  const core::Pose& at = resting_[static_cast<std::size_t>(own)];
  const double ahead_x = core::math::cos(at.theta), ahead_y = core::math::sin(at.theta);
  if (std::abs(at.x + distance * ahead_x) > 0.5 * believed_.arena_width - radius ||
      std::abs(at.y + distance * ahead_y) > 0.5 * believed_.arena_height - radius)
    return false;
  for (std::size_t i = 0; i < resting_.size(); ++i) {
    if (static_cast<std::ptrdiff_t>(i) == own || !known(resting_[i])) continue;
    const double dx = resting_[i].x - at.x, dy = resting_[i].y - at.y;
    const double along = std::clamp(dx * ahead_x + dy * ahead_y, std::min(0.0, distance), std::max(0.0, distance));
    const double room = elbow_room + 2.0 * (radius - core::standard_radius);
    if (core::math::hypot(dx - along * ahead_x, dy - along * ahead_y) < room) return false;
  }
  return true;
}

/// How large its wheels are and how far apart, from what the camera saw against what the encoders counted.
tl::expected<void, std::string> RobotTest::calibrate(std::size_t robot, RobotTestResult& result) {
  const core::DifferentialDrive& drive = believed_.robots[robot].drive;
  const core::RobotType& type = *believed_.robots[robot].type;
  const double way_speed = steps_of(type, epuck_way_speed), turn_speed = steps_of(type, epuck_turn_speed);
  const double distance = way_speed * way_time * drive.metres_per_step();
  const double radius = believed_.robots[robot].radius;
  const double sign = free_way(result.tag, distance, radius) ? 1.0 : -1.0;
  if (sign < 0.0 && !free_way(result.tag, -distance, radius)) {
    result.notes.push_back(
        fmt::format("its wheels were not measured: it needs {:.0f} mm of free floor ahead or behind, inside the arena "
                    "and away from other robots",
                    1e3 * (distance + radius)));
    return {};
  }
  double way = 0.0, way_steps = 0.0, turn = 0.0, turn_steps = 0.0;  // all counted positive
  for (const auto& [left, right, seconds] :
       {std::tuple(sign * way_speed, sign * way_speed, way_time),
        std::tuple(-sign * way_speed, -sign * way_speed, way_time), std::tuple(-turn_speed, turn_speed, turn_time),
        std::tuple(turn_speed, -turn_speed, turn_time)}) {
    const auto driven = this->drive(robot, left, right, seconds);
    if (!driven) return tl::unexpected(driven.error());
    const auto moved =
        std::find_if(driven->tags.begin(), driven->tags.end(), [&](const Moved& tag) { return tag.tag == result.tag; });
    if (moved == driven->tags.end()) {
      result.notes.push_back(fmt::format("its wheels were not measured: its tag {} was lost on the way", result.tag));
      return {};
    }
    if (left == right) {
      way += std::abs(moved->forward());
      way_steps += 0.5 * std::abs(driven->wheels.left + driven->wheels.right);
    } else {
      const double steps = driven->wheels.right - driven->wheels.left;
      // More than half a turn looks like less the other way round: the files know the angle well enough to tell.
      const double about = steps * drive.metres_per_step() / drive.track;
      turn += std::abs(about + core::wrap_angle(moved->turned() - about));
      turn_steps += std::abs(steps);
    }
  }
  const double few = steps_of(type, 100.0);
  if (way_steps < few || turn_steps < few || way <= 0.0 || turn <= 0.0) return {};  // named as a fault already
  const double diameter = way / way_steps * drive.steps_per_turn / core::pi;
  const double track = turn_steps * way / way_steps / turn;
  result.wheel_diameter = diameter;
  result.track = track;
  const auto compare = [&](const char* key, double measured, double file, double tolerance) {
    if (std::abs(measured / file - 1.0) <= tolerance) return;
    result.faults.push_back(fmt::format("{} is {} according to the camera, {:+.1f} % off the configured {}", key,
                                        in_mm(measured), 1e2 * (measured / file - 1.0), in_mm(file)));
  };
  compare("wheel_diameter", diameter, drive.wheel_diameter, diameter_tolerance);
  compare("track", track, drive.track, track_tolerance);
  return {};
}

std::vector<std::pair<std::string, std::string>> values_to_keep(const RobotTestResult& result) {
  std::vector<std::pair<std::string, std::string>> values;
  const auto keep = [&](const char* key, std::string value) { values.emplace_back(key, std::move(value)); };
  if (result.tag >= 0) keep("tag", std::to_string(result.tag));
  if (!result.status.version.empty()) keep("version", toml_string(result.status.version));
  if (result.wheel_diameter) keep("wheel_diameter", fmt::format("{:.5f}", *result.wheel_diameter));
  if (result.watchdog) keep("watchdog", fmt::format("{:.2f}", *result.watchdog));
  if (result.track) keep("track", fmt::format("{:.5f}", *result.track));
  return values;
}

double watchdog_of(double steps, double speed, double silence) noexcept {
  constexpr double all_of_it = 0.8;  // commands stop acting a little early, encoders are read a little late
  const double seconds = std::abs(steps / speed);
  return seconds > all_of_it * silence ? 0.0 : seconds;
}

/// Nothing is sent for a second while the robot drives: 3 cm of way in all.
tl::expected<void, std::string> RobotTest::cut_line(std::size_t robot, RobotTestResult& result) {
  const double speed = steps_of(*believed_.robots[robot].type, 150.0);
  constexpr double begins = 0.2, silence = 1.0, most_of_it = 0.8, answers = 0.6;  // [steps/s, s]
  if (!clock_.wall()) return {};
  // When an answer is missing or invalid the link stops the robot: then it does not stand by itself.
  const auto stopped_by_link = [&] { return plant_.robots().at(robot).resynchronisations; };
  const std::uint64_t stopped_before = stopped_by_link();
  loop_.command(robot, {speed, speed});
  const auto go_on = [this](double seconds) -> tl::expected<void, std::string> {
    for (int ticks = static_cast<int>(std::lround(seconds / believed_.period())); ticks > 0; --ticks)
      if (auto ticked = loop_.tick(); !ticked) return ticked;
    return {};
  };
  if (auto begun = go_on(0.5 * begins); !begun) return begun;
  const WheelCount first = plant_.robots().at(robot).count;
  if (auto begun = go_on(begins); !begun) return begun;
  const WheelCount second = plant_.robots().at(robot).count;
  // Wheels that turn farther than commanded would seem to have driven on for longer. At least so fast:
  const double counted = 0.5 * (second.left - first.left + second.right - first.right) / (second.by - first.since);
  plant_.hush(robot, silence);
  const LinkRecord before = loop_.link(robot);
  if (auto waited = go_on(most_of_it * silence); !waited) return waited;
  const bool left_alone = stopped_by_link() == stopped_before;
  if (auto waited = go_on((1.0 - most_of_it) * silence); !waited) return waited;
  if (auto stood = stand(); !stood) return stood;
  if (auto answered = go_on(answers); !answered) return answered;
  if (!left_alone) {
    result.notes.push_back("whether it has a watchdog is not known: answers were missing or invalid meanwhile");
    return {};
  }
  const LinkRecord& after = loop_.link(robot);
  const double steps = 0.5 * (after.left_steps - before.left_steps + after.right_steps - before.right_steps);
  result.watchdog = watchdog_of(steps, counted > speed ? counted : speed, silence);
  return {};
}

tl::expected<RobotTestResult, std::string> RobotTest::test(std::size_t robot) {
  RobotTestResult result;
  const double begun = clock_.now();
  const auto seen = [this] {
    return std::any_of(loop_.newest().begin(), loop_.newest().end(),
                       [](const core::Measurement& m) { return m.captured_at > 0.0; });
  };
  while (plant_.cameras() && !looked_ && clock_.now() < begun + (seen() ? all_parts : first_sight))
    if (const auto ticked = loop_.tick(); !ticked) return tl::unexpected(ticked.error());
  looked_ = true;
  if (const auto stood = stand(); !stood) return tl::unexpected(stood.error());
  if (const auto read = read_counters(robot); !read) return tl::unexpected(read.error());

  const double speed = steps_of(*believed_.robots[robot].type, one_wheel_speed);
  const std::uint64_t wrong_before = plant_.wrong_speeds(robot);
  const auto left = drive(robot, speed, 0.0, one_wheel_time);
  if (!left) return tl::unexpected(left.error());
  const auto right = drive(robot, 0.0, speed, one_wheel_time);
  if (!right) return tl::unexpected(right.error());
  result.left_steps = left->wheels.left;
  result.right_steps = right->wheels.right;
  result.faults = encoder_faults(left->wheels, right->wheels, speed);
  if (plant_.cameras()) {
    const std::size_t wheels_at_fault = result.faults.size();
    judge_camera(robot, *left, *right, result);
    const bool only_the_tag = result.faults.empty() || (wheels_at_fault == 0 && result.faults.size() == 1 &&
                                                        result.tag != believed_.robots[robot].tag);
    if (result.tag >= 0 && only_the_tag)
      if (const auto calibrated = calibrate(robot, result); !calibrated) return tl::unexpected(calibrated.error());
  }
  if (result.faults.empty())
    if (const auto cut = cut_line(robot, result); !cut) return tl::unexpected(cut.error());
  if (std::string fault = speed_fault(plant_.wrong_speeds(robot) - wrong_before); !fault.empty())
    result.faults.push_back(std::move(fault));
  result.status = plant_.robots().at(robot);
  return result;
}

}  // namespace skein::app

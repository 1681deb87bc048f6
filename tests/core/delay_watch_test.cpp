// Whether robots are seen to do what they are commanded to later than is known.
#include "core/safety/delay_watch.h"

#include <gtest/gtest.h>

#include <deque>
#include <vector>

#include "core/safety/obedience_watch.h"
#include "core/simulation/simulated_robot.h"
#include "draw.h"
#include "lab.h"
#include "tests/property.h"

namespace skein::test {
namespace {

using core::DelayWatch;
using core::DifferentialDrive;
using core::Imperfection;
using core::Measurement;
using core::ObedienceWatch;
using core::PoseFilter;
using core::SimulatedRobot;
using core::WheelSpeeds;

constexpr double to_wheel = 0.0265;

/// A robot whose pictures are late: each shows what was so long before its time stamp. It gets other speeds every few
/// seconds, and stands in between.
struct Late {
  Late(double delay, const Imperfection& imperfection, std::uint64_t seed)
      : delay(delay), draw(seed), robot({}, core::MotorModel::ideal, imperfection, seed, 0) {}

  void tick(double now) {
    const Measurement measured = robot.measure(now);
    if (seen.empty() || seen.back().captured_at < measured.captured_at) seen.push_back(measured);
    while (seen.size() > 1 && seen[1].captured_at <= now - delay + 1e-9) seen.pop_front();
    Measurement picture = seen.front();
    picture.captured_at += delay;
    if (picture.captured_at <= now + 1e-9) {
      filter.see({}, picture);
      watch.see({.now = now, .to_wheel = to_wheel, .kidnap = 0.02, .blind_way = 0.0, .judged = true}, filter, picture);
    }
    if (now >= changes_at) {
      const bool stands = draw.whole(0, 3) == 0;
      commanded = stands ? WheelSpeeds{} : WheelSpeeds{draw.between(-700.0, 700.0), draw.between(-700.0, 700.0)};
      changes_at = now + draw.between(0.3, 4.0);
    }
    filter.command(now, DifferentialDrive{}.twist(commanded));
    robot.command(obeys ? commanded : WheelSpeeds{});
    robot.step(dt);
  }

  double delay, changes_at = 1.0;
  bool obeys = true;
  Draw draw;
  SimulatedRobot robot;
  std::deque<Measurement> seen;
  PoseFilter filter;
  ObedienceWatch watch;
  WheelSpeeds commanded;
};

/// When it is known that they are late, and by how much. [s; s]
struct Known {
  double at = 0.0, late = 0.0;
};
std::optional<Known> watched(std::vector<Late>& robots, double seconds) {
  DelayWatch watch;
  double now = 0.0;
  for (std::size_t k = 0; now < seconds; ++k, now += dt) {
    for (Late& robot : robots) robot.tick(now);
    const Late& one = robots[k % robots.size()];
    if (one.watch.motion()) watch.see(one.filter, one.watch.first_sight(), one.watch.newest_sight(), to_wheel);
    if (const auto late = watch.late()) return Known{now, *late};
  }
  return std::nullopt;
}

std::vector<Late> group(double delay, const Imperfection& imperfection, Draw& draw) {
  std::vector<Late> robots;
  for (auto n = static_cast<std::size_t>(draw.whole(1, 4)); robots.size() < n;)
    robots.emplace_back(delay, imperfection, static_cast<std::uint64_t>(draw.whole(1, 1 << 30)));
  return robots;
}

TEST(DelayWatch, KnowsByHowMuchPicturesAreOlderThanTheirTimeStamps) {
  holds("known within 15 s, to 0.1 s", [] {
    Draw draw(any_seed());
    Imperfection poor;
    poor.pose_noise = draw.between(0.0, 0.001), poor.heading_noise = draw.between(0.0, 0.01), poor.slip = 0.03;
    const double delay = draw.between(0.5, 2.45);
    std::vector<Late> robots = group(delay, poor, draw);
    const auto known = watched(robots, 15.0 + delay);
    RC_ASSERT(known.has_value());
    RC_ASSERT(std::abs(known->late - delay) < 0.1);
  });
}

TEST(DelayWatch, SaysNothingOfRobotsThatAreSeenInTimeOrDoNotObey) {
  holds("not late", [] {
    Draw draw(any_seed());
    Imperfection poor;
    poor.pose_noise = draw.between(0.0, 0.003), poor.heading_noise = draw.between(0.0, 0.03);
    poor.slip = 0.05, poor.dropout = 0.05;
    std::vector<Late> robots = group(draw.between(0.0, 0.15), poor, draw);
    for (Late& robot : robots) robot.obeys = draw.whole(0, 2) > 0;
    RC_ASSERT(!watched(robots, 30.0).has_value());
  });
}

}  // namespace
}  // namespace skein::test

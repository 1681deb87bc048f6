#include "app/experiment/experiment_checks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "app/experiment/experiment_events.h"
#include "app/experiment/experiment_reference.h"
#include "app/experiment/experiment_trajectory.h"
#include "app/experiment/hardware.h"
#include "comms/link_address.h"
#include "core/planning/formation_clock.h"
#include "vision/sources/open_source.h"

namespace skein::app {
namespace {

std::string robot_key(std::size_t i, const char* key) {
  return fmt::format("robot.{}.{}", i + 1, key);
}

void check_duration(const Experiment& e, Problems& problems) {
  constexpr double most_ticks = 1e7;  // a file of some 10 GB
  const double ticks = e.duration * e.rate;
  if (ticks < 1.0 || ticks > most_ticks)
    problems.add("duration", fmt::format("found {} s at {} Hz, which is {:.6g} ticks, allowed: 1 to {:.0f} ticks",
                                         e.duration, e.rate, std::floor(ticks), most_ticks));
}

void check_robots(const Experiment& e, Problems& problems) {
  const bool real_camera = is_hardware(e.camera.kind());
  std::map<int, std::size_t> tags;
  std::map<std::string, std::size_t> addresses, names, adapters;  // adapters: robots that each holds
  constexpr std::size_t most_on_an_adapter = 7;                   // connections of a Bluetooth piconet
  for (std::size_t i = 0; i < e.robots.size(); ++i) {
    const RobotSpec& robot = e.robots[i];
    if (const auto [other, unique] = tags.emplace(robot.tag, i); !unique)
      problems.add(robot_key(i, "tag"),
                   fmt::format("found {}, which robot {} already has, allowed: a different tag for each robot",
                               robot.tag, other->second + 1));
    if (const auto [other, unique] = names.emplace(robot.name, i); !unique && !robot.name.empty())
      problems.add(robot_key(i, "name"),
                   fmt::format("found \"{}\", which is the name of robot {}, allowed: a different name for each robot",
                               robot.name, other->second + 1));
    // Half a tick more than one, since ticks can be late.
    if (const double most = robot.watchdog.value_or(0.0) / 1.5; robot.has_link() && most > 0.0 && e.period() >= most)
      problems.add("rate",
                   fmt::format("found {} Hz, at which robot {} stops by itself between two ticks (watchdog {} s); "
                               "allowed: above {:.4g} Hz",
                               e.rate, i + 1, *robot.watchdog, 1.0 / most));
    if (robot.simulated()) continue;
    const auto link = comms::parse_link_address(robot.address);
    if (const auto [other, unique] = addresses.emplace(link ? comms::canonical_text(*link) : robot.address, i); !unique)
      problems.add(robot_key(i, "link"),
                   fmt::format("found \"{}\", which robot {} already has, allowed: a different link for each robot",
                               robot.address, other->second + 1));
    if (link && link->kind == comms::LinkKind::rfcomm && ++adapters[robot.adapter] == most_on_an_adapter + 1)
      problems.add(robot_key(i, "adapter"),
                   fmt::format("found \"{}\" for more than {} robots, allowed: {} per adapter; use another one for the "
                               "others, as in adapter = \"hci1\"",
                               robot.adapter, most_on_an_adapter, most_on_an_adapter));
    if (!real_camera)
      problems.add(
          "camera.source",
          fmt::format("found \"{}\", allowed: {}, since robot {} is a real one (link \"{}\") and only a camera can see "
                      "it",
                      e.camera.source, vision::source_forms(), i + 1, robot.address));
  }
  for (std::size_t k = 0; k < e.cameras(); ++k) {
    const CameraSpec& camera = e.camera_at(k);
    const auto key = [k](const char* name) {
      return k == 0 ? fmt::format("camera.{}", name) : fmt::format("camera.also.{}.{}", k, name);
    };
    if (is_hardware(camera.kind()) && camera.calibration.empty())
      problems.add(key("calibration"),
                   fmt::format("missing, allowed: the file that `skein calibrate` wrote for \"{}\"", camera.source));
    for (std::size_t other = 0; other < k; ++other) {
      const CameraSpec& before = e.camera_at(other);
      if (camera.kind() == CameraKind::synthetic || camera.kind() == CameraKind::absent) continue;
      if (camera.source == before.source)
        problems.add(
            key("source"),
            fmt::format("found \"{}\", which camera {} already has, allowed: a different source for each camera",
                        camera.source, other + 1));
      else if (!camera.calibration.empty() && camera.calibration == before.calibration)
        problems.add(key("calibration"),
                     fmt::format("found \"{}\", which camera {} already has, allowed: a calibration for each camera, "
                                 "since no two hang at one place",
                                 camera.calibration, other + 1));
    }
  }
}

/// The condition (18a) for the tracking gains of (36): the reference and the couplings must leave a part of `whole`.
struct Bound {
  const char* equation;
  const char* whole_name;
  const char* tracking_gain;
  const char* unit;
  double whole;                // v_max, omega_max
  std::vector<double> wholes;  // of each robot
  double demand;               // what the reference takes of it, at most
  double per_speed;            // the same for 1 m/s of reference.speed; 0: that says nothing of it
  std::vector<std::string> keys;
  std::vector<const core::PairTable*> tables;
};

/// Says that robot i's couplings take too much, at the k-th of the bound's keys.
void refuse_gain(const Bound& bound, std::size_t i, std::size_t k, double sum, std::size_t robots, Problems& problems) {
  const double room = bound.whole - bound.demand, own = bound.tables[k]->row_sum(i), left = room - (sum - own);
  if (own == 0.0 || (left <= 0.0 && own < room)) return;  // the other one alone is too much
  const std::string& key = bound.keys[k];
  const double allowed = left > 0.0 ? left : room;
  const std::string slower =
      bound.whole > sum && bound.per_speed > 0.0
          ? fmt::format(", or reference.speed below {:.6g}", (bound.whole - sum) / bound.per_speed)
          : "";
  // A gain that the file does not name has the paper's value: then it is the speed that asks too much.
  problems.add(
      !problems.has(key) && problems.has("reference.speed") ? "reference.speed" : key,
      fmt::format("{} fails for robot {} by {:.4g} {}: {} {:.6g} - reference {:.6g} - couplings {:.6g} leaves {} = "
                  "{:.4g}, which must be above 0; allowed: {} below {:.6g} for all pairs{} (a sum below {:.6g} over "
                  "robot {}'s pairs){}",
                  bound.equation, i + 1, sum - room, bound.unit, bound.whole_name, bound.whole, bound.demand, sum,
                  bound.tracking_gain, room - sum, key.substr(key.rfind('.') + 1),
                  allowed / static_cast<double>(robots - 1), left > 0.0 ? "" : " were it the only coupling", allowed,
                  i + 1, slower));
}

void check_bound(Bound bound, std::size_t robots, Problems& problems) {
  for (std::size_t i = 0; i < robots; ++i) {
    bound.whole = bound.wholes[i];
    if (bound.whole <= bound.demand) continue;  // said by check_speed
    double sum = 0.0;
    for (const core::PairTable* table : bound.tables) sum += table->row_sum(i);
    if (sum < bound.whole - bound.demand) continue;
    for (std::size_t k = 0; k < bound.keys.size(); ++k) refuse_gain(bound, i, k, sum, robots, problems);
    return;  // the first robot says it for the others
  }
}

std::vector<double> all_v_max(const Experiment& e) {
  std::vector<double> all;
  for (std::size_t i = 0; i < e.robots.size(); ++i) all.push_back(make_limits(e, i).v_max);
  return all;
}
std::vector<double> all_omega_max(const Experiment& e) {
  std::vector<double> all;
  for (std::size_t i = 0; i < e.robots.size(); ++i) all.push_back(make_limits(e, i).omega_max);
  return all;
}

/// What the reference asks for where the formation keeps its first shape.
core::ReferenceDemand without_changes(const Experiment& e) {
  Experiment still = e;
  still.reference.changes.clear();
  return make_reference(still)->demand(e.controller.k_y);
}

void check_speed(const Experiment& e, const core::Reference& reference, Problems& problems) {
  const core::ReferenceDemand demand = reference.demand(e.controller.k_y);
  if (e.reference.kind == ReferenceSpec::Kind::independent) return check_trajectory_speeds(e, problems);
  const std::vector<double> forward = all_v_max(e), turning = all_omega_max(e);  // all robots share the reference
  const double v_max = *std::min_element(forward.begin(), forward.end());
  const double omega_max = *std::min_element(turning.begin(), turning.end());
  const double curvature = make_path(e.reference.path)->largest_curvature();
  const auto too_fast = [&](const core::ReferenceDemand& d) { return d.v >= v_max || d.turning >= omega_max; };
  if (too_fast(demand) && !too_fast(without_changes(e))) {
    const bool platoon = e.reference.kind == ReferenceSpec::Kind::platoon;
    problems.add("reference.change",
                 fmt::format("found changes of {} in which robots drive up to {:.6g} m/s{}, for which {} fails with "
                             "any couplings, allowed: longer changes",
                             platoon ? "spacing" : "shape", demand.v,
                             demand.v >= v_max ? "" : fmt::format(" and turn at up to {:.6g} rad/s", demand.turning),
                             demand.v >= v_max ? "(18f)" : "(18g)"));
    return;
  }
  const double share = std::max(demand.v / v_max, demand.turning / omega_max);
  const double fastest = e.reference.speed / share;  // all velocities grow with it
  if (demand.v >= v_max || demand.turning >= omega_max)
    problems.add("reference.speed", fmt::format("found {}, for which {} fails with any couplings; allowed: below "
                                                "{:.6g} m/s with v_max {}, omega_max {}, k_y {} and bends of {:.4g} m",
                                                e.reference.speed, demand.v >= v_max ? "(18f)" : "(18g)", fastest,
                                                v_max, omega_max, e.controller.k_y, 1.0 / curvature));
}

/// (18f, g) with tracking gains that are given, at the key of the file that fails first. `place`: of a change; empty:
/// at the start.
void check_fixed(const Experiment& e, const core::ReferenceDemand& demand, const core::CouplingGains& gains,
                 const core::TrackingGains& tracking, const std::string& place, Problems& problems) {
  constexpr double rounding = 1e-12;
  const std::size_t robots = e.robots.size();
  const auto check = [&](const char* equation, core::TrackingGain name, const std::vector<double>& wholes,
                         double reference, const std::vector<double>& couplings) {
    const auto left_of = [&](std::size_t i) { return wholes[i] - reference - couplings[i]; };
    std::size_t worst = 0;
    for (std::size_t i = 1; i < robots; ++i)
      if (left_of(i) - tracking[name][i] < left_of(worst) - tracking[name][worst]) worst = i;
    const double given = tracking[name][worst], left = left_of(worst);
    if (given <= left + rounding) return;
    const std::string said = fmt::format(
        "{} fails for robot {} by {:.4g}: {:.6g} - reference {:.6g} - couplings {:.6g} "
        "leaves {:.6g} for {} = {}",
        equation, worst + 1, given - left, wholes[worst], reference, couplings[worst], left, word(name), given);
    const std::string key = e.robots[worst].own(name) ? fmt::format("robot.{}.{}", worst + 1, word(name))
                                                      : fmt::format("controller.{}", word(name));
    problems.add(place.empty() ? key : place,
                 left > 0.0 ? fmt::format("{}, allowed: up to {:.6g}", said, left)
                            : fmt::format("{}, allowed: a slower reference or smaller couplings", said));
  };
  std::vector<double> forward, turning;
  for (std::size_t i = 0; i < robots; ++i) {
    forward.push_back(gains.k_xx.row_sum(i));
    turning.push_back(gains.k_tt.row_sum(i) + gains.k_yy.row_sum(i));
  }
  check("(18f)", core::TrackingGain::k_x, all_v_max(e), demand.v, forward);
  check("(18g)", core::TrackingGain::k_theta, all_omega_max(e), demand.turning, turning);
}

void check_gains(const Experiment& e, const core::Reference& reference, Problems& problems) {
  const ControllerSpec& c = e.controller;
  const core::ReferenceDemand demand = reference.demand(c.k_y);
  // A change of shape asks for its own speed, whatever reference.speed is.
  const core::ReferenceDemand unchanged = without_changes(e);
  const bool one_speed = e.reference.kind != ReferenceSpec::Kind::independent && demand.v <= unchanged.v &&
                         demand.turning <= unchanged.turning;
  const auto check_xx = [&](const core::CouplingGains& gains, const std::string& place) {
    check_bound({"(18f)",
                 "v_max",
                 "k_x",
                 "m/s",
                 c.v_max,
                 all_v_max(e),
                 demand.v,
                 !one_speed       ? 0.0
                 : demand.v > 0.0 ? demand.v / e.reference.speed
                                  : 1.0,
                 {place + ".k_xx"},
                 {&gains.k_xx}},
                e.robots.size(), problems);
  };
  const auto check_tt_yy = [&](const core::CouplingGains& gains, const std::string& place) {
    check_bound({"(18g)",
                 "omega_max",
                 "k_theta",
                 "rad/s",
                 c.omega_max,
                 all_omega_max(e),
                 demand.turning,
                 !one_speed       ? 0.0
                 : demand.v > 0.0 ? demand.turning / e.reference.speed
                                  : c.k_y,
                 {place + ".k_tt", place + ".k_yy"},
                 {&gains.k_tt, &gains.k_yy}},
                e.robots.size(), problems);
  };
  core::CouplingGains gains = c.gains;
  core::TrackingSchedule tracking(make_tracking(e));
  if (c.policy == core::GainPolicy::fixed) check_fixed(e, demand, gains, tracking.now(), {}, problems);
  check_xx(gains, "controller.gains");
  check_tt_yy(gains, "controller.gains");

  std::vector<std::size_t> order(e.gain_changes.size());  // of time, which need not be that of the file
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return e.gain_changes[a].t < e.gain_changes[b].t; });
  for (const std::size_t i : order) {
    const GainChange& change = e.gain_changes[i];
    const std::string place = fmt::format("gain_change.{}", i + 1);
    if (change[core::GainName::k_xx]) gains.k_xx = *change[core::GainName::k_xx];
    if (change[core::GainName::k_tt]) gains.k_tt = *change[core::GainName::k_tt];
    if (change[core::GainName::k_yy]) gains.k_yy = *change[core::GainName::k_yy];
    if (change[core::GainName::k_xx]) check_xx(gains, place);
    if (change[core::GainName::k_tt] || change[core::GainName::k_yy]) check_tt_yy(gains, place);
    tracking.ramp(change.tracking, 0.0);
    if (c.policy == core::GainPolicy::fixed) check_fixed(e, demand, gains, tracking.target(), place, problems);
  }
}

void check_estimation(const Experiment& e, Problems& problems) {
  if (e.simulation.latency > 0.0 && e.estimation.bridge <= e.simulation.latency)
    problems.add("estimation.bridge", fmt::format("found {}, allowed: above simulation.latency, {} s; otherwise every "
                                                  "pose is too old when it arrives and every robot is lost",
                                                  e.estimation.bridge, e.simulation.latency));
}

/// Whether a formation that waits can also catch up.
void check_waiting(const Experiment& e, const core::Reference& reference, Problems& problems) {
  if (!e.avoidance.formation_waits) return;
  if (e.avoidance.kind != core::AvoidanceKind::plan || !e.avoidance.enabled)
    return problems.add("avoidance.formation_waits",
                        "found true, allowed: false, or true beside avoidance.kind = \"plan\" and avoidance.enabled = "
                        "true, since the formation waits for robots on planned routes");
  const double hurry = core::FormationClock::hurry(make_gains(e), reference.demand(e.controller.k_y));
  if (hurry < core::FormationClock::least_hurry)
    problems.add("avoidance.formation_waits",
                 fmt::format("found true, but its references and couplings leave it {:.2g} % of its speed to catch up "
                             "with, allowed: at least {:g} %, or false; references that are slower, or smaller "
                             "couplings, leave more",
                             100.0 * hurry, 100.0 * core::FormationClock::least_hurry));
  // Proposition 7 of docs/theory.md: its clock learns of a change in the change's first tick.
  const double shortest = 4.0 * e.period();
  for (std::size_t i = 0; i < e.gain_changes.size(); ++i) {
    const GainChange& change = e.gain_changes[i];
    const bool couples = std::any_of(core::gain_names.begin(), core::gain_names.end(),
                                     [&](core::GainName name) { return change[name].has_value(); });
    if (couples && change.ramp < shortest * (1.0 - 1e-9))
      problems.add(
          fmt::format("gain_change.{}.ramp", i + 1),
          fmt::format("found {:g} s, allowed beside avoidance.formation_waits: at least {:g} s, four ticks, in "
                      "which a formation that catches up slows down for the couplings",
                      change.ramp, shortest));
  }
}

}  // namespace

void check_together(const Experiment& e, Problems& problems) {
  // What is wrong by itself has a default here: nothing that follows from it is said. Asked before these checks add
  // problems of their own.
  const auto sound = [&](auto... keys) { return problems.sound({keys...}); };
  const bool robots = sound("robot", "robot_defaults", "robots_file");
  const bool controller = sound("controller"), changes = sound("gain_change"), waits = sound("avoidance");
  const bool time = sound("duration", "rate"), late = sound("simulation", "estimation");
  const bool linked = robots && sound("rate", "camera");
  const bool events = robots && controller && sound("arena", "perturb", "operator", "obstacle");
  const bool shape = robots && sound("reference", "duration");
  const SoundTables places{sound("arena"), waits, sound("shield"), sound("obstacle")};

  if (time) check_duration(e, problems);
  if (linked) check_robots(e, problems);
  if (events) check_events(e, problems);
  if (late) check_estimation(e, problems);
  if (!shape || !check_shape(e, problems)) return;  // without a path there is no reference
  const std::unique_ptr<const core::Reference> reference = make_reference(e);
  check_places(e, *reference, places, problems);
  if (!controller) return;
  check_speed(e, *reference, problems);
  if (changes) check_gains(e, *reference, problems);
  if (waits) check_waiting(e, *reference, problems);
}

}  // namespace skein::app

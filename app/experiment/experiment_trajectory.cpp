#include "app/experiment/experiment_trajectory.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "app/experiment/experiment_path.h"
#include "app/experiment/longest.h"

namespace skein::app {
namespace {

constexpr double longest_curve = 1000.0;  // only a slip of the keyboard exceeds it [m]

/// What belongs to a drive from rest to rest, and says nothing of one that goes on for ever.
void refuse_endless(const TrajectorySpec& t, const std::string& key, Problems& problems) {
  const auto refuse = [&](const char* name) {
    if (problems.has(key + "." + name))
      problems.add(key + "." + name,
                   "found with a closed path, which is driven for ever, allowed: with a distance, after which it "
                   "rests, or with an open path");
  };
  for (const char* name : {"t", "duration", "acceleration", "turn_rate"}) refuse(name);
  if (t.path.shape == PathSpec::Shape::rounded_rectangle && !problems.has(key + ".path"))
    problems.add(key + ".path", "missing, allowed: the path that the robot drives");
}

/// That places and times can be driven through, and headings, where they are given, are those of the motion.
bool check_samples(const TrajectorySpec& t, const std::string& key, Problems& problems) {
  constexpr double agrees = 0.2;    // [rad]: what numbers that were rounded, or measured, are off
  constexpr double crawls = 0.005;  // [m/s]: a direction that means nothing
  const auto refuse = [&](std::size_t k, const std::string& text) {
    problems.add(key + ".samples", fmt::format("{} at t = {:g} s", text, t.samples[k].t));
    return false;
  };
  for (std::size_t k = 1; k < t.samples.size(); ++k) {
    if (!(t.samples[k].t > t.samples[k - 1].t)) {
      problems.add(key + ".samples", fmt::format("found t = {} after {}, allowed: times that increase", t.samples[k].t,
                                                 t.samples[k - 1].t));
      return false;
    }
    if (t.samples[k].place == t.samples[k - 1].place)
      return refuse(k, "found the same place again, allowed: places that differ, since a place has no direction,");
  }
  const core::Timetable motion(t.samples);
  for (std::size_t k = 0; k < t.headings.size(); ++k) {
    const core::ReferencePoint point = motion.at(t.samples[k].t);
    const bool end = k == 0 || k + 1 == t.headings.size();
    if (!end && point.twist.v < crawls) continue;
    if (std::abs(core::wrap_angle(t.headings[k] - point.pose.theta)) > agrees)
      return refuse(
          k, fmt::format("found theta = {:.4g}, allowed: {:.4g} within {} rad, the direction in which a unicycle "
                         "drives through these places",
                         t.headings[k], point.pose.theta, agrees));
  }
  return true;
}

bool check_trajectory(const Experiment& e, std::size_t i, Problems& problems) {
  const TrajectorySpec& t = *e.robots[i].trajectory;
  const std::string key = fmt::format("robot.{}.trajectory", i + 1);
  if (!t.samples.empty()) return check_samples(t, key, problems);
  if (!check_path(t.path, key + ".path", problems)) return false;
  if (!t.from_rest_to_rest()) {
    refuse_endless(t, key, problems);
    return true;
  }
  const double length = make_path(t.path)->length();
  if (!t.path.closed && (t.start < 0.0 || t.start >= length)) {
    problems.add(key + ".start",
                 fmt::format("found {}, allowed: from 0 to below {:.6g} m, the length of the path", t.start, length));
    return false;
  }
  if (!t.path.closed && t.distance && *t.distance > length - t.start) {
    problems.add(key + ".distance",
                 fmt::format("found {}, allowed: up to {:.6g} m, the length of the path from its start", *t.distance,
                             length - t.start));
    return false;
  }
  if (t.duration) {
    const double most = t.acceleration.value_or(e.reference.acceleration);
    const double shortest = core::Travel::shortest(t.distance.value_or(length - t.start), most);
    if (*t.duration < shortest) {
      problems.add(key + ".duration",
                   fmt::format("found {}, allowed: at least {:.6g} s with an acceleration of {} m/s^2", *t.duration,
                               shortest, most));
      return false;
    }
  } else if (t.speed.value_or(e.reference.speed) <= 0.0) {
    problems.add(key + ".speed", fmt::format("found {}, with which the robot never arrives, allowed: above 0 m/s",
                                             t.speed.value_or(e.reference.speed)));
    return false;
  }
  return true;
}

/// [[t, x, y], ...] or [[t, x, y, theta], ...].
void read_samples(TomlTable& t, TrajectorySpec& trajectory) {
  const toml::node& found = *t.node("samples");
  const toml::array* const rows = found.as_array();
  for (std::size_t k = 0; rows && k < rows->size(); ++k) {
    const toml::array* const row = (*rows)[k].as_array();
    std::vector<double> cells;
    for (std::size_t c = 0; row && c < row->size(); ++c)
      if (const auto value = (*row)[c].is_number() ? (*row)[c].value<double>() : std::nullopt;
          value && std::abs(*value) <= longest_run)
        cells.push_back(*value);
    const std::size_t columns = trajectory.samples.empty() || !trajectory.headings.empty() ? 4 : 3;
    if (!row || cells.size() != row->size() || (cells.size() != columns && !(k == 0 && cells.size() == 3))) {
      trajectory.samples.clear();
      break;
    }
    trajectory.samples.push_back({cells[0], {cells[1], cells[2]}});
    if (cells.size() == 4) trajectory.headings.push_back(cells[3]);
  }
  if (trajectory.samples.size() >= 2 && trajectory.samples.front().t >= 0.0) return;
  trajectory.samples.clear();
  t.refuse("samples", found, "at least two [t, x, y] or [t, x, y, theta] in s, m and rad, from t = 0 on");
}

}  // namespace

void read_trajectory(TomlTable t, TrajectorySpec& trajectory) {
  if (t.has("samples")) {
    read_samples(t, trajectory);
    return t.finish();
  }
  if (const toml::node* const csv = t.node("csv")) {  // what could be read of it stands in `samples`
    if (!csv->is_string()) t.refuse("csv", *csv, "the name of a file, relative to the experiment's folder");
    return t.finish();
  }
  t.require("path", "the path that the robot drives, { shape = ... }");
  read_path(t.table("path"), trajectory.path, false);
  t.number("t", trajectory.t, between(0.0, longest_run, "s"));
  t.number("start", trajectory.start, between(-longest_curve, longest_curve, "m"));
  t.number("speed", trajectory.speed, between(0.0, 10.0, "m/s"));
  t.number("acceleration", trajectory.acceleration, above(0.0, 100.0, "m/s^2"));
  t.number("distance", trajectory.distance, above(0.0, longest_curve, "m"));
  t.number("duration", trajectory.duration, above(0.0, longest_run, "s"));
  t.number("turn_rate", trajectory.turn_rate, between(-100.0, 100.0, "rad/s"));
  if (t.has("speed") && t.has("duration"))
    t.refuse("duration", *t.node("duration"), "only one of speed and duration, since both set its speed");
  t.finish();
}

bool check_trajectories(const Experiment& e, Problems& problems) {
  const bool own = e.reference.kind == ReferenceSpec::Kind::independent;
  bool good = true;
  for (std::size_t i = 0; i < e.robots.size(); ++i) {
    const std::string key = fmt::format("robot.{}.trajectory", i + 1);
    if (own && !e.robots[i].trajectory) {
      problems.add(key, "missing, allowed: a trajectory for every robot of an independent reference");
      good = false;
    } else if (!own && e.robots[i].trajectory) {
      problems.add(key, "found with a common reference, allowed: with reference.kind = \"independent\"");
      good = false;
    } else if (own) {
      good = check_trajectory(e, i, problems) && good;
    }
  }
  if (e.reference.may_meet && !e.shield.enabled)
    problems.add("reference.may_meet",
                 "found true, allowed: with the shield enabled, since only the shield then keeps robots apart");
  return good;
}

void check_trajectory_speeds(const Experiment& e, Problems& problems) {
  const double k_y = e.controller.k_y;
  for (std::size_t i = 0; i < e.robots.size(); ++i) {
    const core::ReferenceDemand demand = make_trajectory(*e.robots[i].trajectory, e.reference)->demand(k_y);
    const core::CommandLimits c = make_limits(e, i);
    if (demand.v < c.v_max && demand.turning < c.omega_max) continue;
    const std::string key = fmt::format("robot.{}.trajectory", i + 1);
    if (const double rate = std::abs(e.robots[i].trajectory->turn_rate); rate >= c.omega_max) {
      problems.add(key + ".turn_rate", fmt::format("found {}, for which (18g) fails with any couplings; allowed: below "
                                                   "{} rad/s, omega_max, to the left or the right",
                                                   e.robots[i].trajectory->turn_rate, c.omega_max));
      continue;
    }
    const double share = std::max(demand.v / c.v_max, demand.turning / c.omega_max);
    const bool by_samples = !e.robots[i].trajectory->samples.empty();
    problems.add(
        fmt::format("{}.{}", key,
                    by_samples                        ? "samples"
                    : problems.has(key + ".duration") ? "duration"
                                                      : "speed"),
        fmt::format("found a reference of up to {:.6g} m/s, for which {} fails with any couplings; allowed: below "
                    "{:.6g} m/s with v_max {}, omega_max {}, k_y {} and the bends of its path",
                    demand.v, demand.v >= c.v_max ? "(18f)" : "(18g)", demand.v / share, c.v_max, c.omega_max, k_y));
  }
}

double last_arrival(const Experiment& e) {
  double last = 0.0;
  for (const RobotSpec& robot : e.robots) last = std::max(last, make_trajectory(*robot.trajectory, e.reference)->end());
  return last;
}

}  // namespace skein::app

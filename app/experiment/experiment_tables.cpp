#include "app/experiment/experiment_tables.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "app/experiment/experiment_events.h"
#include "app/experiment/experiment_reference.h"
#include "app/experiment/experiment_robots.h"
#include "vision/sources/open_source.h"

namespace skein::app {
namespace {

// Limits that only a slip of the keyboard exceeds.
constexpr double longest = 100.0;      // [m]
constexpr double longest_run = 86400;  // a day [s]

void read_run(TomlTable& t, Experiment& e) {
  constexpr std::size_t longest_name = 100;
  t.line("name", e.name, longest_name);
  t.number("duration", e.duration, above(0.0, longest_run, "s"));
  t.number("rate", e.rate, between(1.0, 1000.0, "Hz"));
  t.integer("seed", e.seed, 0, std::numeric_limits<std::int64_t>::max());
  std::string robots_file;  // embed_known_robots() has put its robots in; what is still there is no text
  t.text("robots_file", robots_file);
}

void read_arena(TomlTable t, Experiment& e) {
  t.number("width", e.arena_width, between(0.1, longest, "m"));
  t.number("height", e.arena_height, between(0.1, longest, "m"));
  t.finish();
}

/// One number for all pairs, or [[i, j, value], ...] with 0 for the pairs not listed.
void read_gain(TomlTable& t, const char* key, core::PairTable& gain, const Range& range, Problems& problems) {
  const toml::node* const found = t.node(key);
  if (!found) return;
  if (!found->is_array()) {
    double value = 0.0;
    t.number(key, value, range);
    gain.fill(value);
    return;
  }
  gain.fill(0.0);
  const auto robots = static_cast<std::int64_t>(gain.robots());
  core::PairTable listed(gain.robots());
  std::size_t entry = 0;
  for (const toml::node& element : *found->as_array()) {
    const std::string name = fmt::format("{}.{}", t.full(key), ++entry);
    const toml::array* const triple = element.as_array();
    const bool whole = triple && triple->size() == 3;
    const auto i = whole ? (*triple)[0].value_exact<std::int64_t>() : std::nullopt;
    const auto j = whole ? (*triple)[1].value_exact<std::int64_t>() : std::nullopt;
    const auto value = whole && (*triple)[2].is_number() ? (*triple)[2].value<double>() : std::nullopt;
    const auto exists = [&](const std::optional<std::int64_t>& robot) {
      return robot && *robot >= 1 && *robot <= robots;
    };
    if (!exists(i) || !exists(j) || *i == *j || !value || !range.holds(*value)) {
      const std::string parts =
          whole ? fmt::format("[{}, {}, {}]", shown((*triple)[0]), shown((*triple)[1]), shown((*triple)[2]))
                : shown(element);
      problems.add(element.source(),
                   fmt::format("{}: found {}, allowed: [i, j, value] with two different robots from 1 "
                               "to {} and {}",
                               name, parts, robots, range.text()));
      continue;
    }
    const auto a = static_cast<std::size_t>(*i - 1), b = static_cast<std::size_t>(*j - 1);
    if (listed(a, b) != 0.0)
      problems.add(element.source(), fmt::format("{}: found the pair {}, {} again, allowed: every pair once, since "
                                                 "(18c) makes i, j and j, i the same",
                                                 name, *i, *j));
    listed.set(a, b, 1.0);
    gain.set(a, b, *value);
  }
}

/// A parameter of the couplings: its key, and the numbers that it may have (18b).
struct PairKey {
  core::GainName name;
  const char* key;
  Range range;
};
constexpr PairKey pair_keys[] = {{core::GainName::k_xx, "k_xx", between(0.0, 100.0)},
                                 {core::GainName::k_tt, "k_tt", between(0.0, 100.0)},
                                 {core::GainName::k_yy, "k_yy", between(0.0, 100.0)},
                                 {core::GainName::c_xx, "c_xx", between(0.0, 1e4, "1/m")},
                                 {core::GainName::c_tt, "c_tt", between(0.0, 1e4, "1/rad")},
                                 {core::GainName::c_yy, "c_yy", between(0.0, 1e4, "1/m")},
                                 {core::GainName::l_xx, "l_xx", between(0.0, 1e6, "1/m^2")},
                                 {core::GainName::l_tt, "l_tt", between(0.0, 1e6, "1/rad^2")}};

/// The tracking gains, where they are not what (18f, g) leaves.
void read_policy(TomlTable& t, ControllerSpec& c) {
  t.choice("policy", c.policy);
  const bool fixed = c.policy == core::GainPolicy::fixed;
  for (const auto& [key, target] : {std::pair{"k_x", &c.k_x}, std::pair{"k_theta", &c.k_theta}}) {
    if (fixed) t.require(key, "the tracking gain, above 0 and at most what (18f, g) leave");
    if (!fixed && t.has(key))
      t.refuse(key, *t.node(key), "with policy = \"fixed\"; else it is what (18f, g) leave, as in (36)");
    t.number(key, *target, above(0.0, 100.0));  // (18a)
  }
}

void read_controller(TomlTable t, ControllerSpec& c, Problems& problems) {
  t.choice("saturation", c.saturation);
  t.choice("coupling", c.coupling);
  t.number("v_max", c.v_max, above(0.0, 10.0, "m/s"));
  t.number("omega_max", c.omega_max, above(0.0, 100.0, "rad/s"));
  t.number("c_x", c.c_x, above(0.0, 1e4, "1/m"));  // (18a)
  t.number("c_theta", c.c_theta, above(0.0, 1e4, "1/rad"));
  t.number("k_y", c.k_y, above(0.0, 1e4, "rad/m"));
  t.number("k", c.k, above(0.0, 1e6, "1/m"));
  read_policy(t, c);
  TomlTable gains = t.table("gains");
  for (const auto& [name, key, range] : pair_keys)
    read_gain(name <= core::gain_names.back() ? gains : t, key, core::table(c.gains, name), range, problems);
  gains.finish();
  t.finish();
}

void read_gain_changes(TomlTable& document, Experiment& e, Problems& problems) {
  for (TomlTable& t : document.tables("gain_change")) {
    GainChange change;
    t.require("t", "the time in s at which the gains begin to move");
    t.number("t", change.t, between(0.0, longest_run, "s"));
    t.number("ramp", change.ramp, above(0.0, longest_run, "s"));  // Theorem 1 wants gains that are continuous
    bool any = false;
    for (const auto& [name, key, range] : pair_keys) {
      core::PairTable value(e.robots.size());
      read_gain(t, key, value, range, problems);
      if (t.has(key)) change[name] = value, any = true;
    }
    if (!any) t.require("k_xx", "at least one of k_xx, k_tt, k_yy, c_xx, c_tt, c_yy, l_xx, l_tt");
    t.finish();
    e.gain_changes.push_back(std::move(change));
  }
}

void read_avoidance(TomlTable t, core::AvoidanceParameters& a) {
  t.flag("enabled", a.enabled);
  t.number("alpha", a.alpha, above(0.0, longest, "m"));
  t.number("beta", a.beta, above(0.0, longest, "m"));
  t.integer("p", a.p, 1, 50);
  t.number("K_a", a.K_a, between(0.0, 1e3, "1/s"));
  t.number("K_o", a.K_o, between(0.0, 1e3, "m^2/s"));
  t.number("horizon", a.horizon, between(0.0, 60.0, "s"));
  t.finish();
}

void read_shield(TomlTable t, Experiment& e) {
  t.flag("enabled", e.shield.enabled);
  t.number("distance", e.shield.distance, between(2.0 * core::robot_radius, longest, "m"));
  t.number("gamma", e.shield.gamma, above(0.0, e.rate, "1/s"));  // more would close the whole gap in one tick
  t.finish();
}

void read_obstacles(TomlTable& document, Experiment& e) {
  for (TomlTable& t : document.tables("obstacle")) {
    core::Obstacle obstacle;
    for (const char* key : {"x", "y", "radius"}) t.require(key, "its place and size in m");
    t.number("x", obstacle.x, between(-0.5 * e.arena_width, 0.5 * e.arena_width, "m"));
    t.number("y", obstacle.y, between(-0.5 * e.arena_height, 0.5 * e.arena_height, "m"));
    t.number("radius", obstacle.radius, above(0.0, longest, "m"));
    t.finish();
    e.obstacles.push_back(obstacle);
  }
}

void read_camera(TomlTable t, CameraSpec& camera, Problems& problems) {
  t.text("source", camera.source);
  if (!camera_kind(camera.source))
    problems.add(t.full("source"),
                 fmt::format(R"(found "{}", allowed: "none", "synthetic", {})", camera.source, vision::source_forms()));
  t.text("calibration", camera.calibration);
  t.number("exposure", camera.exposure, between(0.0, 10.0, "s"));
  t.number("gain", camera.gain, between(0.0, 1e6));
  t.number("focus", camera.focus, between(0.0, 1e6));
  t.finish();
}

void read_links(TomlTable t, Experiment& e) {
  t.number("reply_timeout", e.links.reply_timeout, between(0.02, 10.0, "s"));
  t.number("command_silence", e.links.command_silence, above(1.0 / e.rate, 10.0, "s, longer than a tick"));
  t.finish();
}

void read_estimation(TomlTable t, EstimationSpec& estimation) {
  t.number("bridge", estimation.bridge, above(0.0, 10.0, "s"));
  t.number("actuation_delay", estimation.actuation_delay, between(0.0, 1.0, "s"));
  t.number("slip", estimation.filter.slip, between(0.0, 1.0));
  t.number("kidnap", estimation.filter.kidnap, above(0.0, 10.0, "m"));
  t.finish();
}

void read_staging(TomlTable t, StagingSpec& staging) {
  t.flag("automatic", staging.automatic);
  t.number("within", staging.within, between(0.02, longest, "m"));
  t.number("timeout", staging.timeout, above(0.0, longest_run, "s"));
  t.flag("back", staging.back);
  t.finish();
}

void read_simulation(TomlTable t, Experiment& e) {
  constexpr double in_flight = 62.0;  // measurements that a simulated robot can have on their way
  t.number("pose_noise", e.simulation.pose_noise, between(0.0, 1.0, "m"));
  t.number("heading_noise", e.simulation.heading_noise, between(0.0, 4.0, "rad"));
  t.number("latency", e.simulation.latency, between(0.0, in_flight / e.rate, "s"));
  t.number("dropout", e.simulation.dropout, between(0.0, 1.0));
  t.number("slip", e.simulation.slip, between(0.0, 1.0));
  t.finish();
}

void read_failure(TomlTable t, FailureSpec& failure) {
  using LinkLost = FailureSpec::LinkLost;
  t.choice("link_lost", failure.link_lost);
  t.number("link_bridge", failure.link_bridge, between(0.05, 10.0, "s"));
  t.finish();
}

void read_expectations(TomlTable t, Expectations& expect) {
  t.number("final_error", expect.final_error, between(0.0, longest, "m"));
  t.number("min_distance", expect.min_distance, between(0.0, longest, "m"));
  t.number("arrived", expect.arrived, between(0.0, longest_run, "s"));
  t.flag("formation_first", expect.formation_first);
  t.integer("collisions", expect.collisions, 0, 1000000);
  t.finish();
}

}  // namespace

core::CouplingGains paper_couplings(std::size_t robots) {
  const core::Gains paper = core::paper_gains(robots);
  return {paper.k_xx, paper.k_tt, paper.k_yy, paper.c_xx, paper.c_tt, paper.c_yy, paper.l_xx, paper.l_tt};
}

void read_tables(const toml::table& document, Experiment& e, Problems& problems) {
  TomlTable t(&document, "", problems);
  read_run(t, e);
  read_arena(t.table("arena"), e);
  read_robots(t, e, problems);  // before everything that is said of robots
  read_reference(t.table("reference"), e, problems);
  e.controller.gains = paper_couplings(e.robots.size());
  read_controller(t.table("controller"), e.controller, problems);
  read_gain_changes(t, e, problems);
  read_avoidance(t.table("avoidance"), e.avoidance);
  read_shield(t.table("shield"), e);
  read_obstacles(t, e);
  read_camera(t.table("camera"), e.camera, problems);
  read_links(t.table("links"), e);
  read_failure(t.table("failure"), e.failure);
  read_simulation(t.table("simulation"), e);
  read_estimation(t.table("estimation"), e.estimation);
  read_staging(t.table("staging"), e.staging);
  read_events(t, e);
  read_expectations(t.table("expect"), e.expect);
  t.finish();
}

}  // namespace skein::app

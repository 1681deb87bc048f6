#include "app/experiment/experiment_keys.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "app/experiment/longest.h"
#include "core/words.h"

namespace skein::app {
namespace {

using E = Experiment;
using Limits = const Experiment&;

// Limits that only a slip of the keyboard exceeds.
constexpr std::size_t longest_name = 100;
constexpr std::size_t longest_command = 4000;
constexpr double in_flight = 62.0;  // measurements that a simulated robot can have on their way [ticks]

/// A key with a word of an enumeration; `at` is a function without captures.
template <auto at>
ChoiceKey choice() {
  using Enum = std::remove_reference_t<decltype(at(std::declval<Experiment&>()))>;
  return {[](TomlTable& t, const char* key, Experiment& e) { t.choice(key, at(e)); },
          [](const Experiment& e) { return word(at(const_cast<Experiment&>(e))); },
          [] {
            std::vector<std::string_view> words;
            for (const Enum value : core::all_of<Enum>()) words.push_back(word(value));
            return words;
          }};
}

/// A key with a whole number of any type.
template <auto at>
WholeKey whole(std::int64_t low, std::int64_t high) {
  return {
      [](const Experiment& e) { return static_cast<std::int64_t>(at(const_cast<Experiment&>(e))); },
      [](Experiment& e, std::int64_t value) { at(e) = static_cast<std::remove_reference_t<decltype(at(e))>>(value); },
      low, high};
}

const std::vector<ExperimentKey>& all_keys() {
  static const std::vector<ExperimentKey> keys{
      // clang-format off: a row for each key
      {"", "name", "shown in the CSV, the report and the window",
       TextKey{[](E& e) -> auto& { return e.name; }, longest_name}},
      {"", "duration", "how long the experiment lasts",
       NumberKey{[](E& e) -> auto& { return e.duration; }, [](Limits) { return above(0.0, longest_run, "s"); }}},
      {"", "rate", "ticks of the control loop per second",
       NumberKey{[](E& e) -> auto& { return e.rate; }, [](Limits) { return between(1.0, 1000.0, "Hz"); }}},
      {"", "seed", "of all random numbers in a simulation: the same seed gives the same run",
       whole<[](E& e) -> auto& { return e.seed; }>(0, std::numeric_limits<std::int64_t>::max())},

      {"arena", "width", "along x",
       NumberKey{[](E& e) -> auto& { return e.arena_width; },
                 [](Limits) { return between(0.1, longest_length, "m"); }}},
      {"arena", "height", "along y",
       NumberKey{[](E& e) -> auto& { return e.arena_height; },
                 [](Limits) { return between(0.1, longest_length, "m"); }}},

      {"reference", "kind", "all robots on one path, a shape about a centre, or a trajectory for each robot",
       choice<[](E& e) -> auto& { return e.reference.kind; }>()},
      {"reference", "speed", "along the path, of every robot or of the centre",
       NumberKey{[](E& e) -> auto& { return e.reference.speed; }, [](Limits) { return between(0.0, 10.0, "m/s"); }}},

      {"controller", "saturation", "the function (11) that bounds every term of the law",
       choice<[](E& e) -> auto& { return e.controller.saturation; }>()},
      {"controller", "coupling", "the couplings of x and heading errors: as printed, or bounded by their gains",
       choice<[](E& e) -> auto& { return e.controller.coupling; }>()},
      {"controller", "v_max", "(14)",
       NumberKey{[](E& e) -> auto& { return e.controller.v_max; }, [](Limits) { return above(0.0, 10.0, "m/s"); }}},
      {"controller", "omega_max", "(14)",
       NumberKey{[](E& e) -> auto& { return e.controller.omega_max; },
                 [](Limits) { return above(0.0, 100.0, "rad/s"); }}},
      // (18a), and so the next three
      {"controller", "c_x", "slope of the x tracking term",
       NumberKey{[](E& e) -> auto& { return e.controller.c_x; }, [](Limits) { return above(0.0, 1e4, "1/m"); }}},
      {"controller", "c_theta", "slope of the heading tracking term",
       NumberKey{[](E& e) -> auto& { return e.controller.c_theta; }, [](Limits) { return above(0.0, 1e4, "1/rad"); }}},
      {"controller", "k_y", "weight of the lateral error",
       NumberKey{[](E& e) -> auto& { return e.controller.k_y; }, [](Limits) { return above(0.0, 1e4, "rad/m"); }}},
      {"controller", "k", "in the normaliser of the lateral term",
       NumberKey{[](E& e) -> auto& { return e.controller.k; }, [](Limits) { return above(0.0, 1e6, "1/m"); }}},
      {"controller", "kind", "the law: the paper's, or another built-in one",
       choice<[](E& e) -> auto& { return e.controller.law.kind; }>()},
      {"controller", "command", "your own program that drives instead, quoted as for a shell",
       TextKey{[](E& e) -> auto& { return e.controller.law.command; }, longest_command}},
      {"controller", "library", "your own shared library that drives instead, path relative to the file",
       TextKey{[](E& e) -> auto& { return e.controller.law.library; }, longest_command}},
      {"controller", "failure",
       "what drives when your own controller gives no answer: nothing (robots stop), or the law kind",
       choice<[](E& e) -> auto& { return e.controller.law.failure; }>()},
      {"controller", "deadline", "how long it may take for a tick, on the wall clock",
       OptionalNumberKey{[](E& e) -> auto& { return e.controller.law.deadline; },
                         [](Limits e) { return between(0.0001, 0.5 * e.period(), "s"); }}},
      {"controller", "memory", "address space of each of its processes, in megabytes",
       whole<[](E& e) -> auto& { return e.controller.law.memory; }>(16, 1048576)},
      {"controller", "processes", "processes and threads that it may start itself",
       whole<[](E& e) -> auto& { return e.controller.law.processes; }>(0, 4096)},
      {"controller", "preview", "a second process of it may be started, for previews in the window",
       FlagKey{[](E& e) -> auto& { return e.controller.law.preview; }}},

      {"avoidance", "kind", "field: the paper's, with detours for stuck robots; plan: planned routes",
       choice<[](E& e) -> auto& { return e.avoidance.kind; }>()},
      {"avoidance", "enabled", "robots avoid one another and obstacles",
       FlagKey{[](E& e) -> auto& { return e.avoidance.enabled; }}},
      {"avoidance", "alpha", "half width of the detection region along x",
       NumberKey{[](E& e) -> auto& { return e.avoidance.alpha; },
                 [](Limits) { return above(0.0, longest_length, "m"); }}},
      {"avoidance", "beta", "half width of the detection region along y",
       NumberKey{[](E& e) -> auto& { return e.avoidance.beta; },
                 [](Limits) { return above(0.0, longest_length, "m"); }}},
      {"avoidance", "p", "shape of the region: 2 an ellipse, larger more like a rectangle",
       whole<[](E& e) -> auto& { return e.avoidance.p; }>(1, 50)},
      {"avoidance", "K_a", "attraction to the reference",
       NumberKey{[](E& e) -> auto& { return e.avoidance.K_a; }, [](Limits) { return between(0.0, 1e3, "1/s"); }}},
      {"avoidance", "K_o", "repulsion",
       NumberKey{[](E& e) -> auto& { return e.avoidance.K_o; }, [](Limits) { return between(0.0, 1e3, "m^2/s"); }}},
      {"avoidance", "horizon", "above 0: look this far ahead and drive round others early, instead of using the field",
       NumberKey{[](E& e) -> auto& { return e.avoidance.horizon; }, [](Limits) { return between(0.0, 60.0, "s"); }}},
      {"avoidance", "formation_waits", "plan: the formation slows down while one of its robots is on its way back",
       FlagKey{[](E& e) -> auto& { return e.avoidance.formation_waits; }}},
      {"avoidance", "improve", "plan: better routes are searched for while robots drive; false: each keeps its first",
       FlagKey{[](E& e) -> auto& { return e.avoidance.improve; }}},

      {"shield", "enabled", "forward speeds are changed so that no two robots come too close",
       FlagKey{[](E& e) -> auto& { return e.shield.enabled; }}},
      {"shield", "distance", "midpoints are kept this far apart",
       NumberKey{[](E& e) -> auto& { return e.shield.distance; },
                 [](Limits) { return between(2.0 * core::standard_radius, longest_length, "m"); }}},
      {"shield", "gamma", "how fast a gap may close, as a share of the remaining gap",
       NumberKey{[](E& e) -> auto& { return e.shield.gamma; },
                 [](Limits e) { return above(0.0, e.rate, "1/s"); }}},  // more would close the whole gap in one tick

      {"camera", "source",
       "where poses come from: none, synthetic, v4l2:DEVICE, aravis:CAMERA, video:FILE or images:DIR",
       TextKey{[](E& e) -> auto& { return e.camera.source; }, 0}},
      {"camera", "calibration", "the file written by skein calibrate, relative to the experiment's folder",
       TextKey{[](E& e) -> auto& { return e.camera.calibration; }, 0}},
      {"camera", "exposure", "exposure time of a real camera; 0: automatic",
       NumberKey{[](E& e) -> auto& { return e.camera.exposure; }, [](Limits) { return between(0.0, 10.0, "s"); }}},
      {"camera", "gain", "in the units of the camera's driver",
       NumberKey{[](E& e) -> auto& { return e.camera.gain; }, [](Limits) { return between(0.0, 1e6); }}},
      {"camera", "focus", "in the units of the camera's driver",
       NumberKey{[](E& e) -> auto& { return e.camera.focus; }, [](Limits) { return between(0.0, 1e6); }}},
      {"camera", "trigger", "of an aravis camera: software, or one of its lines; empty: free running",
       TextKey{[](E& e) -> auto& { return e.camera.trigger; }, 100, 0}},
      {"camera", "latency", "how long before its stamp a frame was captured (skein camera latency)",
       NumberKey{[](E& e) -> auto& { return e.camera.latency; }, [](Limits) { return between(-0.1, 0.5, "s"); }}},
      {"camera", "film", "how a run's film (--video) stores the pixels: lossless, or in a tenth of the space",
       choice<[](E& e) -> auto& { return e.camera.film; }>()},

      {"camera", "bump_at", "for practice: when the synthetic camera is bumped, counted from its opening",
       OptionalNumberKey{[](E& e) -> auto& { return e.camera.bump_at; },
                         [](Limits) { return between(0.0, longest_run, "s"); }}},
      {"camera", "bump", "for practice: the angle by which it is then tilted",
       NumberKey{[](E& e) -> auto& { return e.camera.bump; }, [](Limits) { return between(-45.0, 45.0, "deg"); }}},
      {"camera", "raise", "for practice: how much higher it then hangs",
       NumberKey{[](E& e) -> auto& { return e.camera.raise; }, [](Limits) { return between(-1.0, 1.0, "m"); }}},
      {"camera", "bump_time", "for practice: how long that takes, like a mount that sags; 0: at once",
       NumberKey{[](E& e) -> auto& { return e.camera.bump_time; },
                 [](Limits) { return between(0.0, longest_run, "s"); }}},
      {"camera", "defocus_at",
       "for practice: when the synthetic camera's lens begins to lose its focus, counted from its opening",
       OptionalNumberKey{[](E& e) -> auto& { return e.camera.defocus_at; },
                         [](Limits) { return between(0.0, longest_run, "s"); }}},
      {"camera", "defocus", "for practice: how much it then blurs, as a standard deviation",
       NumberKey{[](E& e) -> auto& { return e.camera.defocus; }, [](Limits) { return between(0.7, 20.0, "px"); }}},
      {"camera", "defocus_time", "for practice: how long that takes, like a lens that warms up; 0: at once",
       NumberKey{[](E& e) -> auto& { return e.camera.defocus_time; },
                 [](Limits) { return between(0.0, longest_run, "s"); }}},
      {"camera", "mark_moved_at",
       "for practice: when the first mark on the floor is moved by 50 mm, counted from the camera's opening",
       OptionalNumberKey{[](E& e) -> auto& { return e.camera.mark_moved_at; },
                         [](Limits) { return between(0.0, longest_run, "s"); }}},
      {"camera", "lost_at", "for practice: when the synthetic camera is lost, counted from its opening",
       OptionalNumberKey{[](E& e) -> auto& { return e.camera.lost_at; },
                         [](Limits) { return between(0.0, longest_run, "s"); }}},
      {"camera", "freeze_at",
       "for practice: when the synthetic camera begins to deliver one picture again and again, counted from its "
       "opening",
       OptionalNumberKey{[](E& e) -> auto& { return e.camera.freeze_at; },
                         [](Limits) { return between(0.0, longest_run, "s"); }}},
      {"camera", "freeze_for", "for practice: for how long it does so",
       OptionalNumberKey{[](E& e) -> auto& { return e.camera.freeze_for; },
                         [](Limits) { return between(0.0, longest_run, "s"); }}},
      {"camera", "freeze_part",
       "for practice: how much of the picture it repeats then, as a part of its height from below",
       NumberKey{[](E& e) -> auto& { return e.camera.freeze_part; }, [](Limits) { return between(0.01, 1.0); }}},
      {"camera", "stamps_late", "for practice: how late the synthetic camera's time stamps are, which latency corrects",
       NumberKey{[](E& e) -> auto& { return e.camera.stamps_late; }, [](Limits) { return between(0.0, 3.0, "s"); }}},

      {"tags", "size", "edge of the robots' tags (the black square), in place of the calibration's",
       OptionalNumberKey{[](E& e) -> auto& { return e.tag_size; }, [](Limits) { return between(1e-3, 10.0, "m"); }}},

      {"links", "blind_distance", "how far a robot may drive on unconfirmed commands",
       NumberKey{[](E& e) -> auto& { return e.links.blind_distance; },
                 [](Limits) { return between(0.005, 1.0, "m"); }}},
      {"links", "reply_timeout", "a reply later than this is lost, and the robot is stopped until it answers",
       NumberKey{[](E& e) -> auto& { return e.links.reply_timeout; }, [](Limits) { return between(0.02, 10.0, "s"); }}},
      {"links", "command_silence", "a link that gets no command for this long stops its robot by itself",
       OptionalNumberKey{[](E& e) -> auto& { return e.links.command_silence; },
                         [](Limits e) { return above(1.0 / e.rate, 10.0, "s, longer than a tick"); }}},

      {"failure", "link_lost", "what the group does when a robot's link is lost",
       choice<[](E& e) -> auto& { return e.failure.link_lost; }>()},
      {"failure", "camera_moved", "what the group does when the camera was bumped, or its pictures are late",
       choice<[](E& e) -> auto& { return e.failure.camera_moved; }>()},
      {"failure", "runaway", "what the group does when a robot does not drive as commanded",
       choice<[](E& e) -> auto& { return e.failure.runaway; }>()},
      {"failure", "link_bridge", "a link that has not been up for longer than this is lost",
       NumberKey{[](E& e) -> auto& { return e.failure.link_bridge; }, [](Limits) { return between(0.05, 10.0, "s"); }}},

      {"simulation", "pose_noise", "standard deviation of a measured x, and of y",
       NumberKey{[](E& e) -> auto& { return e.simulation.pose_noise; }, [](Limits) { return between(0.0, 1.0, "m"); }}},
      {"simulation", "heading_noise", "standard deviation of a measured heading",
       NumberKey{[](E& e) -> auto& { return e.simulation.heading_noise; },
                 [](Limits) { return between(0.0, 4.0, "rad"); }}},
      {"simulation", "latency", "age of a pose when it arrives",
       NumberKey{[](E& e) -> auto& { return e.simulation.latency; },
                 [](Limits e) { return between(0.0, in_flight / e.rate, "s"); }}},
      {"simulation", "dropout", "share of poses that are lost",
       NumberKey{[](E& e) -> auto& { return e.simulation.dropout; }, [](Limits) { return between(0.0, 1.0); }}},
      {"simulation", "slip", "standard deviation of the distance that a wheel rolls, as a share of it",
       NumberKey{[](E& e) -> auto& { return e.simulation.slip; }, [](Limits) { return between(0.0, 1.0); }}},

      {"estimation", "bridge", "a robot whose pose is older than this is lost, and stops",
       NumberKey{[](E& e) -> auto& { return e.estimation.bridge; }, [](Limits) { return above(0.0, 10.0, "s"); }}},
      {"estimation", "actuation_delay", "from the tick to the moment at which the wheels obey; measured unless given",
       OptionalNumberKey{[](E& e) -> auto& { return e.estimation.actuation_delay; },
                         [](Limits) { return between(0.0, 1.0, "s"); }}},
      {"estimation", "slip", "standard deviation of the distance that a wheel rolls, as a share of it, for the filter",
       NumberKey{[](E& e) -> auto& { return e.estimation.filter.slip; }, [](Limits) { return between(0.0, 1.0); }}},
      {"estimation", "kidnap",
       "a pose this much farther away than the robot can have driven means that it was moved by hand",
       NumberKey{[](E& e) -> auto& { return e.estimation.filter.kidnap; },
                 [](Limits) { return above(0.0, 10.0, "m"); }}},

      {"staging", "automatic", "skein run drives the robots to their starts by itself",
       FlagKey{[](E& e) -> auto& { return e.staging.automatic; }}},
      {"staging", "within", "a robot this close to its start counts as there",
       NumberKey{[](E& e) -> auto& { return e.staging.within; },
                 [](Limits) { return between(0.02, longest_length, "m"); }}},
      {"staging", "timeout", "the run fails if a robot has not arrived by then",
       NumberKey{[](E& e) -> auto& { return e.staging.timeout; }, [](Limits) { return above(0.0, longest_run, "s"); }}},
      {"staging", "back", "after the run the robots drive back to their starts",
       FlagKey{[](E& e) -> auto& { return e.staging.back; }}},

      {"expect", "final_error", "largest distance of a robot from its place in the formation at the end",
       OptionalNumberKey{[](E& e) -> auto& { return e.expect.final_error; },
                         [](Limits) { return between(0.0, longest_length, "m"); }}},
      {"expect", "min_distance", "no two robots' midpoints ever come closer than this",
       OptionalNumberKey{[](E& e) -> auto& { return e.expect.min_distance; },
                         [](Limits) { return between(0.0, longest_length, "m"); }}},
      {"expect", "arrived", "from this time on all references rest and no robot is farther than 1 cm from its place",
       OptionalNumberKey{[](E& e) -> auto& { return e.expect.arrived; },
                         [](Limits) { return between(0.0, longest_run, "s"); }}},
      {"expect", "formation_first", "after every perturbation the formation settles before the tracking does",
       OptionalFlagKey{[](E& e) -> auto& { return e.expect.formation_first; }}},
      {"expect", "inside", "true: no body is ever over the edge of the arena",
       OptionalFlagKey{[](E& e) -> auto& { return e.expect.inside; }}},
      {"expect", "collisions", "two robots, or a robot and an obstacle, touch at most this many times",
       OptionalWholeKey{[](E& e) -> auto& { return e.expect.collisions; }, 0, 1000000}},
      // clang-format on
  };
  return keys;
}

std::string shown_number(double value) {
  return std::isnan(value) ? std::string() : fmt::format("{}", value);
}

/// Where a value of an experiment that is only looked at stands.
template <typename Key>
const auto& value_of(const Key& key, const Experiment& e) {
  return key.at(const_cast<Experiment&>(e));  // the functions say where it is, and change nothing
}

}  // namespace

std::string ExperimentKey::name() const {
  return *table ? fmt::format("{}.{}", table, key) : key;
}

std::span<const ExperimentKey> experiment_keys() {
  return all_keys();
}

const ExperimentKey* find_experiment_key(std::string_view name) {
  const auto found =
      std::find_if(all_keys().begin(), all_keys().end(), [&](const ExperimentKey& k) { return k.name() == name; });
  return found == all_keys().end() ? nullptr : &*found;
}

void read_keys(TomlTable& t, std::string_view table, Experiment& e) {
  // Where the file's rate is no rate, whatever one of those that are allowed would admit.
  const auto range_of = [&, rate_known = t.sound("rate")](const auto& key) {
    Range range = key.range(e);
    for (const double rate : {1.0, 1000.0}) {
      if (rate_known) break;
      Experiment other;
      other.rate = rate;
      const Range there = key.range(other);
      range.low = std::min(range.low, there.low);
      range.high = std::max(range.high, there.high);
    }
    return range;
  };
  for (const ExperimentKey& key : all_keys()) {
    if (key.table != table) continue;
    const char* const name = key.key;
    std::visit(Overloaded{
                   [&](const one_of<NumberKey, OptionalNumberKey> auto& k) { t.number(name, k.at(e), range_of(k)); },
                   [&](const WholeKey& k) {
                     std::int64_t value = k.get(e);
                     t.integer(name, value, k.low, k.high);
                     k.set(e, value);
                   },
                   [&](const OptionalWholeKey& k) { t.integer(name, k.at(e), k.low, k.high); },
                   [&](const one_of<FlagKey, OptionalFlagKey> auto& k) { t.flag(name, k.at(e)); },
                   [&](const TextKey& k) {
                     if (k.longest > 0)
                       t.line(name, k.at(e), k.longest, k.shortest);
                     else
                       t.text(name, k.at(e));
                   },
                   [&](const ChoiceKey& k) { k.read(t, name, e); },
               },
               key.value);
  }
}

std::string shown_value(const ExperimentKey& key, const Experiment& e) {
  const auto flag = [](bool on) { return std::string(on ? "true" : "false"); };
  return std::visit(Overloaded{
                        [&](const NumberKey& k) { return shown_number(value_of(k, e)); },
                        [&](const OptionalNumberKey& k) {
                          const auto& value = value_of(k, e);
                          return value ? shown_number(*value) : std::string();
                        },
                        [&](const WholeKey& k) { return fmt::format("{}", k.get(e)); },
                        [&](const OptionalWholeKey& k) {
                          const auto& value = value_of(k, e);
                          return value ? fmt::format("{}", *value) : std::string();
                        },
                        [&](const FlagKey& k) { return flag(value_of(k, e)); },
                        [&](const OptionalFlagKey& k) {
                          const auto& value = value_of(k, e);
                          return value ? flag(*value) : std::string();
                        },
                        [&](const TextKey& k) { return value_of(k, e); },
                        [&](const ChoiceKey& k) { return std::string(k.get(e)); },
                    },
                    key.value);
}

std::string allowed_values(const ExperimentKey& key, const Experiment& e) {
  return std::visit(Overloaded{
                        [&](const one_of<NumberKey, OptionalNumberKey> auto& k) { return k.range(e).text(); },
                        [](const one_of<WholeKey, OptionalWholeKey> auto& k) {
                          return fmt::format("a whole number from {} to {}", k.low, k.high);
                        },
                        [](const one_of<FlagKey, OptionalFlagKey> auto&) { return std::string("true or false"); },
                        [](const TextKey&) { return std::string("a text"); },
                        [](const ChoiceKey& k) {
                          std::string words;
                          for (const std::string_view each : k.words())
                            words += (words.empty() ? "\"" : ", \"") + std::string(each) + '"';
                          return words;
                        },
                    },
                    key.value);
}

std::string unit_of(const ExperimentKey& key) {
  const auto text = [](const Range& range) {
    const std::string unit = range.unit;
    return unit.substr(0, unit.find(','));
  };
  return std::visit(
      Overloaded{
          [&](const one_of<NumberKey, OptionalNumberKey> auto& k) { return text(k.range(Experiment{})); },
          [](const one_of<WholeKey, OptionalWholeKey, FlagKey, OptionalFlagKey, TextKey, ChoiceKey> auto&) {
            return std::string();
          },
      },
      key.value);
}

}  // namespace skein::app

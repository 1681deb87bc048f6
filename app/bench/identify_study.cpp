#include "app/bench/identify_study.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "app/experiment/experiment_file.h"
#include "app/run/exit_status.h"
#include "app/run/interrupted.h"
#include "app/run/output.h"
#include "app/run/resources.h"
#include "core/controllers/independent.h"
#include "core/estimation/identification.h"
#include "core/estimation/statistics.h"
#include "core/kinematics/step_rate.h"
#include "core/kinematics/unicycle.h"
#include "core/math/elementary.h"
#include "core/safety/limits.h"
#include "core/simulation/individual_robot.h"
#include "core/words.h"

namespace skein::app {
namespace {

using core::Individual;
using core::Unknown;

constexpr double frame_period = 0.04;
constexpr unsigned umbmark_drives = 4;
constexpr core::MotorModel stepper = core::MotorModel::epuck2;

/// The command to a robot at time t; `seen` is where it was seen last.
struct Manoeuvre {
  std::string name;
  double seconds = 0.0;
  core::Pose start;
  std::function<core::Twist(double t, const core::Pose& seen)> twist;
  std::optional<double> squares;  ///< the length of UMBmark's two squares together, if it is UMBmark [m]
};

/// Robot 1 of an experiment, which follows its reference as its file says, without the others.
std::optional<Manoeuvre> follow(const std::string& file) {
  auto experiment = load_experiment(find_resource("experiments", file));
  if (!experiment) {
    complain(experiment.error().front().message());
    return {};
  }
  const std::shared_ptr<const core::Reference> reference = make_reference(*experiment);
  const core::Gains gains = make_gains(*experiment);
  const core::CommandLimits limits{gains.v_max[0], gains.omega_max[0], experiment->robots[0].drive};
  return Manoeuvre{
      file,
      experiment->duration,
      reference->at(0, 0.0).pose,
      [reference, gains, limits](double t, const core::Pose& seen) {
        const core::ReferencePoint point = reference->at(0, t);
        return limits.limit(core::track_alone(gains, 0, core::tracking_error(point.pose, seen), point.twist));
      },
      {}};
}

/// UMBmark: a square to the left, one to the right, with turns on the spot; blindly, as it is driven. As far as another
/// manoeuvre comes, and in the same time.
Manoeuvre umbmark(double way, double seconds) {
  constexpr double turning = 1.0;  // [rad/s]
  const double turn = 0.5 * core::pi / turning, straight = seconds / 8.0 - turn, speed = way / (8.0 * straight);
  return {"umbmark",
          8.0 * (straight + turn),
          {},
          [=](double t, const core::Pose&) {
            const int leg = static_cast<int>(t / (straight + turn));
            if (leg >= 8) return core::Twist{};
            if (t - leg * (straight + turn) < straight) return core::Twist{speed, 0.0};
            return core::Twist{0.0, leg < 4 ? turning : -turning};
          },
          8.0 * speed * straight};
}

/// The end of a path by the wheels' angles alone, relative to its start.
core::Pose odometry(const core::DifferentialDrive& believed, const std::vector<core::WheelKnot>& wheels, double from,
                    double to) {
  core::Pose pose;
  for (std::size_t k = 1; k < wheels.size(); ++k) {
    const core::WheelKnot &a = wheels[k - 1], &b = wheels[k];
    const double begin = std::max(a.t, from), end = std::min(b.t, to);
    if (!(end > begin)) continue;
    const core::Twist twist = believed.twist({(b.left - a.left) / (b.t - a.t), (b.right - a.right) / (b.t - a.t)});
    pose = core::advance(pose, twist, end - begin);
  }
  return pose;
}

/// What UMBmark's own estimator (borenstein1996) makes of the two squares: from where each ends against where odometry
/// has it, how far each turn goes too far (alpha, its error of type A) and by how much each straight leg bends to the
/// left (beta, of type B); from them the track and the wheels' ratio. The mean diameter is not to be had from squares.
core::DifferentialDrive umbmark_estimate(const core::IdentificationInput& input, double way, double seconds) {
  const auto seen_at = [&](double t) {
    const auto next = std::find_if(input.poses.begin(), input.poses.end(),
                                   [&](const core::SeenPose& seen) { return seen.t >= t - 0.5 * frame_period; });
    return next == input.poses.end() ? input.poses.back() : *next;
  };
  // Where a square ended, as seen less as reckoned, in the frame of its start.
  const auto error_of = [&](double from, double to) {
    const core::SeenPose a = seen_at(from), b = seen_at(to);
    const double c = core::math::cos(a.pose.theta), s = core::math::sin(a.pose.theta);
    const double x = b.pose.x - a.pose.x, y = b.pose.y - a.pose.y;
    const core::Pose reckoned = odometry(input.believed, input.wheels, a.t, b.t);
    return core::Pose{c * x + s * y - reckoned.x, -s * x + c * y - reckoned.y, 0.0};
  };
  const double side = way / 8.0, middle = 0.5 * seconds;
  const core::Pose left = error_of(0.0, middle), right = error_of(middle, seconds);
  const double sum = 0.5 * (left.x - left.y) / (2.0 * side);           // alpha + beta
  const double difference = 0.5 * (right.x + right.y) / (2.0 * side);  // alpha - beta
  const double alpha = 0.5 * (sum + difference), beta = 0.5 * (sum - difference);
  core::DifferentialDrive found = input.believed;
  found.track *= 0.5 * core::pi / (0.5 * core::pi + alpha);
  const double radius = 0.5 * side / core::math::sin(0.5 * beta);  // of the bend
  found.wheel_ratio *= (radius + 0.5 * found.track) / (radius - 0.5 * found.track);
  return found;
}

core::IdentificationInput drive(const Manoeuvre& manoeuvre, const Individual& individual, std::uint64_t seed,
                                const core::DifferentialDrive& believed = {}) {
  core::IdentificationInput input;
  input.believed = believed;
  core::IndividualRobot robot(individual, stepper, seed);
  core::WheelLog log(stepper);
  core::WheelSpeeds told;
  robot.place(manoeuvre.start);
  core::Pose seen = manoeuvre.start;
  for (int k = 0; k * frame_period < manoeuvre.seconds; ++k) {
    if (const auto measured = robot.see()) {
      seen = measured->pose;
      input.poses.push_back({measured->captured_at, measured->pose});
    }
    const core::WheelSpeeds speeds = input.believed.wheels(manoeuvre.twist(k * frame_period, seen));
    const core::WheelSpeeds whole{core::nearest_command(stepper, speeds.left),
                                  core::nearest_command(stepper, speeds.right)};
    if (k == 0 || whole != told) {
      robot.command(whole);
      log.command(k * frame_period, whole);
      told = whole;
    }
    robot.step(frame_period);
  }
  input.wheels = std::move(log).finish(manoeuvre.seconds);
  return input;
}

/// How far off it is after a minute of bends to both sides in open loop, if its wheels are believed to be these;
/// without slip, which is random. [m]
double drift(const core::DifferentialDrive& believed, const core::DifferentialDrive& really) {
  constexpr double seconds = 60.0, v = 0.05;
  core::Pose wanted, pose;
  for (int k = 0; k * frame_period < seconds; ++k) {
    const core::Twist twist{v, 0.6 * core::math::sin(2.0 * core::pi * k * frame_period / 20.0)};  // bends to both sides
    wanted = core::advance(wanted, twist, frame_period);
    pose = core::advance(pose, really.twist(believed.wheels(twist)), frame_period);
  }
  return core::math::hypot(pose.x - wanted.x, pose.y - wanted.y);
}

struct Outcome {
  core::Identification found;
  /// By UMBmark's own estimator, which is for small errors: after its squares, and after the last of several, each
  /// driven with what the ones before have found.
  core::DifferentialDrive umbmark, umbmark_again;
  double drift_before = 0.0, drift_after = 0.0;
};

std::vector<Outcome> study(const Manoeuvre& manoeuvre, const IdentifyBench& bench) {
  std::vector<Outcome> outcomes(static_cast<std::size_t>(bench.runs));
  std::atomic<std::size_t> next{0};
  const auto work = [&] {
    for (std::size_t k = next++; k < outcomes.size() && !interrupted(); k = next++) {
      const std::uint64_t seed = bench.seed + k;
      const Individual truth = core::random_individual(seed);
      Outcome& outcome = outcomes[k];
      const core::IdentificationInput input = drive(manoeuvre, truth, seed);
      outcome.found = core::identify(input);
      if (manoeuvre.squares) {
        core::DifferentialDrive& found = outcome.umbmark_again;
        for (unsigned drives = 0; drives < umbmark_drives; ++drives) {
          found.wheel_diameter = truth.wheels.wheel_diameter;  // measured by hand, as UMBmark asks for
          found =
              umbmark_estimate(drive(manoeuvre, truth, seed + drives, found), *manoeuvre.squares, manoeuvre.seconds);
          if (drives == 0) outcome.umbmark = found;
        }
      }
      outcome.found.innovations.clear();
      outcome.drift_before = drift({}, truth.wheels);
      outcome.drift_after = drift(outcome.found.drive({}), truth.wheels);
    }
  };
  std::vector<std::jthread> threads;
  for (unsigned k = 1; k < std::max(1U, std::thread::hardware_concurrency()); ++k) threads.emplace_back(work);
  work();
  threads.clear();
  return outcomes;
}

/// True where all intervals hold as often as they say.
bool print(const Manoeuvre& manoeuvre, const IdentifyBench& bench, const std::vector<Outcome>& outcomes) {
  constexpr double fewest = 0.93, most = 0.97;
  std::vector<double> ways, turns, before, after, shares;
  std::int64_t failed = 0;
  for (const Outcome& o : outcomes) {
    failed += !o.found.converged;
    ways.push_back(o.found.driven), turns.push_back(o.found.turned);
    before.push_back(o.drift_before), after.push_back(o.drift_after);
    shares.push_back(o.drift_before / o.drift_after);
  }
  fmt::print("\nmanoeuvre: {}\nruns: {}\nseconds: {:.1f}\ndriven: {:.2f} m\nturned: {:.1f} rad\nnot_converged: {}\n",
             manoeuvre.name, outcomes.size(), manoeuvre.seconds, core::median(ways), core::median(turns), failed);
  fmt::print("{:<15} {:>9} {:>12} {:>14} {:>7}\n", "parameter", "covered", "half width", "largest", "known");
  bool good = failed == 0;
  const auto row = [&](std::string_view name, const auto& estimate_of, const auto& truth, bool relative) {
    std::int64_t covered = 0, known = 0;
    std::vector<double> widths;
    for (std::size_t k = 0; k < outcomes.size(); ++k) {
      const core::Estimate& e = estimate_of(outcomes[k].found);
      const double real = truth(core::random_individual(bench.seed + k));
      covered += e.low <= real && real <= e.high;
      known += e.known;
      widths.push_back(0.5 * (e.high - e.low) / (relative ? e.value : 1.0));
    }
    const double all = static_cast<double>(outcomes.size()), share = static_cast<double>(covered) / all;
    good = good && share >= fewest && share <= most;
    const double unit = relative ? 100.0 : 1.0, half = unit * core::median(widths);
    const double largest = unit * *std::max_element(widths.begin(), widths.end());
    fmt::print("{:<15} {:>7.1f} % {:>10.3g} {} {:>12.3g} {} {:>5.0f} %\n", name, 100.0 * share, half,
               relative ? '%' : ' ', largest, relative ? '%' : ' ', 100.0 * static_cast<double>(known) / all);
  };
  row(
      "wheel_ratio", [](const auto& found) -> const auto& { return found.wheel_ratio; },
      [](const Individual& robot) { return robot.wheels.wheel_ratio; }, true);
  for (const Unknown unknown : core::all_of<Unknown>()) {
    const bool relative = unknown == Unknown::left_diameter || unknown == Unknown::right_diameter ||
                          unknown == Unknown::track || unknown == Unknown::slip || unknown == Unknown::sigma_xy ||
                          unknown == Unknown::sigma_theta;
    row(
        word(unknown), [&](const auto& found) -> const auto& { return found[unknown]; },
        [&](const Individual& robot) { return truth_of(robot, unknown); }, relative);
  }
  // How wrong an estimate is over all robots: root mean squares.
  const auto error_of = [&](const char* name, const auto& drive_of) {
    double ratio = 0.0, track = 0.0;
    std::vector<double> drifts;
    for (std::size_t k = 0; k < outcomes.size(); ++k) {
      const core::DifferentialDrive truth = core::random_individual(bench.seed + k).wheels;
      const core::DifferentialDrive found = drive_of(outcomes[k]);
      drifts.push_back(drift(found, truth));
      ratio += core::math::squared(found.wheel_ratio / truth.wheel_ratio - 1.0);
      track += core::math::squared(found.track / truth.track - 1.0);
    }
    const auto all = static_cast<double>(outcomes.size());
    fmt::print("rms_error_{}: wheel_ratio {:.3f} %, track {:.3f} %; drift_60_s {:.1f} mm (median)\n", name,
               100.0 * std::sqrt(ratio / all), 100.0 * std::sqrt(track / all), 1e3 * core::median(drifts));
  };
  error_of("drawn", [](const Outcome&) { return core::DifferentialDrive{}; });
  error_of("identify", [](const Outcome& o) { return o.found.drive({}); });
  if (manoeuvre.squares) {
    error_of("umbmark", [](const Outcome& o) { return o.umbmark; });
    error_of("umbmark_again", [](const Outcome& o) { return o.umbmark_again; });
  }
  fmt::print("drift_60_s: {:.1f} mm as drawn, {:.2f} mm as identified: {:.0f} times less (medians)\n",
             1e3 * core::median(before), 1e3 * core::median(after), core::median(before) / core::median(after));
  fmt::print("drift_cut_20_times: {:.1f} % of the robots\n",
             100.0 *
                 static_cast<double>(std::count_if(shares.begin(), shares.end(), [](double s) { return s >= 20.0; })) /
                 static_cast<double>(shares.size()));
  return good;
}

}  // namespace

int bench_identify(const IdentifyBench& bench) {
  if (const auto missing = missing_resources()) return complain(*missing), wrong_input;
  const auto recommended = follow("identify"), lap = follow("platoon");
  if (!recommended || !lap || bench.runs < 1) return wrong_input;
  const core::Individual exact;
  core::Identification way = core::identify(drive(*recommended, exact, bench.seed));
  bool good = true;
  for (const Manoeuvre& manoeuvre : {*recommended, umbmark(way.driven, recommended->seconds), *lap}) {
    const std::vector<Outcome> outcomes = study(manoeuvre, bench);
    if (interrupted()) return expectation_failed;
    const bool holds = print(manoeuvre, bench, outcomes);
    std::fflush(stdout);  // a thousand robots take minutes
    if (manoeuvre.name == recommended->name) good = holds;
  }
  return good ? done : expectation_failed;
}

}  // namespace skein::app

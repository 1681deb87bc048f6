#include "app/tools/identify.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <future>
#include <iterator>
#include <thread>

#include "app/embedded/embedded.h"
#include "app/experiment/text_file.h"
#include "app/record/csv_reader.h"
#include "app/record/gnuplot.h"
#include "core/estimation/statistics.h"
#include "core/math/elementary.h"
#include "core/simulation/simulated_robot.h"

namespace skein::app {
namespace {

namespace fs = std::filesystem;
using core::Unknown;

constexpr double rounding = 1e-9;  // of times that are k / rate [s]
constexpr double between_runs = 10.0;

std::string key_of(const RobotSpec& spec) {
  return spec.name.empty() ? fmt::format("tag {}", spec.tag) : spec.name;
}

double largest_persistence(const std::vector<core::Innovation>& innovations) {
  double largest = 0.0;
  for (double core::Innovation::*const residual :
       {&core::Innovation::ahead, &core::Innovation::left, &core::Innovation::theta}) {
    double products = 0.0, squares = 0.0, squares_before = 0.0;
    for (std::size_t k = 1; k < innovations.size(); ++k) {
      if (!innovations[k].used || !innovations[k - 1].used) continue;
      products += innovations[k].*residual * innovations[k - 1].*residual;
      squares += innovations[k].*residual * innovations[k].*residual;
      squares_before += innovations[k - 1].*residual * innovations[k - 1].*residual;
    }
    const double both = std::sqrt(squares) * std::sqrt(squares_before);
    const double correlation = both > 0.0 ? std::clamp(products / both, -1.0, 1.0) : 0.0;
    if (std::abs(correlation) > std::abs(largest)) largest = correlation;
  }
  return largest;
}

/// Whether the residuals are larger than what is left of rounding and of the model where nothing is noisy: no camera
/// measures so little, so that nothing can have moved the robot by it.
bool could_be_seen(const std::vector<core::Innovation>& innovations) {
  constexpr double least = 1e-5, least_angle = 1e-4;  // [m], [rad]
  double squares = 0.0, angles = 0.0, count = 0.0;
  for (const core::Innovation& innovation : innovations) {
    if (!innovation.used) continue;
    squares += core::math::squared(core::math::hypot(innovation.ahead, innovation.left));
    angles += core::math::squared(innovation.theta);
    ++count;
  }
  return count > 0.0 && (squares > count * least * least || angles > count * least_angle * least_angle);
}

}  // namespace

RunHistory::RunHistory(const Experiment& experiment) : experiment_(experiment) {
  for (const RobotSpec& spec : experiment_.robots) robots_.emplace_back(spec.motor);
}

/// Between these times something other than its wheels moves it.
void RunHistory::carry(Robot& robot, double from, double to) {
  ++robot.carried;
  robot.moved_from = robot.moved ? std::min(robot.moved_from, from) : from;
  robot.moved_to = robot.moved ? std::max(robot.moved_to, to) : to;
  robot.moved = true;
}

/// Where hands were at work.
void RunHistory::hear(const TickRecord& row) {
  const double period = experiment_.period();
  for (const Event& event : row.events) {
    const bool placed = is<events::Perturb, events::Move>(event), kicked = is<events::Kick>(event);
    if (!placed && !kicked && !is<events::Kidnap>(event)) continue;
    Robot& robot = robots_[*robot_of(event)];
    // A jump is noticed when it is seen, and that pose is the first after it. What the file or the operator does to a
    // simulated robot happens about this tick.
    const double from = is<events::Kidnap>(event) ? row.robots[*robot_of(event)].measurement.captured_at
                                                  : (std::isnan(before_) ? row.now : before_);
    const double to =
        is<events::Kidnap>(event) ? from : row.now + (kicked ? core::SimulatedRobot::slides_for : 0.5 * period);
    carry(robot, from, to);
  }
}

/// The commands to the wheels, and their times: that of the tick, unless the link held them back.
void RunHistory::drive(Robot& robot, const TickRecord& row, const RobotRecord& record) const {
  core::WheelSpeeds speeds = record.wheels;
  double at = row.now;
  if (const LinkInput& link = record.link.input; !std::isnan(link.sent_at)) {
    speeds = link.sent;
    at = link.sent == robot.told && !std::isnan(before_) ? before_ : link.sent_at;
  }
  robot.told = record.wheels;
  // Links do not repeat speeds that the robot has already been sent.
  if (std::isnan(speeds.left) || std::isnan(speeds.right) || speeds == robot.commanded) return;
  robot.commanded = speeds;
  robot.commanded_at = std::max(robot.commanded_at, at);
  robot.log.command(robot.commanded_at, speeds);
}

void RunHistory::see(Robot& robot, const TickRecord& row, std::size_t i) const {
  const core::Measurement& seen = row.robots[i].measurement;
  if (!seen.ever_seen()) return;
  if (!robot.poses.empty() && !(seen.captured_at > robot.poses.back().t)) return;
  const bool anew = robot.moved && seen.captured_at >= robot.moved_from - rounding;
  if (anew && seen.captured_at >= robot.moved_to - rounding) robot.moved = false;
  robot.poses.push_back({seen.captured_at, seen.pose, anew});
}

/// There were ticks before this one that have no row: their commands, which do not explain where the robots are next,
/// are not known. In a pause there are none, and the experiment's time stands still; otherwise rows are missing.
void RunHistory::pass_over(const TickRecord& row) {
  const double period = std::isnan(row.period) ? 0.0 : row.period;
  if (std::isnan(before_) || row.now - before_ <= period + rounding) return;
  gaps_ += row.t - t_before_ > 1.5 * experiment_.period() ? 1 : 0;
  for (std::size_t i = 0; i < robots_.size(); ++i) {
    const double delay = row.robots[i].actuation_delay;
    carry(robots_[i], before_, row.now + (std::isnan(delay) ? 0.0 : delay));
  }
}

void RunHistory::record(const TickRecord& row) {
  pass_over(row);
  hear(row);
  for (std::size_t i = 0; i < robots_.size(); ++i) {
    drive(robots_[i], row, row.robots[i]);
    see(robots_[i], row, i);
    if (const double delay = row.robots[i].actuation_delay; !std::isnan(delay)) {
      robots_[i].delays += delay;
      ++robots_[i].delays_known;
    }
  }
  before_ = row.now;
  t_before_ = row.t;
}

std::vector<RobotHistory> RunHistory::finish() && {
  std::vector<RobotHistory> all;
  for (std::size_t i = 0; i < robots_.size(); ++i) {
    Robot& robot = robots_[i];
    if (robot.poses.empty()) continue;
    RobotHistory history;
    history.spec = experiment_.robots[i];
    history.key = key_of(history.spec);
    history.name = robot_name(experiment_, i);
    history.input.believed = history.spec.drive;
    history.input.slip_period = experiment_.period();
    history.input.wheels = std::move(robot.log).finish(std::max(before_, robot.commanded_at) + experiment_.period());
    history.input.poses = std::move(robot.poses);
    history.believed_delay = robot.delays / std::max(1.0, robot.delays_known);
    history.runs = 1;
    history.carried = robot.carried;
    all.push_back(std::move(history));
  }
  return all;
}

tl::expected<RecordedHistory, std::string> read_history(const std::string& csv) {
  std::ifstream file(csv, std::ios::binary);
  if (!file) return tl::unexpected(fmt::format("{}: cannot be opened: {}", csv, std::strerror(errno)));
  auto reader = CsvReader::open(file, csv);
  if (!reader) return tl::unexpected(reader.error());
  const auto experiment = reader->experiment();
  if (!experiment) return tl::unexpected(experiment.error());
  RunHistory history(*experiment);
  for (TickRecord row;;) {
    const auto more = reader->next(row);
    if (!more) return tl::unexpected(more.error());
    if (!*more) {
      const std::size_t gaps = history.gaps();
      return RecordedHistory{std::move(history).finish(), reader->torn(), gaps};
    }
    history.record(row);
  }
}

bool same_run(const std::vector<RobotHistory>& a, const std::vector<RobotHistory>& b) {
  const auto same_pose = [](const core::SeenPose& one, const core::SeenPose& other) {
    return one.t == other.t && one.pose.x == other.pose.x && one.pose.y == other.pose.y &&
           one.pose.theta == other.pose.theta;
  };
  bool any = false;
  for (const RobotHistory& one : a)
    for (const RobotHistory& other : b) {
      if (one.key != other.key) continue;
      const std::vector<core::SeenPose>&poses = one.input.poses, &others = other.input.poses;
      const auto both = static_cast<std::ptrdiff_t>(std::min(poses.size(), others.size()));
      if (!std::equal(poses.begin(), poses.begin() + both, others.begin(), same_pose)) return false;
      any = true;
    }
  return any;
}

void append(std::vector<RobotHistory>& robots, std::vector<RobotHistory> more) {
  for (RobotHistory& next : more) {
    const auto same = std::find_if(robots.begin(), robots.end(), [&](const auto& r) { return r.key == next.key; });
    if (same == robots.end()) {
      robots.push_back(std::move(next));
      continue;
    }
    core::IdentificationInput& all = same->input;
    core::IdentificationInput& later = next.input;
    if (same->each.empty()) same->each.push_back(all);
    same->each.push_back(later);
    // Knots are in steps: those of the earlier runs in the steps of the newest drive.
    const double steps = later.believed.steps_per_turn / all.believed.steps_per_turn;
    for (core::WheelKnot& knot : all.wheels) knot.left *= steps, knot.right *= steps;
    const auto first_time = [](const core::IdentificationInput& input) {
      return std::min(input.poses.front().t, input.wheels.empty() ? input.poses.front().t : input.wheels.front().t);
    };
    const double end = std::max(all.poses.back().t, all.wheels.empty() ? all.poses.back().t : all.wheels.back().t);
    const double shift = end + between_runs - first_time(later);
    const core::WheelKnot turned = all.wheels.empty() ? core::WheelKnot{} : all.wheels.back();
    for (const core::WheelKnot& knot : later.wheels)
      all.wheels.push_back({knot.t + shift, knot.left + turned.left, knot.right + turned.right});
    later.poses.front().anew = true;
    for (core::SeenPose seen : later.poses) {
      seen.t += shift;
      all.poses.push_back(seen);
    }
    all.believed = later.believed;
    same->spec = std::move(next.spec);
    same->believed_delay = next.believed_delay;
    same->runs += next.runs;
    same->carried += next.carried + 1;
  }
}

/// Runs of another robot with the same name or tag: the values that such a run alone gives are far from those of all,
/// as measured by what is not known of both: a run without noise seems to know its own to the last digit.
std::vector<OtherRobot> other_robots(const RobotHistory& history, const core::Identification& together) {
  constexpr double far = 4.0, widths_per_sigma = 2.0 * core::z_95;
  std::vector<OtherRobot> others;
  for (std::size_t run = 0; run < history.each.size() && together.converged; ++run) {
    const core::Identification alone = core::identify(history.each[run]);
    if (!alone.converged) continue;
    double farthest = far;
    std::optional<OtherRobot> other;
    const auto compare = [&](std::string_view value, const core::Estimate& a, const core::Estimate& b) {
      const double sigma = core::math::hypot(a.high - a.low, b.high - b.low) / widths_per_sigma;
      if (const double distance = std::abs(a.value - b.value) / sigma; a.known && distance > farthest)
        farthest = distance, other = {run, value, a, b};
    };
    compare("wheel_diameter", alone.wheel_diameter, together.wheel_diameter);
    compare("wheel_ratio", alone.wheel_ratio, together.wheel_ratio);
    for (const Unknown unknown : {Unknown::track, Unknown::delay})
      compare(word(unknown), alone[unknown], together[unknown]);
    if (other) others.push_back(*other);
  }
  return others;
}

std::vector<IdentifiedRobot> identify_robots(std::vector<RobotHistory> robots) {
  std::vector<IdentifiedRobot> all(robots.size());
  const std::size_t threads = std::max(1U, std::thread::hardware_concurrency());
  std::vector<std::future<void>> work;
  for (std::size_t thread = 0; thread < std::min(threads, robots.size()); ++thread)
    work.push_back(std::async(std::launch::async, [&, thread] {
      for (std::size_t i = thread; i < robots.size(); i += threads) {
        all[i].history = std::move(robots[i]);
        all[i].found = core::identify(all[i].history.input);
        all[i].others = other_robots(all[i].history, all[i].found);
        all[i].persistence = largest_persistence(all[i].found.innovations);
        all[i].outliers =
            static_cast<std::size_t>(std::count_if(all[i].found.innovations.begin(), all[i].found.innovations.end(),
                                                   [](const auto& innovation) { return !innovation.used; }));
      }
    }));
  for (std::future<void>& one : work) one.get();
  return all;
}

/// How far its poses are from the first one, at most: in metres, and in radians.
std::pair<double, double> moved(const std::vector<core::SeenPose>& poses) {
  double way = 0.0, turn = 0.0;
  for (const core::SeenPose& seen : poses) {
    way = std::max(way, core::distance(seen.pose, poses.front().pose));
    turn = std::max(turn, std::abs(core::wrap_angle(seen.pose.theta - poses.front().pose.theta)));
  }
  return {way, turn};
}

/// It was commanded to drive, and stood: its data say nothing about its wheels.
bool stood(const IdentifiedRobot& robot) {
  // A robot that drives so far leaves its place, or turns there, by more than the noise of poses.
  constexpr double commanded_way = 0.2, commanded_turn = 1.5, still_way = 0.02, still_turn = 0.15;
  const auto [way, turn] = moved(robot.history.input.poses);
  return (robot.found.driven > commanded_way || robot.found.turned > commanded_turn) && way < still_way &&
         turn < still_turn;
}

/// "1 pose", "2 poses".
std::string counted_poses(std::size_t poses) {
  return fmt::format("{} pose{}", poses, poses == 1 ? "" : "s");
}

std::vector<std::string> doubts(const IdentifiedRobot& robot) {
  const core::Identification& found = robot.found;
  std::vector<std::string> sentences;
  if (stood(robot)) {
    sentences.push_back(fmt::format(
        "it stood though it was commanded to drive {:.2f} m and to turn {:.1f} rad: no pose is farther than "
        "{:.0f} mm from the first. Is it switched on, its battery charged, are its wheels free, and is the "
        "tag on the robot that has this link?",
        found.driven, found.turned, 1e3 * moved(robot.history.input.poses).first));
    return sentences;
  }
  const std::string poses = counted_poses(robot.history.input.poses.size());
  if (!found.converged) {
    sentences.push_back(found.driven + found.turned > 0.0
                            ? fmt::format("{} over {:.2f} m: that determines nothing: record a run that drives farther",
                                          poses, found.driven)
                            : fmt::format("it never drove, in {}: nothing can be identified", poses));
    return sentences;
  }
  for (const OtherRobot& other : robot.others)
    sentences.push_back(fmt::format(
        "run {} of {} alone gives {} {:.5g} ({:.5g} to {:.5g}), all together {:.5g}: is it another robot with "
        "the same name or tag, or was something changed? Identify its runs by themselves; nothing is saved",
        other.run + 1, robot.history.runs, other.value, other.alone.value, other.alone.low, other.alone.high,
        other.together.value));
  const auto interval = [](const core::Estimate& e) { return fmt::format("{:.3g} to {:.3g}", e.low, e.high); };
  if (!found.wheel_diameter.known)
    sentences.push_back(
        fmt::format("the data do not determine the wheels' diameters ({} m) from {:.2f} m of driving: drive farther",
                    interval(found.wheel_diameter), found.driven));
  if (!found.wheel_ratio.known)
    sentences.push_back(
        fmt::format("the data do not determine the ratio of the wheels ({}) from {:.2f} m of driving: drive farther",
                    interval(found.wheel_ratio), found.driven));
  if (!found[Unknown::track].known)
    sentences.push_back(fmt::format("the data do not determine the track ({} m) from {:.2f} rad of turning: turn more",
                                    interval(found[Unknown::track]), found.turned));
  if (!found[Unknown::delay].known)
    sentences.push_back(
        fmt::format("the data do not determine the delay ({} s): change speed and turning rate more often",
                    interval(found[Unknown::delay])));
  constexpr double hangs_together = 0.25, many = 0.02;
  if (std::abs(robot.persistence) > hangs_together && could_be_seen(found.innovations))
    sentences.push_back(
        fmt::format("residuals are correlated ({:.2f} from one to the next): something else moves the robot or its "
                    "tag, and the intervals are too narrow",
                    robot.persistence));
  if (static_cast<double>(robot.outliers) > many * static_cast<double>(found.innovations.size()))
    sentences.push_back(fmt::format("{} of {} poses are outliers: check the tags and whether the robot was touched",
                                    robot.outliers, found.innovations.size()));
  return sentences;
}

std::vector<std::pair<std::string, std::string>> values_to_keep(const IdentifiedRobot& robot) {
  std::vector<std::pair<std::string, std::string>> values;
  if (stood(robot) || !robot.others.empty()) return values;
  const core::Identification& found = robot.found;
  const core::DifferentialDrive drive = found.drive(robot.history.input.believed);
  const auto keep = [&](const char* key, const core::Estimate& estimate, const std::string& value) {
    if (estimate.known) values.emplace_back(key, value);
  };
  keep("wheel_diameter", found.wheel_diameter, fmt::format("{:.6f}", drive.wheel_diameter));
  keep("wheel_ratio", found.wheel_ratio, fmt::format("{:.5f}", drive.wheel_ratio));
  keep("track", found[Unknown::track], fmt::format("{:.6f}", drive.track));
  keep("actuation_delay", found[Unknown::delay], fmt::format("{:.4f}", std::max(0.0, found[Unknown::delay].value)));
  return values;
}

tl::expected<void, std::string> write_residuals(const std::string& folder, const std::vector<IdentifiedRobot>& robots) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) return tl::unexpected(fmt::format("{}: cannot be made: {}", folder, error.message()));
  constexpr std::size_t most_points = 20'000;  // more than these nobody sees
  for (std::size_t i = 0; i < robots.size(); ++i) {
    const std::string name = fmt::format("residuals_{}", i + 1);
    std::string table = "t,ahead,left,theta,normalised,used\n";
    for (const core::Innovation& innovation : robots[i].found.innovations)
      table += fmt::format("{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{}\n", innovation.t, innovation.ahead, innovation.left,
                           innovation.theta, innovation.normalised, innovation.used ? 1 : 0);
    const fs::path path = fs::path(folder) / name;
    std::string title = robots[i].history.name;
    std::replace_if(
        title.begin(), title.end(), [](char c) { return c == '"' || c == '\\'; }, '\'');
    const std::string head = fmt::format(
        "# Residuals of {0}, drawn by skein {1}. To draw it again, edit this and run: gnuplot {2}.gp\n"
        "name = \"{2}\"\nrobot = \"{0}\"\n"
        "stride = {3}  # of so many poses one is drawn, and every outlier\n",
        title, SKEIN_VERSION, name, 1 + robots[i].found.innovations.size() / most_points);
    auto done = write_file(path.string() + ".csv", table);
    if (done) done = write_file(path.string() + ".gp", head + std::string(embedded::residuals_gp));
    if (done && !robots[i].found.innovations.empty()) done = draw_figure(folder, name);
    if (!done) return done;
  }
  return {};
}

}  // namespace skein::app

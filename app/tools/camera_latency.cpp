#include "app/tools/camera_latency.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "app/session/experiment_cameras.h"
#include "app/tools/plant_loop.h"
#include "core/estimation/statistics.h"
#include "core/kinematics/step_rate.h"
#include "core/math/elementary.h"
#include "core/safety/limits.h"

namespace skein::app {
namespace {

constexpr double slow = 0.4, quick = 1.0;             // to and fro, at first and at last [Hz]
constexpr double fastest_turn = 2.0;                  // [rad/s]
constexpr double camera_opens = 10.0, at_rest = 0.5;  // a camera opens; before and after the manoeuvre [s]
constexpr double off_the_spot = 0.05, elbow = 0.01;   // the robot may wander; between two bodies [m]

/// A frequency that rises evenly: delay and scale of the headings show at different phases of each turn.
double turning_rate(double t, double seconds) {
  return fastest_turn * core::math::sin(2.0 * core::pi * t * (slow + 0.5 * (quick - slow) * t / seconds));
}

/// Wheels roll evenly from step to step (core::StepMotor), and counters count steps that are made: on average a wheel
/// is half a step of its motor farther, the way it turns. An e-puck2 makes half steps. [steps]
double ahead_of_counter(core::MotorModel motor) {
  switch (motor) {
    case core::MotorModel::epuck1:
      return 0.5;
    case core::MotorModel::epuck2:
      return 0.25;
    case core::MotorModel::ideal:
    case core::MotorModel::servo:
      return 0.0;
  }
  return 0.0;
}

void between_steps(std::vector<core::WheelKnot>& wheels, double ahead) {
  const std::vector<core::WheelKnot> counted = wheels;
  const auto sign = [](double before, double after) { return after > before ? 1.0 : after < before ? -1.0 : 0.0; };
  for (std::size_t k = 1; k + 1 < wheels.size(); ++k) {
    wheels[k].left += ahead * sign(counted[k - 1].left, counted[k + 1].left);
    wheels[k].right += ahead * sign(counted[k - 1].right, counted[k + 1].right);
  }
}

/// What is recorded meanwhile.
class Recording {
 public:
  Recording(const Experiment& experiment, std::size_t robot)
      : experiment_(experiment), robot_(robot), poses_(experiment.cameras()) {}

  void add(const WheelCount& count) {
    if (!std::isnan(count.by) && (counts_.empty() || count.by > counts_.back().by)) counts_.push_back(count);
  }
  void add(std::size_t camera, const core::Measurement& seen) {
    std::vector<core::SeenPose>& poses = poses_[camera];
    if (seen.ever_seen() && (poses.empty() || seen.captured_at > poses.back().t))
      poses.push_back({seen.captured_at, seen.pose});
  }

  /// Answers that took much longer than usual say little about when the counters were read.
  LatencyMeasurement evaluate() const {
    LatencyMeasurement result;
    if (counts_.empty()) return result;
    std::vector<double> trips;
    trips.reserve(counts_.size());
    for (const WheelCount& count : counts_) trips.push_back(count.by - count.since);
    const double longest = 1.5 * core::median(trips);
    const RobotSpec& spec = experiment_.robots[robot_];
    core::TurnRecord turn;
    turn.believed = spec.drive;
    trips.clear();
    for (const WheelCount& count : counts_) {
      if (count.by - count.since > longest || (!turn.wheels.empty() && count.at() <= turn.wheels.back().t)) continue;
      turn.wheels.push_back({count.at(), count.left, count.right});
      trips.push_back(count.by - count.since);
    }
    result.counts = turn.wheels.size();
    result.round_trip = core::median(trips);
    between_steps(turn.wheels, ahead_of_counter(spec.motor));
    result.turned = turn.turned();
    for (std::size_t camera = 0; camera < poses_.size(); ++camera) {
      turn.poses = poses_[camera];
      result.cameras.push_back(judge_latency(turn));
      result.cameras.back().camera = camera;
      result.cameras.back().row = mean_row(camera);
    }
    return result;
  }

 private:
  /// The row at which a camera saw the robot's tag. [px]
  double mean_row(std::size_t camera) const {
    const auto calibration = camera_calibration(experiment_, camera);
    if (!calibration || poses_[camera].empty()) return none;
    double sum = 0.0;
    for (const core::SeenPose& seen : poses_[camera]) {
      const auto pixel = vision::pixel_from_world(*calibration, {seen.pose.x, seen.pose.y, calibration->tag_height});
      if (!pixel) return none;
      sum += pixel->y();
    }
    return sum / static_cast<double>(poses_[camera].size());
  }

  const Experiment& experiment_;
  const std::size_t robot_;
  std::vector<WheelCount> counts_;
  std::vector<std::vector<core::SeenPose>> poses_;  // of each camera
};

/// Why it cannot be done; empty: it can.
std::string obstacle(const Plant& plant, const Experiment& experiment, std::size_t robot) {
  if (!experiment.robots[robot].has_link())
    return fmt::format("{} has no link, so that there are no counters of its wheels to compare with",
                       robot_name(experiment, robot));
  if (!plant.cameras()) return "camera.source is \"none\": there is no camera to measure";
  for (std::size_t k = 0; k < experiment.cameras(); ++k)
    if (experiment.camera_at(k).kind() == CameraKind::recorded)
      return fmt::format("{}camera.source is \"{}\", which does not show how {} turns now; allowed: a camera",
                         camera_prefix(experiment, k), experiment.camera_at(k).source, robot_name(experiment, robot));
  return {};
}

/// The robot that stands in the way of a body that turns; empty: none.
std::string neighbour(const PlantLoop& loop, const Experiment& experiment, std::size_t robot) {
  for (std::size_t i = 0; i < experiment.robots.size(); ++i) {
    const core::Measurement& other = loop.newest()[i];
    if (i == robot || !other.ever_seen()) continue;
    const double gap = core::distance(other.pose, loop.newest()[robot].pose) - experiment.robots[i].radius -
                       experiment.robots[robot].radius;
    if (gap < elbow)
      return fmt::format("{} stands {:.0f} mm from {}: give it room to turn", robot_name(experiment, i),
                         1e3 * std::max(0.0, gap), robot_name(experiment, robot));
  }
  return {};
}

}  // namespace

CameraLatency judge_latency(const core::TurnRecord& turn) {
  constexpr double useful = 1e-3, agreement = 2e-3;  // half of the interval; between both halves [s]
  constexpr double strange = 0.2, little = 3.0;      // of the scale; turned [rad]
  CameraLatency result;
  result.poses = turn.poses.size();
  if (const double turned = turn.turned(); result.poses < core::LatencyFit::least_poses || turned < little) {
    result.doubt = fmt::format(
        "{} poses, and {:.1f} rad by the counters, determine nothing: is the robot in this "
        "camera's view, may it turn, and do its wheels?",
        result.poses, turned);
    return result;
  }
  static_cast<core::LatencyFit&>(result) = core::fit_latency(turn);
  if (std::abs(result.scale - 1.0) > strange)
    result.doubt = fmt::format(
        "the camera saw it turn {:.2f} times as far as its counters say: is it the robot with "
        "this tag, and are its wheels right in the file?",
        result.scale);
  else if (!(core::z_95 * result.sigma <= useful))
    result.doubt =
        fmt::format("the data leave {:.1f} to {:.1f} ms: turn for longer (--seconds), or under better light",
                    1e3 * (result.late - core::z_95 * result.sigma), 1e3 * (result.late + core::z_95 * result.sigma));
  else if (!(std::abs(result.halves[0] - result.halves[1]) <= agreement))
    result.doubt = fmt::format(
        "the first half says {:.1f} ms and the second {:.1f} ms: the camera's stamps or the "
        "robot's answers are irregular",
        1e3 * result.halves[0], 1e3 * result.halves[1]);
  return result;
}

CameraRows judge_rows(const std::vector<CameraLatency>& turns, double row_time, int height) {
  constexpr double least_sigma = 1e-4;      // counters say no better when a wheel was where [s]
  constexpr double least_part = 1.0 / 3.0;  // of the picture's height, from the highest tag to the lowest
  constexpr double useful = 1e-3;           // half of the interval, over the whole picture [s]
  CameraRows result;
  double weights = 0.0, row = 0.0, late = 0.0, top = none, bottom = none;
  std::size_t n = 0;
  const auto weight = [&](const CameraLatency& turn) {
    return 1.0 / core::math::squared(std::max(turn.sigma, least_sigma));
  };
  const auto told = [](const CameraLatency& turn) { return turn.doubt.empty() && std::isfinite(turn.late + turn.row); };
  for (const CameraLatency& turn : turns) {
    if (!told(turn)) continue;
    weights += weight(turn);
    row += weight(turn) * turn.row;
    late += weight(turn) * turn.late;
    top = std::fmin(top, turn.row);
    bottom = std::fmax(bottom, turn.row);
    ++n;
  }
  if (n < 2) {
    result.doubt = fmt::format("{} of {} turns tell a latency; needed for the row time: two or more", n, turns.size());
    return result;
  }
  row /= weights, late /= weights;
  if (bottom - top < least_part * height) {
    result.doubt = fmt::format(
        "the tags were at the rows {:.0f} to {:.0f} of {}; needed for the row time: {:.0f} rows apart or more: one "
        "robot "
        "near the upper border of the picture, one near the lower",
        top, bottom, height, least_part * height);
    return result;
  }
  double moment = 0.0, product = 0.0;
  for (const CameraLatency& turn : turns)
    if (told(turn)) {
      moment += weight(turn) * (turn.row - row) * (turn.row - row);
      product += weight(turn) * (turn.row - row) * (turn.late - late);
    }
  const double slope = product / moment;
  double squares = 0.0;
  for (const CameraLatency& turn : turns)
    if (told(turn)) squares += weight(turn) * core::math::squared(turn.late - late - slope * (turn.row - row));
  // Turns that do not lie on a line say less than each claims.
  const double worse = n > 2 ? std::max(1.0, squares / static_cast<double>(n - 2)) : 1.0;
  result.row_time = row_time - slope;  // a row that is read later than was thought makes its stamps less late
  result.row_time_sigma = std::sqrt(worse / moment);
  result.late = late - slope * row;
  result.late_sigma = std::sqrt(worse / weights + row * row * worse / moment);
  if (core::z_95 * result.row_time_sigma * height > useful)
    result.doubt = fmt::format("the turns leave a row time of {:.1f} to {:.1f} us: turn for longer (--seconds)",
                               1e6 * (result.row_time - core::z_95 * result.row_time_sigma),
                               1e6 * (result.row_time + core::z_95 * result.row_time_sigma));
  else if (result.row_time < -core::z_95 * result.row_time_sigma)
    result.doubt = fmt::format(
        "a row time of {:.1f} us means rows that are read from the bottom up; allowed: from the top down: does the "
        "camera "
        "or its driver turn the picture over?",
        1e6 * result.row_time);
  else
    result.row_time = std::max(0.0, result.row_time);
  return result;
}

tl::expected<LatencyMeasurement, std::string> measure_latency(Plant& plant, SessionClock& clock,
                                                              const Experiment& experiment, std::size_t robot,
                                                              double seconds, std::function<bool()> keep_on) {
  const auto refuse = [&](std::string why) {
    plant.stop();
    return tl::unexpected(std::move(why));
  };
  if (std::string why = obstacle(plant, experiment, robot); !why.empty()) return refuse(std::move(why));
  PlantLoop loop(plant, clock, experiment, std::move(keep_on));
  const core::Measurement& seen = loop.newest()[robot];
  const std::string name = robot_name(experiment, robot);
  for (const double begun = clock.now(); !seen.ever_seen();) {
    if (clock.now() > begun + camera_opens) {
      const std::string why = plant.cameras()->why_lost()[robot].sentence;
      return refuse(fmt::format("tag {} of {} is not seen{}{}", experiment.robots[robot].tag, name,
                                why.empty() ? "" : ": ", why));
    }
    if (const auto ticked = loop.tick(); !ticked) return tl::unexpected(ticked.error());
  }
  if (std::string why = neighbour(loop, experiment, robot); !why.empty()) return refuse(std::move(why));

  Recording recording(experiment, robot);
  const core::Pose begun_at = seen.pose;
  const std::uint64_t interruptions = plant.robots()[robot].resynchronisations;
  const core::CommandLimits limits = make_limits(experiment, robot);
  const RobotSpec& spec = experiment.robots[robot];
  const double begun = clock.now() + at_rest, ended = begun + seconds;
  while (clock.now() < ended + at_rest) {
    const double now = clock.now();
    const double rate = now >= begun && now < ended ? turning_rate(now - begun, seconds) : 0.0;
    const core::WheelSpeeds wheels = spec.drive.wheels(limits.limit({0.0, rate}));
    loop.command(robot,
                 {core::nearest_command(spec.motor, wheels.left), core::nearest_command(spec.motor, wheels.right)});
    if (const auto ticked = loop.tick(); !ticked) return tl::unexpected(ticked.error());
    if (clock.now() - seen.captured_at > experiment.estimation.bridge)
      return refuse(fmt::format("tag {} of {} was lost", spec.tag, name));
    if (const double off = core::distance(seen.pose, begun_at); off > off_the_spot)
      return refuse(fmt::format("{} moved by {:.0f} mm instead of turning on the spot", name, 1e3 * off));
    const RobotStatus status = plant.robots()[robot];
    if (status.resynchronisations != interruptions)
      return refuse(fmt::format("the link of {} was interrupted: {}", name, status.reason));
    recording.add(status.count);
    for (std::size_t k = 0; k < experiment.cameras(); ++k)
      recording.add(k, loop.by_camera()[k * plant.tags().size() + robot]);
  }
  return recording.evaluate();
}

}  // namespace skein::app

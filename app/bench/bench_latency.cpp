#include "app/bench/bench_latency.h"

#include <fmt/format.h>

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "app/experiment/experiment_file.h"
#include "app/run/exit_status.h"
#include "app/run/output.h"
#include "app/session/session.h"
#include "app/tools/camera_latency.h"
#include "core/math/elementary.h"

namespace skein::app {
namespace {

constexpr const char* full_speed =
    "duration = 12\n[reference]\nkind = \"platoon\"\nspeed = 0.13\npath = { shape = \"circle\", radius = 0.5 }\n"
    "[controller]\nv_max = 0.16\n[camera]\nsource = \"synthetic\"\n[[robot]]\nlink = \"loopback\"\n";

Experiment under_a_late_camera(const std::string& model, double late, double latency) {
  return parse_experiment(
             full_speed, "full speed",
             std::vector{fmt::format("robot.1.model={}", model), fmt::format("camera.stamps_late={}", late),
                         fmt::format("camera.latency={:.4f}", latency)})
      .value();
}

tl::expected<CameraLatency, std::string> found_in(const Experiment& experiment) {
  SessionClock clock(false);
  auto plant = Plant::open(experiment, clock, {});
  if (!plant) return tl::unexpected(plant.error());
  auto measured = measure_latency(**plant, clock, experiment, 0, 12.0);
  (*plant)->close();
  if (!measured) return tl::unexpected(measured.error());
  if (!measured->cameras.front().doubt.empty()) return tl::unexpected(measured->cameras.front().doubt);
  return measured->cameras.front();
}

/// How far the robot is ahead of its predicted pose, after its first two seconds.
class Ahead final : public RecordSink {
 public:
  void record(const TickRecord& row) override {
    const RobotRecord& robot = row.robots.front();
    if (row.t < 2.0) return;
    sum_ += (robot.truth.x - robot.pose.x) * core::math::cos(robot.truth.theta) +
            (robot.truth.y - robot.pose.y) * core::math::sin(robot.truth.theta);
    ++rows_;
  }
  double mean() const { return rows_ > 0 ? sum_ / rows_ : none; }

 private:
  double sum_ = 0.0;
  int rows_ = 0;
};

tl::expected<double, std::string> ahead_of_prediction(const Experiment& experiment) {
  Ahead ahead;
  auto session = Session::open(experiment, Session::Clock::virtual_, {false, {&ahead}});
  if (!session) return tl::unexpected(session.error());
  (*session)->run();
  return ahead.mean();
}

}  // namespace

int bench_latency() {
  constexpr double to_a_millisecond = 1e-3, left = 0.3e-3;  // [s], [m]
  print_out(
      fmt::format("stamps late by a known time; a robot at 0.13 m/s ahead of its predicted place, mean of 10 s\n"
                  "{:<10}{:>12}{:>12}{:>18}{:>18}{:>16}\n",
                  "model", "late [ms]", "found [ms]", "deviation [ms]", "uncorrected [mm]", "corrected [mm]"));
  int status = done;
  for (const auto& [model, late] : {std::pair{"epuck2", 0.0},
                                    {"epuck2", 0.007},
                                    {"epuck2", 0.02},
                                    {"epuck2", 0.04},
                                    {"epuck1", 0.02},
                                    {"khepera4", 0.02},
                                    {"open", 0.02}}) {
    const auto found = found_in(under_a_late_camera(model, late, 0.0));
    const auto before = ahead_of_prediction(under_a_late_camera(model, late, 0.0));
    const auto after = ahead_of_prediction(under_a_late_camera(model, late, found ? found->late : 0.0));
    if (!found || !before || !after) {
      complain(!found ? found.error() : !before ? before.error() : after.error());
      status = expectation_failed;
      continue;
    }
    print_out(fmt::format("{:<10}{:>12.2f}{:>12.2f}{:>18.3f}{:>18.3f}{:>16.3f}\n", model, 1e3 * late, 1e3 * found->late,
                          1e3 * found->sigma, 1e3 * *before, 1e3 * *after));
    if (std::abs(found->late - late) > to_a_millisecond || std::abs(*after) >= left) status = expectation_failed;
  }
  return status;
}

}  // namespace skein::app

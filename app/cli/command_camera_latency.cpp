#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "app/calibration/calibration_file.h"
#include "app/cli/commands.h"
#include "app/run/exit_status.h"
#include "app/run/number_text.h"
#include "app/run/output.h"
#include "app/session/experiment_cameras.h"
#include "app/tools/camera_latency.h"
#include "app/tools/driven_plant.h"

namespace skein::app {
namespace {

std::string in_ms(double seconds) {
  return fixed(1e3 * seconds, 2) + " ms";
}

void print(const CameraLatency& camera, double corrected) {
  print_out(fmt::format("\ncamera: {}\nposes: {}\nrow: {:.0f}\n", camera.camera + 1, camera.poses, camera.row));
  if (std::isnan(camera.late)) return;
  print_out(fmt::format(
      "late: {}, of which {} are corrected already\nstandard_deviation: {}\nhalves: {}, {}\n"
      "scale: {:.4f}\nheading_rms: {:.2f} mrad\n",
      in_ms(corrected + camera.late), in_ms(corrected), in_ms(camera.sigma), in_ms(corrected + camera.halves[0]),
      in_ms(corrected + camera.halves[1]), camera.scale, 1e3 * camera.heading_rms));
}

/// What goes into the files: of a camera, and what the turns do not tell of it.
struct Told {
  double latency = none;   // camera.latency [s]
  double row_time = none;  // of its calibration; none: not requested, or not known [s]
  std::string doubt{};
};

/// `turns`: of one camera, by each robot.
Told tell(const std::vector<CameraLatency>& turns, const vision::Calibration& calibration, double corrected) {
  if (turns.size() == 1) return {corrected + turns[0].late, none, turns[0].doubt};
  const CameraRows rows = judge_rows(turns, calibration.row_time, calibration.height);
  if (!std::isnan(rows.row_time))
    print_out(
        fmt::format("row_time: {:.2f} us, standard deviation {:.2f} us (the calibration says {:.2f} us)\n"
                    "late: {} at the first row, standard deviation {}\n",
                    1e6 * rows.row_time, 1e6 * rows.row_time_sigma, 1e6 * calibration.row_time,
                    in_ms(corrected + rows.late), in_ms(rows.late_sigma)));
  return {corrected + rows.late, rows.row_time, rows.doubt};
}

/// Of a camera, from 0.
std::string latency_key(std::size_t camera) {
  return camera == 0 ? "camera.latency" : fmt::format("camera.also.{}.latency", camera);
}

/// Whether all that may be found could be saved; what prevents it is on stderr.
bool can_save(const CameraLatencyRequest& request, const Experiment& e) {
  KeyValues keys;
  for (std::size_t k = 0; k < e.cameras(); ++k) {
    keys.emplace_back(latency_key(k), "0.0");
    const std::filesystem::path calibration = e.calibration_file(k);
    if (request.robots.size() < 2 || calibration.empty()) continue;  // no row time is found, or it goes nowhere
    if (const auto possible = check_calibration_target(calibration); !possible) {
      complain(possible.error());
      return false;
    }
  }
  return can_save_keys(request.experiment.file, keys);
}

/// Into the camera's own calibration.
int save_row_time(const Experiment& e, std::size_t camera, double row_time) {
  const std::filesystem::path path = e.calibration_file(camera);
  if (path.empty()) return done;  // a synthetic camera
  auto calibration = load_calibration(path);
  if (calibration) {
    calibration->row_time = row_time;
    const auto old = replace_calibration(*calibration, path);
    if (old) {
      print_out(fmt::format("# saved in {}\n", path.string()));
      return done;
    }
    complain(old.error());
    return wrong_input;
  }
  complain_lines(calibration.error());
  return wrong_input;
}

}  // namespace

int camera_latency(const CameraLatencyRequest& request) {
  auto experiment = load(request.experiment);
  if (!experiment) return wrong_input;
  std::vector<std::size_t> robots;
  for (const std::size_t robot : request.robots) {
    if (robot < 1 || robot > experiment->robots.size()) {
      complain(fmt::format("--robot {}; allowed: 1 to {}", robot, experiment->robots.size()));
      return wrong_input;
    }
    if (!experiment->robots[robot - 1].has_link()) {
      complain(
          fmt::format("--robot {}: it has no link, so that there are no counters of its wheels to compare with; "
                      "allowed: a robot with a link",
                      robot));
      return wrong_input;
    }
    robots.push_back(robot - 1);
  }
  if (!can_read_calibrations(*experiment)) return wrong_input;
  if (request.save && !can_save(request, *experiment)) return wrong_input;
  const auto driven = DrivenPlant::open(with_links_of(std::move(*experiment), robots), {}, complain);
  if (!driven) {
    complain(driven.error());
    return device_failed;
  }
  const Experiment& e = (*driven)->experiment();
  std::vector<LatencyMeasurement> measured;
  for (const std::size_t robot : robots) {
    auto one = measure_latency((*driven)->plant(), (*driven)->clock(), e, robot, request.seconds,
                               [&] { return (*driven)->keep_on(); });
    if (!one) {
      (*driven)->close();
      complain(one.error());
      return device_failed;
    }
    measured.push_back(std::move(*one));
  }
  const bool stand = (*driven)->close();
  bool told = true;
  std::string table;
  KeyValues found;
  std::vector<std::pair<std::size_t, double>> row_times;
  double round_trip = 0.0;
  for (std::size_t k = 0; k < robots.size(); ++k) {
    const LatencyMeasurement& one = measured[k];
    print_out(fmt::format("{}\nturned: {:.1f} rad\ncounts: {}\nround_trip: {}\n", robot_name(e, robots[k]), one.turned,
                          one.counts, in_ms(one.round_trip)));
    round_trip = std::fmax(round_trip, one.round_trip);
    for (const CameraLatency& camera : one.cameras) print(camera, e.camera_at(camera.camera).latency);
  }
  for (std::size_t k = 0; k < e.cameras(); ++k) {
    std::vector<CameraLatency> turns;
    turns.reserve(measured.size());
    for (const LatencyMeasurement& one : measured) turns.push_back(one.cameras[k]);
    const auto calibration = camera_calibration(e, k);
    const Told of = tell(turns, calibration.value_or(vision::Calibration{}), e.camera_at(k).latency);
    if (!of.doubt.empty()) {
      complain(camera_prefix(e, k) + of.doubt);
      told = false;
      continue;
    }
    const std::string value = fmt::format("{:.4f}", of.latency);
    const bool first = k == 0;
    table += fmt::format("\n{}\nlatency = {}\n",
                         first ? "[camera]" : fmt::format("[[camera.also]]  # camera {}", k + 1), value);
    found.emplace_back(latency_key(k), value);
    if (std::isnan(of.row_time)) continue;
    const double row_time = 1e-8 * std::round(1e8 * of.row_time);
    table += fmt::format("\n[camera]  # in its calibration\nrow_time = {:.2f}e-6\n", 1e6 * row_time);
    row_times.emplace_back(k, row_time);
  }
  print_out(table);
  constexpr double much = 2e-3;
  if (round_trip > much)
    complain(
        fmt::format("the counters were read at some time within a round trip of {}; the middle is assumed, so "
                    "that the latency may be off by up to {}: a robot on a cable or WiFi tells more exactly",
                    in_ms(round_trip), in_ms(0.5 * round_trip)));
  if (request.save && !found.empty())
    if (const int saved = save_keys(request.experiment.file, found); saved != done) return saved;
  for (const auto& [camera, row_time] : row_times)
    if (request.save)
      if (const int saved = save_row_time(e, camera, row_time); saved != done) return saved;
  return !stand ? device_failed : told ? done : expectation_failed;
}

}  // namespace skein::app

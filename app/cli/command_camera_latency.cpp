#include <fmt/format.h>

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "app/cli/commands.h"
#include "app/run/exit_status.h"
#include "app/run/output.h"
#include "app/tools/camera_latency.h"
#include "app/tools/driven_plant.h"

namespace skein::app {
namespace {

std::string in_ms(double seconds) {
  return fmt::format("{:.2f} ms", 1e3 * seconds);
}

void print(const CameraLatency& camera, double corrected) {
  print_out(fmt::format("\ncamera: {}\nposes: {}\n", camera.camera + 1, camera.poses));
  if (std::isnan(camera.late)) return;
  print_out(fmt::format(
      "late: {}, of which {} are corrected already\nstandard_deviation: {}\nhalves: {}, {}\n"
      "scale: {:.4f}\nheading_rms: {:.2f} mrad\n",
      in_ms(corrected + camera.late), in_ms(corrected), in_ms(camera.sigma), in_ms(corrected + camera.halves[0]),
      in_ms(corrected + camera.halves[1]), camera.scale, 1e3 * camera.heading_rms));
}

}  // namespace

int camera_latency(const CameraLatencyRequest& request) {
  auto experiment = load(request.experiment);
  if (!experiment) return wrong_input;
  if (request.robot > experiment->robots.size()) {
    complain(fmt::format("--robot {}; allowed: 1 to {}", request.robot, experiment->robots.size()));
    return wrong_input;
  }
  const auto driven = DrivenPlant::open(with_links_of(std::move(*experiment), {request.robot - 1}), {}, complain);
  if (!driven) {
    complain(driven.error());
    return device_failed;
  }
  const Experiment& e = (*driven)->experiment();
  const auto measured = measure_latency((*driven)->plant(), (*driven)->clock(), e, request.robot - 1, request.seconds,
                                        [&] { return (*driven)->keep_on(); });
  const bool stand = (*driven)->close();
  if (!measured) {
    complain(measured.error());
    return device_failed;
  }
  print_out(fmt::format("{}\nturned: {:.1f} rad\ncounts: {}\nround_trip: {}\n", robot_name(e, request.robot - 1),
                        measured->turned, measured->counts, in_ms(measured->round_trip)));
  bool told = true;
  std::string table;
  std::vector<std::pair<std::string, std::string>> found;
  for (const CameraLatency& camera : measured->cameras) {
    const double corrected = e.camera_at(camera.camera).latency;
    print(camera, corrected);
    if (!camera.doubt.empty()) {
      complain(camera_prefix(e, camera.camera) + camera.doubt);
      told = false;
      continue;
    }
    const std::string value = fmt::format("{:.4f}", corrected + camera.late);
    const bool first = camera.camera == 0;
    table += fmt::format("\n{}\nlatency = {}\n",
                         first ? "[camera]" : fmt::format("[[camera.also]]  # camera {}", camera.camera + 1), value);
    found.emplace_back(first ? "camera.latency" : fmt::format("camera.also.{}.latency", camera.camera), value);
  }
  print_out(table);
  constexpr double much = 2e-3;
  if (measured->round_trip > much)
    complain(
        fmt::format("the counters were read at some time within a round trip of {}; the middle is assumed, so "
                    "that the latency may be off by up to {}: a robot on a cable or WiFi tells more exactly",
                    in_ms(measured->round_trip), in_ms(0.5 * measured->round_trip)));
  if (request.save && !found.empty())
    if (const int saved = save_keys(request.experiment.file, found); saved != done) return saved;
  return !stand ? device_failed : told ? done : expectation_failed;
}

}  // namespace skein::app

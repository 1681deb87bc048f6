#include <fmt/format.h>
#include <unistd.h>

#include <string>
#include <vector>

#include "app/calibration/calibration_file.h"
#include "app/cli/commands.h"
#include "app/doctor/camera_doctor.h"
#include "app/run/exit_status.h"
#include "app/run/interrupted.h"
#include "app/run/output.h"
#include "app/run/terminal_text.h"
#include "app/tools/camera_list.h"
#include "vision/sources/open_source.h"

namespace skein::app {
namespace {

/// The only camera there is; else complains.
std::string only_camera() {
  std::vector<std::string> all;
  for (const FoundCamera& camera : find_cameras().cameras) all.push_back(camera.address);
  if (all.size() == 1) return all.front();
  complain(all.empty() ? "no camera at /dev/video*, and none of GigE or USB3 Vision that answers"
                       : fmt::format("which camera? There are {}", fmt::join(all, ", ")));
  return {};
}

int describe_one(const std::string& camera) {
  // "/dev/video0" alone names a camera too.
  const auto address = vision::parse_source(camera.starts_with('/') ? "v4l2:" + camera : camera);
  if (!address || !address->kind->describe) {
    complain(fmt::format("{} is not a camera; allowed: {}", camera, vision::camera_forms()));
    return wrong_input;
  }
  const auto lines = address->kind->describe(address->where);
  if (!lines) {
    complain(lines.error());
    return device_failed;
  }
  for (const std::string& line : *lines) fmt::print("{}\n", shown(line));
  return done;
}

}  // namespace

int list_cameras(const std::string& camera) {
  if (!camera.empty()) return describe_one(camera);
  const FoundCameras found = find_cameras();
  for (const auto& [address, what] : found.cameras) fmt::print("{}: {}\n", shown(address), shown(what));
  if (!found.problem.empty()) complain(found.problem);
  if (!found.cameras.empty()) return done;
  complain("no camera at /dev/video*, and none of GigE or USB3 Vision that answers");
  return device_failed;
}

int camera_doctor(const CameraDoctorRequest& request) {
  // What is wrong with the words is said before any camera is looked for.
  if (request.source.empty())
    if (const auto options = request.words.read("v4l2:/dev/video0"); !options) {
      complain(options.error());
      return wrong_input;
    }
  if (!request.camera.empty())
    if (const auto calibration = load_calibration(request.camera); !calibration) {
      complain_lines(calibration.error());
      return wrong_input;
    }
  CameraCase wanted{.source = request.source};
  if (wanted.source.empty()) wanted.source = only_camera();
  if (wanted.source.empty()) return device_failed;
  const std::string wrong = wanted.source == "synthetic" ? std::string() : wrong_source(wanted.source);
  const auto options = request.words.read(wanted.source);
  if (!wrong.empty() || !options) {
    complain(!wrong.empty() ? wrong + ", synthetic" : options.error());
    return wrong_input;
  }
  wanted.options = *options;
  wanted.seconds = request.seconds;
  if (request.words.rate > 0.0) wanted.needed_rate = request.words.rate;
  wanted.options.rate = wanted.needed_rate;  // as a run asks for its own
  if (!request.camera.empty()) {
    auto calibration = load_calibration(request.camera);
    if (!calibration) {
      complain_lines(calibration.error());
      return wrong_input;
    }
    if (wanted.options.width == 0) {
      wanted.options.width = calibration->width;
      wanted.options.height = calibration->height;
    }
    wanted.options.readout = calibration->readout();
    wanted.calibration_file = request.camera;
    wanted.calibration = std::move(*calibration);
  }
  wanted.keep_going = [] { return !interrupted(); };
  const bool show_progress = isatty(STDERR_FILENO) != 0;
  if (show_progress) print_error(fmt::format("looking at {} for {:g} s", wanted.source, wanted.seconds));
  const auto report = examine_camera(wanted);
  if (show_progress) print_error_as_is("\r\033[K");
  if (!report) {
    complain(report.error());
    return device_failed;
  }
  bool ill = false;
  print_out(shown(report->camera) + "\n");
  for (const Finding& finding : report->findings) {
    print_out(as_line(finding));
    ill = ill || finding.state == Finding::State::ill;
  }
  print_out("\n" + report->table);
  return ill ? expectation_failed : done;
}

}  // namespace skein::app

#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>
#include <fstream>
#include <iostream>
#include <utility>

#include "app/calibration/calibration_file.h"
#include "app/cli/commands.h"
#include "app/run/exit_status.h"
#include "app/run/interrupted.h"
#include "app/run/output.h"
#include "vision/sources/open_source.h"
#include "vision/track/track.h"

namespace skein::app {

int track(const TrackRequest& request) {
  if (request.list_controls) {
    if (const auto camera = vision::parse_source(request.source); camera && camera->live())
      return list_cameras(request.source);
    print_error(fmt::format("skein: {} is not a camera; allowed with --list-controls: v4l2:DEVICE, aravis:CAMERA\n",
                            request.source));
    return wrong_input;
  }
  vision::TrackOptions options;
  const auto camera = request.words.read(request.source);
  if (const std::string wrong = wrong_source(request.source); !wrong.empty() || !camera) {
    complain(wrong.empty() ? camera.error() : wrong);
    return wrong_input;
  }
  options.camera = *camera;
  options.source = request.source;
  if (!request.camera.empty()) {
    auto calibration = load_calibration(request.camera);
    if (!calibration) {
      print_error(fmt::format("{}\n", calibration.error()));
      return wrong_input;
    }
    options.calibration = std::move(*calibration);
    const auto& [width, height] = std::pair(options.calibration->width, options.calibration->height);
    if (!request.words.size.empty() && (camera->width != width || camera->height != height)) {
      print_error(
          fmt::format("skein: --size {}: {} holds for {}x{}\n", request.words.size, request.camera, width, height));
      return wrong_input;
    }
  }
  std::ofstream file;
  if (!request.csv.empty()) {
    file.open(request.csv, std::ios::binary | std::ios::trunc);
    if (!file) {
      print_error(fmt::format("skein: {}: cannot be written\n", request.csv));
      return wrong_input;
    }
  }
  options.csv = request.csv.empty() ? &std::cout : &file;
  options.record = request.record;
  options.notes = {{"PROGRAM", "skein " SKEIN_VERSION}};
  if (options.calibration) options.notes["CALIBRATION"] = format_calibration(*options.calibration);
  const bool show_progress = !request.quiet && isatty(STDERR_FILENO) != 0;
  options.keep_going = [&](std::int64_t frames) {
    if (show_progress && frames > 0 && frames % 10 == 0) print_error(fmt::format("\r\033[K{} frames", frames));
    return !interrupted();
  };
  const auto summary = vision::track(options);
  if (show_progress) print_error("\r\033[K");
  if (!summary) {
    complain(summary.error());
    return device_failed;
  }
  for (const std::string& notice : summary->status.notices) complain(notice);
  if (summary->status.outages > 0) print_error(fmt::format("skein: the last outage: {}\n", summary->status.reason));
  if (!summary->other_family.empty()) complain(summary->other_family);
  for (const std::string& skipped : summary->skipped) print_error(fmt::format("skein: skipped {}\n", skipped));
  if (!request.quiet) {
    // With the rows on stdout the summary must not stand among them.
    std::FILE* out = request.csv.empty() ? stderr : stdout;
    fmt::print(out, "source: {}\nframes: {}\ndetections: {}\nids: {}\nskipped: {}\n", summary->source, summary->frames,
               summary->detections, fmt::join(summary->ids, " "), summary->skipped.size());
    if (vision::is_camera(request.source))
      fmt::print(out, "outages: {}\ndamaged: {}\npassed_over: {}\n", summary->status.outages, summary->status.damaged,
                 summary->status.passed_over);
    if (!request.record.empty())
      fmt::print(out, "recorded: {}\nnot_recorded: {}\n", summary->recording.written, summary->recording.dropped);
  }
  if (!summary->recording.problem.empty()) {
    complain(summary->recording.problem);
    return device_failed;
  }
  return done;
}

}  // namespace skein::app

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <string>
#include <utility>

#include "app/calibration/calibration_file.h"
#include "app/cli/command_calibrate.h"
#include "app/cli/commands.h"
#include "app/cli/same_file.h"
#include "app/run/clocks.h"
#include "app/run/exit_status.h"
#include "app/run/histogram.h"
#include "app/run/interrupted.h"
#include "app/run/output.h"
#include "app/run/terminal_text.h"
#include "core/words.h"
#include "vision/sources/open_source.h"
#include "vision/tags/tag_family.h"
#include "vision/track/track.h"
#include "vision/track/track_tracker.h"

namespace skein::app {
namespace {

/// A file that is emptied by the first byte that comes: a camera that is not there costs nobody an older table.
class ReplacingFile final : public std::filebuf {
 public:
  bool open_for(const std::string& path) {
    path_ = path;
    return open(path, std::ios::out | std::ios::app | std::ios::binary) != nullptr;
  }

 protected:
  std::streamsize xsputn(const char* text, std::streamsize size) override {
    make_empty();
    return std::filebuf::xsputn(text, size);
  }
  int_type overflow(int_type byte) override {
    make_empty();
    return std::filebuf::overflow(byte);
  }

 private:
  void make_empty() {
    if (std::error_code a_device_stays; !std::exchange(emptied_, true))
      std::filesystem::resize_file(path_, 0, a_device_stays);
  }
  std::string path_;
  bool emptied_ = false;
};

/// "" and the calibration in `options`, or what is wrong with it. A film that Skein has recorded brings its own.
std::string read_calibration(const TrackRequest& request, vision::TrackOptions& options) {
  if (!request.camera.empty()) {
    auto calibration = load_calibration(request.camera);
    if (!calibration) return calibration.error();
    options.calibration = std::move(*calibration);
    const auto& [width, height] = std::pair(options.calibration->width, options.calibration->height);
    if (!request.words.size.empty() && (options.camera.width != width || options.camera.height != height))
      return fmt::format("skein: --size {}: {} holds for {}x{}", request.words.size, request.camera, width, height);
    return {};
  }
  if (!request.tracker) return {};
  if (!vision::is_camera(request.source)) {
    const auto film = vision::open_source(request.source);
    if (!film) return "skein: " + film.error();
    if (const auto note = (*film)->notes().find("CALIBRATION"); note != (*film)->notes().end()) {
      auto calibration = parse_calibration(note->second, request.source);
      if (!calibration) return calibration.error();
      options.calibration = std::move(*calibration);
      return {};
    }
  }
  return "skein: --tracker places tags on the floor: give the camera's calibration with --camera CAL.TOML";
}

void report(const vision::TrackSummary& summary) {
  for (const std::string& notice : summary.status.notices) complain(notice);
  for (const std::string& remark : summary.status.remarks) complain(remark);
  if (summary.status.outages > 0) complain(fmt::format("the last outage: {}", summary.status.reason));
  if (!summary.why_no_tag.empty()) complain(summary.why_no_tag);
  for (const std::string& skipped : summary.skipped) complain(fmt::format("skipped {}", skipped));
}

void print_end(std::FILE* out, const TrackRequest& request, const vision::TrackSummary& summary) {
  if (vision::is_camera(request.source))
    fmt::print(out, "outages: {}\ndamaged: {}\npassed_over: {}\n", summary.status.outages, summary.status.damaged,
               summary.status.passed_over);
  if (!request.record.empty())
    fmt::print(out, "recorded: {}\nnot_recorded: {}\n", summary.recording.written, summary.recording.dropped);
}

/// The latencies of all frames, each with its name.
class Latencies {
 public:
  void add(const vision::FrameLatency& frame) {
    arrival_.add(frame.arrival);
    grey_.add(frame.grey);
    tracker_.add(frame.tracker);
    for (std::size_t k = 0; k < stages_.size() && frame.tracker >= 0.0; ++k) stages_[k].add(frame.stages[k]);
  }

  void print(std::FILE* out, bool live) const {
    fmt::print(out, "latency [ms]           median       p99   largest\n");
    const auto line = [&](std::string_view name, const Histogram& times) {
      if (times.total() == 0) return;
      fmt::print(out, "  {:<18}{:>9.3f} {:>9.3f} {:>9.3f}\n", name, 1e3 * times.quantile(0.5),
                 1e3 * times.quantile(0.99), 1e3 * times.largest());
    };
    line("capture to arrival", arrival_);
    line(live ? "arrival to grey" : "reading", grey_);
    line("grey to poses", tracker_);
    for (const vision::TrackerStage stage : core::all_of<vision::TrackerStage>())
      line(fmt::format("  {}", word(stage)), stages_[static_cast<std::size_t>(stage)]);
  }

 private:
  Histogram arrival_, grey_, tracker_;
  std::array<Histogram, vision::tracker_stages> stages_;
};

void print_counters(std::FILE* out, const vision::TrackTrackerSummary& summary) {
  const vision::TrackerCounters& counters = summary.counters;
  const auto part = [&](const char* name, std::int64_t count, const char* what) {
    fmt::print(out, "  {:<12}{:>8}  {}\n", name, count, what);
  };
  fmt::print(out, "source: {}\nframes: {}\nfollowed: {}\nids: {}\nposes: {}\n", shown(summary.track.source),
             summary.track.frames, fmt::join(summary.followed, " "), fmt::join(summary.track.ids, " "),
             summary.track.detections);
  part("detected", summary.detected, "for the first time");
  part("tracked", summary.tracked, "where they were expected");
  part("recovered", summary.recovered, "after they were lost");
  fmt::print(out, "lost: {}\nrejected: {}\n", summary.lost, counters.rejected);
  part("misshapen", counters.misshapen, "not lying flat at [tags] height, or not of its size");
  part("unlike", counters.unlike, "not like that tag's image: covered, blurred, or none at all");
  part("odd", counters.odd, "larger than the other tags");
  part("lifted", counters.lifted, "nearer to the camera than before");
  fmt::print(out, "seen_twice: {}\ndecoded: {}\nfits: {}\nfailed_fits: {}\n", counters.ghosts, counters.decoded,
             counters.fits, counters.failed_fits);
  fmt::print(out, "searches: {} of the full frame, {} of a part, {} windows, {} by the gate\n", counters.full_searches,
             counters.part_searches, counters.windows, counters.gates);
  fmt::print(out, "skipped: {}\n", summary.track.skipped.size());
}

}  // namespace

int track(const TrackRequest& request) {
  if (request.list_controls) {
    if (const auto camera = vision::parse_source(request.source); camera && camera->live())
      return list_cameras(request.source);
    complain(
        fmt::format("{} is not a camera; allowed with --list-controls: v4l2:DEVICE, aravis:CAMERA", request.source));
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
  const std::vector<int> tags = parse_ids(request.tags);
  if (!request.tags.empty() &&
      (tags.empty() || std::any_of(tags.begin(), tags.end(), [](int id) { return id > vision::largest_tag; }))) {
    complain(fmt::format("--tags {}; allowed: tags of the family 36h11, 0 to {}, such as 1-4,7", request.tags,
                         vision::largest_tag));
    return wrong_input;
  }
  if (const std::string wrong = read_calibration(request, options); !wrong.empty()) {
    print_error(wrong + "\n");
    return wrong_input;
  }
  if (options.calibration) options.camera.readout = options.calibration->readout();
  if (request.tracker && !options.calibration->world_from_camera) {
    complain(fmt::format("{} has no world frame, which --tracker needs: skein calibrate floor", request.camera));
    return wrong_input;
  }
  ReplacingFile replacing;
  std::ostream file(&replacing);
  if (!request.csv.empty()) {
    for (const std::string& input : {request.camera, request.source.substr(request.source.find(':') + 1)})
      if (same_file(request.csv, input)) {
        complain(fmt::format("{}: is a file that is read, allowed: another name", request.csv));
        return wrong_input;
      }
    errno = 0;
    if (!replacing.open_for(request.csv)) {
      complain(fmt::format("{}: cannot be written: {}", request.csv, std::strerror(errno)));
      return wrong_input;
    }
  }
  options.csv = request.csv.empty() ? &std::cout : &file;
  options.record = request.record;
  options.notes = {{"PROGRAM", "skein " SKEIN_VERSION}};
  if (options.calibration) options.notes["CALIBRATION"] = format_calibration(*options.calibration);
  const bool show_progress = !request.quiet && isatty(STDERR_FILENO) != 0;
  options.keep_going = [&](std::int64_t frames) {
    if (show_progress && frames > 0 && frames % 10 == 0) print_error_as_is(fmt::format("\r\033[K{} frames", frames));
    return !interrupted();
  };

  tl::expected<vision::TrackTrackerSummary, std::string> summary;
  Latencies latencies;
  if (request.tracker) {
    vision::TrackTrackerOptions with_tracker{.track = options, .tags = tags, .clock = monotonic_seconds};
    with_tracker.crops = request.crops;
    with_tracker.latency = [&](const vision::FrameLatency& frame) { latencies.add(frame); };
    with_tracker.tell = [&](const std::string& sentence) {
      if (show_progress) print_error_as_is("\r\033[K");
      complain(sentence);
    };
    summary = vision::track_with_tracker(with_tracker);
  } else {
    auto plain = vision::track(options);
    if (plain)
      summary->track = std::move(*plain);
    else
      summary = tl::unexpected(plain.error());
  }
  if (show_progress) print_error_as_is("\r\033[K");
  if (!summary) {
    complain(summary.error());
    return device_failed;
  }
  report(summary->track);
  if (!request.quiet) {
    // With the rows on stdout the summary must not stand among them.
    std::FILE* out = request.csv.empty() ? stderr : stdout;
    if (request.tracker)
      print_counters(out, *summary);
    else
      fmt::print(out, "source: {}\nframes: {}\ndetections: {}\nids: {}\nskipped: {}\n", shown(summary->track.source),
                 summary->track.frames, summary->track.detections, fmt::join(summary->track.ids, " "),
                 summary->track.skipped.size());
    print_end(out, request, summary->track);
    if (request.tracker) latencies.print(out, vision::is_camera(request.source));
  }
  if (!summary->track.recording.problem.empty()) {
    complain(summary->track.recording.problem);
    return device_failed;
  }
  return done;
}

}  // namespace skein::app

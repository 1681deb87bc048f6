#include "vision/track/track.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <ostream>
#include <tuple>

#include "vision/detector/detector.h"
#include "vision/diagnosis/diagnosis.h"
#include "vision/frames/frame.h"
#include "vision/sources/open_source.h"
#include "vision/tags/detection.h"
#include "vision/tags/tag_plane.h"
#include "vision/tags/tag_pose.h"

namespace skein::vision {
namespace {

/// A row of the table, put together in one buffer that is used for all of them.
class Row {
 public:
  void text(std::string_view value) {
    separate();
    if (value.find_first_of(",\"\n\r") == std::string_view::npos) {
      line_ += value;
      return;
    }
    line_ += '"';
    for (const char c : value) line_.append(c == '"' ? 2 : 1, c);
    line_ += '"';
  }
  void empty() { separate(); }
  template <typename Number>
  void number(Number value) {
    separate();
    char digits[32];  // the shortest text that reads back to the same double has at most 24
    const auto end = std::to_chars(std::begin(digits), std::end(digits), value).ptr;
    line_.append(digits, end);
  }
  void end(std::ostream& out) {
    line_ += '\n';
    out << line_;
    line_.clear();
  }

 private:
  void separate() {
    if (!line_.empty()) line_ += ',';
  }
  std::string line_;
};

/// Detections have no memory; this says which of them go on from the frame before.
class Memory {
 public:
  How how(const Detection& detection, std::int64_t frame) {
    double u = 0.0;
    double v = 0.0;
    for (const auto& corner : detection.corners) {
      u += corner[0] / 4.0;
      v += corner[1] / 4.0;
    }
    const double edge = std::hypot(detection.corners[1][0] - detection.corners[0][0],
                                   detection.corners[1][1] - detection.corners[0][1]);
    std::vector<Seen>& places = seen_[detection.tag];
    How answer = places.empty() ? How::detected : How::recovered;
    for (const Seen& place : places) {
      // Two edges from frame to frame: a robot at full speed needs a tenth of that at 25 frames/s.
      if (place.frame == frame - 1 && std::hypot(place.u - u, place.v - v) < 2.0 * edge) answer = How::tracked;
    }
    // Copies of one id in this frame are news to each other; what is older than the last frame has been answered for.
    if (answer == How::recovered &&
        std::all_of(places.begin(), places.end(), [&](const Seen& place) { return place.frame == frame; })) {
      answer = How::detected;
    }
    std::erase_if(places, [&](const Seen& place) { return place.frame < frame - 1; });
    places.push_back({frame, u, v});
    return answer;
  }

 private:
  struct Seen {
    std::int64_t frame;
    double u;
    double v;
  };
  std::map<int, std::vector<Seen>> seen_;
};

/// Searching at half resolution is 3 to 4 times faster and loses tags under 16 px. Pictures are few and often show
/// small tags; of a film with many pixels the tags have many, too; a camera whose geometry is known says how large its
/// tags are.
double choose_decimate(const TrackOptions& options, const FrameSource& source, const Frame& frame) {
  if (options.decimate > 0.0) return options.decimate;
  if (source.stills()) return 1.0;
  if (static_cast<double>(frame.width) * frame.height >= 1.5e6) return 2.0;
  return is_camera(options.source) && options.calibration ? decimate_for_edge(tag_edge_px(*options.calibration)) : 1.0;
}

/// Pictures have time: at half the resolution AprilTag finds tags that it misses at full resolution (large ones on
/// textured paper), and the other way round. Those of both, each once, in TagDetector's order.
std::vector<Detection> with_large_tags(std::vector<Detection> found, const Frame& frame, TagDetector& detector) {
  const std::size_t before = found.size();
  detector.set_decimate(2.0);
  for (const Detection& detection : detector.detect(frame)) {
    const bool known =
        std::any_of(found.begin(), found.begin() + static_cast<std::ptrdiff_t>(before), [&](const auto& other) {
          const double edge =
              std::hypot(other.corners[1][0] - other.corners[0][0], other.corners[1][1] - other.corners[0][1]);
          const double apart =
              std::hypot(other.corners[0][0] - detection.corners[0][0], other.corners[0][1] - detection.corners[0][1]);
          return other.tag == detection.tag && apart < 0.5 * edge;
        });
    if (!known) found.push_back(detection);
  }
  std::sort(found.begin(), found.end(), [](const Detection& a, const Detection& b) {
    return std::tie(a.tag, a.corners) < std::tie(b.tag, b.corners);
  });
  return found;
}

void write_header(std::ostream& csv, bool calibrated) {
  csv << "frame,source,t,tag,u1,v1,u2,v2,u3,v3,u4,v4," << (calibrated ? "x,y,theta,sigma_xy,sigma_theta," : "")
      << "how\n";
}

void write_row(std::ostream& csv, Row& row, const TrackOptions& options, const Frame& frame, const Detection& detection,
               How how) {
  row.number(frame.index);
  row.text(frame.source);
  double middle = 0.0;
  for (const auto& corner : detection.corners) middle += 0.25 * corner[1];
  row.number(frame.captured_at + (options.calibration ? options.calibration->row_time * middle : 0.0));
  row.number(detection.tag);
  for (const auto& corner : detection.corners) {
    row.number(corner[0]);
    row.number(corner[1]);
  }
  if (options.calibration) {
    if (const auto place = place_on_plane(*options.calibration, detection.corners)) {
      const PoseSigma sigma = pose_sigma(*place, corner_sigma_px);
      for (const double value : {place->pose.x, place->pose.y, place->pose.theta, sigma.xy, sigma.theta})
        row.number(value);
    } else {
      for (int i = 0; i < 5; ++i) row.empty();
    }
  }
  row.text(word(how));
  row.end(csv);
}

tl::expected<std::unique_ptr<Recorder>, std::string> open_recorder(const TrackOptions& options) {
  if (options.record.empty()) return nullptr;
  FilmNotes notes = options.notes;
  notes["SOURCE"] = options.source;
  return Recorder::open(options.record, notes);
}

}  // namespace

tl::expected<TrackSummary, std::string> track(const TrackOptions& options) {
  SourceOptions wanted = options.camera;
  if (options.keep_going) wanted.keep_waiting = [&] { return options.keep_going(-1); };
  if (options.calibration) {
    wanted.width = options.calibration->width;
    wanted.height = options.calibration->height;
  }
  auto source = open_source(options.source, wanted);
  if (!source) return tl::unexpected(source.error());
  auto recorder = open_recorder(options);
  if (!recorder) return tl::unexpected(recorder.error());
  const bool live = is_camera(options.source);

  TrackSummary summary;
  summary.source = (*source)->describe();
  TagDetector detector;
  Frame frame;
  Row row;
  Memory memory;
  if (options.csv != nullptr) write_header(*options.csv, options.calibration.has_value());

  while (options.max_frames == 0 || summary.frames < options.max_frames) {
    const auto more = (*source)->read(frame);
    if (!more) return tl::unexpected(more.error());
    if (!*more) break;
    if (options.calibration &&
        (frame.width != options.calibration->width || frame.height != options.calibration->height)) {
      return tl::unexpected(fmt::format("frame {} ({}) of {} is {}x{} px, but the calibration holds for {}x{}",
                                        frame.index, frame.source, summary.source, frame.width, frame.height,
                                        options.calibration->width, options.calibration->height));
    }
    detector.set_decimate(choose_decimate(options, **source, frame));
    const std::vector<Detection>& at_once = detector.detect(frame);
    const bool again = options.decimate == 0.0 && (*source)->stills();
    for (const Detection& detection : again ? with_large_tags(at_once, frame, detector) : at_once) {
      const How how = memory.how(detection, frame.index);
      if (options.csv != nullptr) write_row(*options.csv, row, options, frame, detection, how);
      ++summary.detections;
      const auto place = std::lower_bound(summary.ids.begin(), summary.ids.end(), detection.tag);
      if (place == summary.ids.end() || *place != detection.tag) summary.ids.insert(place, detection.tag);
    }
    if (*recorder && live) (*recorder)->offer(frame);
    if (*recorder && !live) (*recorder)->add(frame);
    ++summary.frames;
    if (options.csv != nullptr && !*options.csv) return tl::unexpected(std::string("the CSV cannot be written"));
    if (options.keep_going && !options.keep_going(summary.frames)) break;
  }

  if (summary.frames > 0 && summary.detections == 0) summary.other_family = other_family(frame);
  if (*recorder) summary.recording = (*recorder)->finish();
  if (options.csv != nullptr && !options.csv->flush()) return tl::unexpected(std::string("the CSV cannot be written"));
  summary.status = (*source)->status();
  const auto skipped = (*source)->skipped();
  summary.skipped.assign(skipped.begin(), skipped.end());
  if (summary.frames == 0 && !summary.skipped.empty()) {
    return tl::unexpected(
        fmt::format("{}: none of its images can be read: {}", summary.source, fmt::join(summary.skipped, "; ")));
  }
  return summary;
}

}  // namespace skein::vision

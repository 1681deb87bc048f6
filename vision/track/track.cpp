#include "vision/track/track.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "vision/detector/detector.h"
#include "vision/diagnosis/diagnosis.h"
#include "vision/frames/frame.h"
#include "vision/sources/open_source.h"
#include "vision/tags/detection.h"
#include "vision/tags/tag_plane.h"
#include "vision/tags/tag_pose.h"
#include "vision/track/track_parts.h"

namespace skein::vision {
namespace {

/// Detections have no memory; this says which of them continue from the previous frame.
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
std::vector<Detection> find_tags(TagDetector& detector, const TrackOptions& options, const FrameSource& source,
                                 const Frame& frame) {
  if (options.decimate == 0.0 && source.stills()) return detect_at_both(detector, frame);
  double decimate = options.decimate;
  if (decimate <= 0.0) {
    if (static_cast<double>(frame.width) * frame.height >= 1.5e6)
      decimate = 2.0;
    else
      decimate =
          is_camera(options.source) && options.calibration ? decimate_for_edge(tag_edge_px(*options.calibration)) : 1.0;
  }
  detector.set_decimate(decimate);
  return detector.detect(frame);
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
  auto recorder = detail::open_recorder(options.record, options.notes, options.source);
  if (!recorder) return tl::unexpected(recorder.error());
  const bool live = is_camera(options.source);

  TrackSummary summary;
  summary.source = (*source)->describe();
  TagDetector detector;
  Frame frame;
  detail::Table table(options.csv, options.calibration);
  Memory memory;

  while (options.max_frames == 0 || summary.frames < options.max_frames) {
    const auto more = (*source)->read(frame);
    if (!more) return tl::unexpected(more.error());
    if (!*more) break;
    if (const std::string wrong = detail::wrong_size(frame, summary.source, options.calibration); !wrong.empty())
      return tl::unexpected(wrong);
    for (const Detection& detection : find_tags(detector, options, **source, frame)) {
      const How how = memory.how(detection, frame.index);
      table.add(frame, detection, how);
      ++summary.detections;
      detail::insert(summary.ids, detection.tag);
    }
    if (*recorder && live) (*recorder)->offer(frame);
    if (*recorder && !live) (*recorder)->add(frame);
    ++summary.frames;
    if (!table.well()) return tl::unexpected(std::string("the CSV cannot be written"));
    if (options.keep_going && !options.keep_going(summary.frames)) break;
  }

  if (summary.frames > 0 && summary.detections == 0) summary.why_no_tag = why_no_tag(frame);
  if (*recorder) summary.recording = (*recorder)->finish();
  if (!table.finish()) return tl::unexpected(std::string("the CSV cannot be written"));
  summary.status = (*source)->status();
  summary.skipped.assign((*source)->skipped().begin(), (*source)->skipped().end());
  if (const std::string problem = detail::nothing_read(**source, summary.frames); !problem.empty())
    return tl::unexpected(problem);
  return summary;
}

}  // namespace skein::vision

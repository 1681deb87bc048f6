#include "vision/tracker.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>
namespace skein::vision {
namespace {

struct Velocity {
  double x = 0.0;  // [m/s]
  double y = 0.0;
};

/// A wanted tag: what is known from the frames before and what this frame has shown.
struct Wanted {
  int tag = 0;
  bool ever_seen = false;
  bool following = false;  // seen in the last frame, or lost so recently that its window is still worth a look
  core::Pose last;         // where it was last seen
  double last_seen_at = 0.0;
  int missed = 0;  // frames since
  Velocity velocity;
  double edge_px = 0.0;

  // of this frame
  bool found = false;
  bool in_window = false;
  bool ghost = false;
  Detection detection;
  TagOnPlane place;
};

// A window that follows a lost tag for longer than this has grown so large that the full search is as good. [s]
constexpr double follow_for = 0.5;

// min_white_black_diff: the less is asked for, the more of the floor's texture must be looked at. A full search that
// wants 40 grey levels takes a third of the time of one that wants 5, which only dim rooms need.
constexpr double well_lit = 40.0;
constexpr double dim = 5.0;

double centre_distance(const Detection& a, const Detection& b) {
  double du = 0.0;
  double dv = 0.0;
  for (std::size_t i = 0; i < 4; ++i) {
    du += a.corners[i][0] - b.corners[i][0];
    dv += a.corners[i][1] - b.corners[i][1];
  }
  return std::hypot(du, dv) / 4.0;
}

}  // namespace

struct TagTracker::Parts {
  Calibration calibration;
  TrackerOptions options;
  TagDetector detector;
  double decimate = 1.0;
  std::vector<Wanted> wanted;
  std::vector<TagPose> poses;
  TrackerCounters counters;
  std::int64_t last_search = 0;    // number of the frame last searched as a whole
  double least_margin = well_lit;  // of the bits of the tags last seen: half of what is between their ink and paper
  bool dim_turn = false;           // the next search for a missing tag is the one for dim light

  Parts(Calibration c, TrackerOptions o)
      : calibration(std::move(c)), options(std::move(o)), detector(DetectorOptions{.threads = options.threads}) {
    for (const int tag : options.tags) {
      const bool repeated =
          std::any_of(wanted.begin(), wanted.end(), [&](const Wanted& other) { return other.tag == tag; });
      if (!repeated) wanted.emplace_back().tag = tag;
    }
    poses.reserve(wanted.size());
    decimate = decimate_for_edge(tag_edge_px(calibration));
  }

  void follow(const Frame& frame);
  bool should_search() const;
  void search(const Frame& frame);
  void consider(Wanted& tag, const Detection& detection, bool in_window);
  void conclude(const Frame& frame);
};

TagTracker::TagTracker(Calibration calibration, TrackerOptions options) {
  if (!calibration.world_from_camera) throw std::invalid_argument("TagTracker: the calibration has no world frame");
  parts_ = std::make_unique<Parts>(std::move(calibration), std::move(options));
}

TagTracker::~TagTracker() = default;
TagTracker::TagTracker(TagTracker&&) noexcept = default;
TagTracker& TagTracker::operator=(TagTracker&&) noexcept = default;

const TrackerCounters& TagTracker::counters() const {
  return parts_->counters;
}

const std::vector<TagPose>& TagTracker::process(const Frame& frame) {
  Parts& parts = *parts_;
  parts.poses.clear();
  ++parts.counters.frames;
  if (frame.width != parts.calibration.width || frame.height != parts.calibration.height) {
    ++parts.counters.wrong_frames;
    return parts.poses;
  }
  for (Wanted& tag : parts.wanted) tag.found = tag.in_window = tag.ghost = false;
  parts.follow(frame);
  if (parts.should_search()) parts.search(frame);
  parts.conclude(frame);
  return parts.poses;
}

/// Looks for every tag that was seen lately in a window around where it should be by now.
void TagTracker::Parts::follow(const Frame& frame) {
  detector.set_decimate(decimate);
  detector.set_min_white_black_diff(static_cast<int>(dim));  // a window is small enough for it
  for (Wanted& tag : wanted) {
    if (!tag.following) continue;
    const double elapsed = std::clamp(frame.captured_at - tag.last_seen_at, 0.0, follow_for);
    const auto centre = pixel_from_world(calibration, {tag.last.x + tag.velocity.x * elapsed,
                                                       tag.last.y + tag.velocity.y * elapsed, calibration.tag_height});
    if (!centre) continue;
    // The prediction's error: at most as far as the robot could go since, were it to turn back at once.
    const double px_per_metre = tag.edge_px / calibration.tag_size;
    const double half = options.window / 2.0 * tag.edge_px + options.max_speed * elapsed * px_per_metre;
    const int left = static_cast<int>(std::floor(centre->x() - half));
    const int top = static_cast<int>(std::floor(centre->y() - half));
    const int size = static_cast<int>(std::ceil(2.0 * half));
    for (const Detection& detection : detector.detect(frame, {left, top, size, size})) {
      if (detection.tag == tag.tag) consider(tag, detection, /*in_window=*/true);
    }
  }
}

bool TagTracker::Parts::should_search() const {
  if (wanted.empty()) return false;
  if (counters.full_searches == 0) return true;
  const std::int64_t since = counters.frames - last_search;
  bool missing = false;
  for (const Wanted& tag : wanted) {
    if (tag.found || tag.ghost) continue;
    missing = true;
    if (tag.following && tag.missed == 0 && since > 1) return true;  // lost in this very frame: look at once
  }
  return since >= (missing ? options.search_every : options.audit_every);
}

void TagTracker::Parts::search(const Frame& frame) {
  const bool missing = std::any_of(wanted.begin(), wanted.end(), [](const Wanted& tag) { return !tag.found; });
  detector.set_min_white_black_diff(
      static_cast<int>(missing && dim_turn ? dim : std::clamp(least_margin, dim, well_lit)));
  dim_turn = missing && !dim_turn;
  last_search = counters.frames;
  ++counters.full_searches;
  for (const Detection& detection : detector.detect(frame)) {
    for (Wanted& tag : wanted) {
      if (tag.tag == detection.tag) consider(tag, detection, /*in_window=*/false);
    }
  }
}

/// One sighting of a wanted tag: the first is kept, a second one elsewhere makes it a ghost.
void TagTracker::Parts::consider(Wanted& tag, const Detection& detection, bool in_window) {
  const std::optional<TagOnPlane> place = place_on_plane(calibration, detection.corners);
  if (!place || std::abs(place->edge / calibration.tag_size - 1.0) > options.shape_tolerance ||
      place->misfit > 0.5 * options.shape_tolerance * place->edge) {
    ++counters.rejected;
    return;
  }
  const double edge_px = place->edge / place->metres_per_px;
  if (!tag.found) {
    tag.found = true;
    tag.in_window = in_window;
    tag.detection = detection;
    tag.place = *place;
    tag.edge_px = edge_px;
  } else if (centre_distance(tag.detection, detection) > 0.5 * edge_px) {
    tag.ghost = true;
  }
}

void TagTracker::Parts::conclude(const Frame& frame) {
  double margin = 255.0;
  for (Wanted& tag : wanted) {
    if (tag.ghost) {
      // Which of the two is the robot? Nobody knows: none is reported, and only a full search that finds one ends it.
      ++counters.ghosts;
      tag.following = false;
      tag.velocity = {};
      continue;
    }
    const double elapsed = frame.captured_at - tag.last_seen_at;
    if (!tag.found) {
      ++tag.missed;
      tag.following = tag.following && elapsed >= 0.0 && elapsed < follow_for;
      continue;
    }
    const core::Pose& pose = tag.place.pose;
    tag.velocity = {};
    if (tag.following && elapsed > 1e-4 && elapsed < follow_for) {
      tag.velocity = {(pose.x - tag.last.x) / elapsed, (pose.y - tag.last.y) / elapsed};
      const double speed = std::hypot(tag.velocity.x, tag.velocity.y);
      // Carried by hand, or put elsewhere: no prediction then.
      if (speed > options.max_speed) tag.velocity = {};
    }
    const PoseSigma sigma = pose_sigma(tag.place, options.corner_sigma);
    const How how = !tag.ever_seen ? How::detected : tag.in_window ? How::tracked : How::recovered;
    poses.push_back({tag.tag, pose, frame.captured_at, sigma.xy, sigma.theta, how, tag.detection.corners});
    ++counters.poses;
    margin = std::min(margin, tag.detection.decision_margin);
    tag.missed = 0;
    tag.last = pose;
    tag.last_seen_at = frame.captured_at;
    tag.ever_seen = tag.following = true;
  }
  if (!poses.empty()) least_margin = margin;
}

}  // namespace skein::vision

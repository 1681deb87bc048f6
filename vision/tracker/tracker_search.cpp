// How the tracker finds tags that it cannot follow: AprilTag, on as little of the frame as will do.
#include <algorithm>
#include <cmath>

#include "vision/tracker/tracker_parts.h"

namespace skein::vision {
namespace {

using detail::Gate;

// min_white_black_diff: the lower it is, the more of the floor's texture must be examined. A full search that wants 40
// grey levels takes a third of the time of one that wants 5, which only dim rooms need.
constexpr double well_lit = 40.0;
constexpr double dim = 5.0;

// Of noise, below which neither the gate nor AprilTag need look.
constexpr double above_noise = 2.5;

// Windows that AprilTag may search in one frame for the sake of missing tags (60 us each), and for the audit.
constexpr int most_windows = 32;
constexpr int most_old_windows = 2;
constexpr int most_audit_windows = 1;

// The audit looks again at places that it has looked at in vain, one at a time, this often: no divisor in common with
// the number of its strips, so that each has its turn. [frames]
constexpr int recheck_every = 26;

// Keeps the list of such places short where robots with unwanted tags drive about. [frames]
constexpr std::int64_t forget_after = 500;

// Two tags side by side are an edge apart and two papers' widths: what the gate sees nearer to one is the tag itself.
constexpr double beside = 0.9;  // [edges]

// A tag that the picture's border cuts, where another camera sees it, is whole in this picture only if the two
// calibrations differ by as much as is cut off: AprilTag looks for it this often. [frames]
constexpr std::int64_t cut_every = 8;

constexpr int dim_every = 2;  // [times round all parts]

// A detector's small corner errors must not pass for a tag out of shape; the fit is the one to say so.
constexpr double detector_tolerance = 0.25;

// Noise leaves no more of the correlation of tags under 1.6 px a module; texture that decodes has a half.
constexpr double most_likeness = 0.97;
constexpr double least_of_tiny = 0.85;

Gate::Place place_of(const Corners& corners) {
  const Eigen::Vector2d middle = middle_of(corners);
  return {middle.x(), middle.y()};
}

double distance(const Gate::Place& a, const Gate::Place& b) {
  return std::hypot(a.u - b.u, a.v - b.v);
}

Window square_around(double u, double v, double half) {
  const int size = static_cast<int>(std::ceil(2.0 * half));
  return {static_cast<int>(std::floor(u - half)), static_cast<int>(std::floor(v - half)), size, size};
}

}  // namespace

bool TrackerParts::missing() const {
  return std::any_of(wanted.begin(), wanted.end(), [](const WantedTag& tag) { return tag.missing(); });
}

/// Both thresholds follow the light: they are parts of the contrast that tags had when they were last seen, but not so
/// low that noise would pass them everywhere.
int TrackerParts::gate_threshold() const {
  constexpr double least = 4.0, most = 60.0;
  return static_cast<int>(contrast ? std::clamp(0.35 * *contrast, std::clamp(above_noise * noise, least, most), most)
                                   : most);
}

int TrackerParts::detector_threshold() const {
  if (!contrast) return static_cast<int>(well_lit);
  return static_cast<int>(std::clamp(0.4 * *contrast, std::clamp(above_noise * noise, dim, well_lit), well_lit));
}

void TrackerParts::list_known() {
  known.clear();
  for (const WantedTag& tag : wanted)
    if (tag.found) known.push_back({place_of(tag.pose.corners), beside * tag.edge_px});
}

/// A tag that another camera sees may be in this picture too, or enter it: it is fitted where that camera sees it, and
/// if the two calibrations differ by too much for that, AprilTag looks around there. One that should be in the picture
/// and is not there is missing like any other: one of the cameras may have been moved.
void TrackerParts::enter(const Frame& frame) {
  for (WantedTag& tag : wanted) {
    if (tag.found || tag.ambiguous || !tag.elsewhere) continue;
    const auto centre = pixel_from_world(calibration, {tag.elsewhere->x, tag.elsewhere->y, calibration.tag_height});
    if (!centre || centre->x() < 0.0 || centre->y() < 0.0 || centre->x() >= frame.width || centre->y() >= frame.height)
      continue;
    const detail::Fit fit = fitter.fit(frame, tag.model, *tag.elsewhere);
    switch (fit.verdict) {
      case detail::FitVerdict::good:
        ++counters.fits;
        tag.predicted = true;
        accept(tag, frame, fit);
        continue;
      case detail::FitVerdict::outside:
        ++counters.failed_fits;
        if ((counters.frames + tag.tag) % cut_every != 0) continue;  // a few tags in each frame, not all in one
        break;
      case detail::FitVerdict::unlike:
      case detail::FitVerdict::misshapen:
        ++counters.failed_fits;
        tag.elsewhere.reset();
        break;
    }
    ++counters.windows;
    detector.set_decimate(decimate);
    detector.set_min_white_black_diff(detector_threshold());
    for (const Detection& detection :
         detector.detect(frame, square_around(centre->x(), centre->y(), 0.5 * options.window * edge_px)))
      if (detection.tag == tag.tag) consider(tag, frame, detection, /*predicted=*/true);
  }
}

/// Looks for every tag that was followed and has just been lost in a window around where it should be by now.
void TrackerParts::look_nearby(const Frame& frame) {
  for (WantedTag& tag : wanted) {
    if (!tag.following || tag.found || tag.elsewhere) continue;
    const core::Pose expected = predict(tag, frame.captured_at);
    const auto centre = pixel_from_world(calibration, {expected.x, expected.y, calibration.tag_height});
    if (!centre) continue;
    // The prediction's error: at most as far as the robot could go since, were it to turn back at once.
    const double elapsed = std::max(0.0, frame.captured_at - tag.last_seen_at);
    const double reach = options.max_speed * elapsed * tag.edge_px / calibration.tag_size;
    const double half = options.window / 2.0 * tag.edge_px + std::min(reach, 2.0 * tag.edge_px);
    ++counters.windows;
    detector.set_decimate(decimate);
    detector.set_min_white_black_diff(detector_threshold());
    for (const Detection& detection : detector.detect(frame, square_around(centre->x(), centre->y(), half)))
      if (detection.tag == tag.tag) consider(tag, frame, detection, /*predicted=*/true);
  }
}

/// One sighting of a wanted tag by AprilTag: the first is kept, a second one elsewhere makes it a ghost.
void TrackerParts::consider(WantedTag& tag, const Frame& frame, const Detection& detection, bool predicted) {
  ++counters.decoded;
  const std::optional<TagOnPlane> place = place_on_plane(calibration, detection.corners);
  if (!place) {
    reject(counters.misshapen);
    return;
  }
  const double seen_edge_px = place->edge / place->metres_per_px;
  if (tag.found) {
    if (distance(place_of(tag.pose.corners), place_of(detection.corners)) > 0.5 * seen_edge_px) tag.ghost = true;
    return;
  }
  const double off = std::abs(place->edge / calibration.tag_size - 1.0);
  if (off > detector_tolerance || place->misfit > 0.5 * detector_tolerance * place->edge) {
    reject(counters.misshapen);
    return;
  }
  const detail::Fit fit = fitter.fit(frame, tag.model, place->pose);
  bool cut_off = false;
  switch (fit.verdict) {
    case detail::FitVerdict::misshapen:
      reject(counters.misshapen);
      return;
    case detail::FitVerdict::good:
      ++counters.fits;
      tag.predicted = predicted;
      accept(tag, frame, fit);
      return;
    case detail::FitVerdict::outside:
      cut_off = true;
      break;
    case detail::FitVerdict::unlike:
      break;
  }
  tag.predicted = predicted;
  ++counters.failed_fits;
  // AprilTag's own word, if it is a clear one, where the picture cuts the white border off, so that nothing can be
  // fitted, and where modules are so small that blur makes all tags alike: then only the bits tell which it is.
  const double needed = fitter.least_likeness(seen_edge_px / 8.0);
  const bool tiny = needed > most_likeness;
  const bool clear = detection.likeness >= (tiny ? least_of_tiny : needed) && off <= options.shape_tolerance &&
                     place->misfit <= 0.5 * options.shape_tolerance * place->edge;
  if (!clear || (!cut_off && !tiny)) {
    reject(counters.unlike);
    return;
  }
  const PoseSigma sigma = pose_sigma(*place, options.corner_sigma);
  tag.found = true;
  tag.edge_px = seen_edge_px;
  tag.contrast = 2.0 * detection.decision_margin;
  tag.pose = {.tag = tag.tag,
              .pose = place->pose,
              .captured_at = seen_at(frame, detection.corners),
              .sigma_xy = sigma.xy,
              .sigma_theta = sigma.theta,
              .covariance = Eigen::Vector3d(sigma.xy * sigma.xy, sigma.xy * sigma.xy, sigma.theta * sigma.theta)
                                .asDiagonal()
                                .toDenseMatrix(),
              .corners = detection.corners};
}

/// Part of a frame cannot say that an ambiguous tag has become one again.
void TrackerParts::consider_all(const Frame& frame, const std::vector<Detection>& detections, bool whole_frame) {
  for (const Detection& detection : detections)
    for (WantedTag& tag : wanted)
      if (tag.tag == detection.tag && (whole_frame || !tag.ambiguous))
        consider(tag, frame, detection, /*predicted=*/false);
}

/// AprilTag at one place that the gate has named. true: a wanted tag is there.
bool TrackerParts::check(const Frame& frame, const Gate::Place& place) {
  ++counters.windows;
  detector.set_decimate(decimate);
  detector.set_min_white_black_diff(detector_threshold());
  const auto& seen = detector.detect(frame, square_around(place.u, place.v, 0.5 * options.window * edge_px));
  consider_all(frame, seen, /*whole_frame=*/false);
  return std::any_of(seen.begin(), seen.end(), [&](const Detection& detection) {
    return std::any_of(wanted.begin(), wanted.end(), [&](const WantedTag& tag) { return tag.tag == detection.tag; });
  });
}

/// New places first: what AprilTag has refuted before seldom becomes a tag.
void TrackerParts::check_places(const Frame& frame, const std::vector<Gate::Place>& places, int most_new,
                                int most_old) {
  std::vector<Refuted*> old;
  std::vector<Refuted> refuted_now;
  for (const Gate::Place& place : places) {
    const auto memory = std::find_if(refuted.begin(), refuted.end(),
                                     [&](const Refuted& r) { return distance(r.place, place) < 0.3 * edge_px; });
    if (memory != refuted.end()) {
      old.push_back(&*memory);
    } else if (most_new-- > 0 && !check(frame, place)) {
      refuted_now.push_back({place, counters.frames});
    }
  }
  std::sort(old.begin(), old.end(), [](const Refuted* a, const Refuted* b) { return a->looked_at < b->looked_at; });
  if (static_cast<int>(old.size()) > most_old) old.resize(static_cast<std::size_t>(most_old));
  for (Refuted* memory : old) memory->looked_at = check(frame, memory->place) ? -forget_after : counters.frames;
  refuted.insert(refuted.end(), refuted_now.begin(), refuted_now.end());
  std::erase_if(refuted, [&](const Refuted& r) { return r.looked_at + forget_after < counters.frames; });
}

void TrackerParts::look_at_gate(const Frame& frame) {
  const bool any =
      std::any_of(wanted.begin(), wanted.end(), [](const WantedTag& tag) { return tag.missing() && !tag.ambiguous; });
  if (!any) return;
  ++counters.gates;
  list_known();
  gate.scan(frame, 0, gate.rows(), gate_threshold());
  check_places(frame, gate.places(0, gate.rows(), known, 0.7 * edge_px), most_windows, most_old_windows);
}

/// The frame as a whole: at the beginning, and while an id was seen twice, since only a look at everything can tell
/// that one of the two is gone. What another camera sees beyond this picture is not looked for; but where the picture
/// is on the floor, only the calibration says, which may be another camera's, until this camera has seen a tag itself.
bool TrackerParts::search_due() const {
  constexpr std::int64_t by_itself = 25;  // frames
  if (!missing()) return !contrast && !wanted.empty() && counters.frames - last_search >= by_itself;
  if (counters.full_searches == 0) return true;
  const bool ambiguous =
      std::any_of(wanted.begin(), wanted.end(), [](const WantedTag& tag) { return tag.missing() && tag.ambiguous; });
  return (!contrast || ambiguous) && counters.frames - last_search >= options.search_every;
}

void TrackerParts::search(const Frame& frame) {
  if (!search_due()) {
    search_part(frame);
    return;
  }
  detector.set_decimate(decimate);
  // Every other search is one for dim light (30 ms) until a tag has said what the light is like.
  const bool dim_turn = !contrast && counters.full_searches % 2 == 1;
  detector.set_min_white_black_diff(dim_turn ? static_cast<int>(dim) : detector_threshold());
  last_search = counters.frames;
  ++counters.full_searches;
  consider_all(frame, detector.detect(frame), /*whole_frame=*/true);
}

/// The next part of the frame, in every frame while a tag is missing, else now and then.
void TrackerParts::search_part(const Frame& frame) {
  if (wanted.empty() || !contrast) return;
  const auto parts = static_cast<std::int64_t>(search_parts.size());
  if (!missing() && counters.frames % std::max(1, options.search_anyway) != 0) return;
  // Every so many times round it is for a tag that lies in a deep shadow.
  const bool dim_turn = counters.part_searches / parts % dim_every == dim_every - 1;
  detector.set_decimate(decimate);
  detector.set_min_white_black_diff(dim_turn ? static_cast<int>(dim) : detector_threshold());
  const Window& part = search_parts[static_cast<std::size_t>(counters.part_searches++ % parts)];
  consider_all(frame, detector.detect(frame, part), /*whole_frame=*/parts == 1);
}

/// What the audit looks at in this frame.
TrackerParts::Strip TrackerParts::audit_strip() const {
  const int strips = std::max(1, options.audit_every);
  const int strip = static_cast<int>(counters.frames % strips);
  return {gate.rows() * strip / strips, gate.rows() * (strip + 1) / strips};
}

/// Every frame a strip of the picture, so that no frame has to wait for the whole of it.
void TrackerParts::audit(const Frame& frame) {
  if (!contrast || last_search == counters.frames) return;
  const auto [first, last] = audit_strip();
  gate.scan(frame, first, last, gate_threshold());
  list_known();
  const int before = gate.square() - 1;  // squares that begin above the strip end in it
  const bool recheck = counters.frames % recheck_every == 0;
  check_places(frame, gate.places(first - before, last - before, known, 0.7 * edge_px), most_audit_windows,
               recheck ? 1 : 0);
}

}  // namespace skein::vision

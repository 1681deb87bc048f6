#include "vision/tracker/tracker.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "core/estimation/statistics.h"
#include "core/words.h"
#include "vision/detector/detector.h"
#include "vision/frames/frame.h"
#include "vision/tags/detection.h"
#include "vision/tracker/tracker_parts.h"

namespace skein::vision {
namespace {

// A lost tag is looked for near its last place for this long; then it may be anywhere. [s]
constexpr double follow_for = 0.5;

constexpr double degree = core::pi / 180.0;

// No robot turns faster: it is a fit that has gone wrong, or a tag that is held by hand. [rad/s]
constexpr double fastest_turn = 720.0 * degree;

// Below this part of the best-lit tag's contrast a tag is in the dark: a search for its like would take the texture of
// the best-lit floor for tags, at many times the cost.
constexpr double in_the_dark = 1.0 / 3.0;

// A size is unusual if it differs by this many of its standard deviations more than is tolerated.
constexpr double deviations = 4.0;

// The cubic map is good enough below this. [px]
constexpr double map_tolerance = 0.01;

detail::PhotometricFit make_fitter(const Calibration& calibration, const TrackerOptions& options) {
  const detail::PlaneMap map(calibration);
  detail::FitOptions fit;
  fit.strain_tolerance = options.shape_tolerance;
  if (options.baseline) fit.instructions = detail::Instructions::baseline;
  const double module = calibration.tag_size / 8.0;
  const bool exact = map.worst_error(calibration, 7.0 * module) > map_tolerance;
  return {map, module, exact, fit};
}

std::vector<WantedTag> make_wanted(const std::vector<int>& tags) {
  const std::vector<detail::TagPattern> patterns = detail::tag_patterns();
  std::vector<WantedTag> wanted;
  for (const int tag : tags) {
    const bool repeated = std::any_of(wanted.begin(), wanted.end(), [&](const WantedTag& w) { return w.tag == tag; });
    const bool known = tag >= 0 && static_cast<std::size_t>(tag) < patterns.size();
    if (known && !repeated) wanted.emplace_back(tag, patterns[static_cast<std::size_t>(tag)]);
  }
  return wanted;
}

Calibration with_world(Calibration calibration) {
  if (!calibration.world_from_camera) throw std::invalid_argument("TagTracker: the calibration has no world frame");
  return calibration;
}

/// A frame in so many parts, or nearly so, that overlap by a tag with its border, turned or not: it lies wholly in one.
std::vector<Window> overlapping_parts(int width, int height, int parts, double overlap) {
  const int most_columns = std::max(1, static_cast<int>(width / (2.0 * overlap)));
  const int most_rows = std::max(1, static_cast<int>(height / (2.0 * overlap)));
  const int columns = std::clamp(static_cast<int>(std::lround(std::sqrt(parts * 4.0 / 3.0))), 1, most_columns);
  const int rows = std::clamp(parts / columns, 1, most_rows);
  const int half = static_cast<int>(std::ceil(0.5 * overlap));
  std::vector<Window> windows;
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column) {
      const int left = width * column / columns - half;
      const int top = height * row / rows - half;
      windows.push_back(
          {left, top, width * (column + 1) / columns + half - left, height * (row + 1) / rows + half - top});
    }
  return windows;
}

}  // namespace

TrackerParts::TrackerParts(Calibration c, TrackerOptions o)
    : calibration(with_world(std::move(c))),
      options(std::move(o)),
      fitter(make_fitter(calibration, options)),
      detector(DetectorOptions{.threads = options.threads}),
      edge_px(tag_edge_px(calibration)),
      decimate(options.decimate > 0.0 ? options.decimate : decimate_for_edge(edge_px)),
      gate(calibration.width, calibration.height, std::max(8.0, edge_px),
           options.baseline ? detail::Instructions::baseline : detail::best_instructions()),
      wanted(make_wanted(options.tags)),
      search_parts(overlapping_parts(calibration.width, calibration.height, std::max(1, options.search_parts),
                                     options.window * std::max(8.0, edge_px))) {
  poses.reserve(wanted.size());
  // Most of what a template costs is paid here and not in the first frame.
  for (WantedTag& tag : wanted) {
    tag.model.sharp(std::max(1.0, edge_px / 8.0));
    tag.model.smooth();
  }
}

TagTracker::TagTracker(Calibration calibration, TrackerOptions options)
    : parts_(std::make_unique<TrackerParts>(std::move(calibration), std::move(options))) {}

TagTracker::~TagTracker() = default;
TagTracker::TagTracker(TagTracker&&) noexcept = default;
TagTracker& TagTracker::operator=(TagTracker&&) noexcept = default;

const TrackerCounters& TagTracker::counters() const {
  return parts_->counters;
}

std::optional<double> TrackerParts::usual(double WantedTag::*mean, bool (WantedTag::*is_known)() const) const {
  std::vector<double> usual;
  for (const WantedTag& tag : wanted)
    if ((tag.*is_known)()) usual.push_back(tag.*mean);
  if (usual.empty()) return {};
  return core::median_of(usual);
}

std::optional<double> TagTracker::stretch() const {
  return parts_->usual(&WantedTag::usual_stretch, &WantedTag::has_true_scale);
}

std::optional<double> TagTracker::blur() const {
  return parts_->usual(&WantedTag::usual_blur, &WantedTag::has_usual);
}

std::optional<ScaleChange> TagTracker::scale_change() const {
  return parts_->scale_change;
}

std::optional<double> TagTracker::lifted_from(int tag) const {
  for (const WantedTag& wanted : parts_->wanted)
    if (wanted.tag == tag && wanted.off) return wanted.usual_stretch;
  return {};
}

const StageTimes& TagTracker::stage_times() const {
  return parts_->times;
}

const std::vector<TagPose>& TagTracker::process(const Frame& frame, std::span<const SeenElsewhere> elsewhere) {
  TrackerParts& parts = *parts_;
  parts.begin(elsewhere);
  parts.times = {};
  if (frame.width != parts.calibration.width || frame.height != parts.calibration.height) {
    ++parts.counters.wrong_frames;
    return parts.poses;
  }
  const std::function<double()>& clock = parts.options.clock;
  double since = clock ? clock() : 0.0;
  for (const TrackerStage stage : core::all_of<TrackerStage>()) {
    parts.pass(stage, frame);
    if (!clock) continue;
    const double now = clock();
    parts.times[static_cast<std::size_t>(stage)] = now - since;
    since = now;
  }
  return parts.poses;
}

void TrackerParts::pass(TrackerStage stage, const Frame& frame) {
  switch (stage) {
    case TrackerStage::follow:
      follow(frame);
      break;
    case TrackerStage::enter:
      enter(frame);
      break;
    case TrackerStage::nearby:
      look_nearby(frame);
      break;
    case TrackerStage::gate:
      look_at_gate(frame);
      break;
    case TrackerStage::search:
      search(frame);
      break;
    case TrackerStage::audit:
      audit(frame);
      break;
    case TrackerStage::conclude:
      compare_shapes(frame);
      conclude(frame);
      break;
  }
}

void TrackerParts::begin(std::span<const SeenElsewhere> elsewhere) {
  poses.clear();
  ++counters.frames;
  for (WantedTag& tag : wanted) {
    tag.found = tag.predicted = tag.ghost = false;
    tag.stretch.reset();
    tag.off = false;
    const auto seen = std::find_if(elsewhere.begin(), elsewhere.end(),
                                   [&](const SeenElsewhere& other) { return other.tag == tag.tag; });
    tag.elsewhere = seen == elsewhere.end() ? std::nullopt : std::optional(seen->pose);
  }
}

/// A robot drives where it is heading: its velocity turns with it, by what it turns from the middle of the last two
/// sights to the middle of the last one and this. On a circle, what is left is too little for a second look.
core::Pose TrackerParts::predict(const WantedTag& tag, double captured_at) const {
  const double elapsed = std::clamp(captured_at - tag.last_seen_at, 0.0, follow_for);
  const double turned = tag.velocity.theta * 0.5 * (tag.velocity_over + elapsed);
  const double c = std::cos(turned) * elapsed, s = std::sin(turned) * elapsed;
  return {tag.last.x + c * tag.velocity.x - s * tag.velocity.y, tag.last.y + s * tag.velocity.x + c * tag.velocity.y,
          core::wrap_angle(tag.last.theta + tag.velocity.theta * elapsed)};
}

namespace {

constexpr std::size_t cache_line = 64;  // [bytes]

void fetch_memory(const WantedTag& tag) {
  const auto* const bytes = reinterpret_cast<const char*>(&tag);
  for (std::size_t at = 0; at < sizeof tag; at += cache_line) __builtin_prefetch(bytes + at);
}

}  // namespace

/// What a fit to this tag will read is on its way from memory while others are fitted: since the last frame, other work
/// has had the caches.
void TrackerParts::fetch(const Frame& frame, const WantedTag& tag) {
  constexpr double around = 0.12;  // the fit's reach and how far a robot drives in a frame, in edges
  constexpr int line = cache_line;
  const Corners& corners = tag.pose.corners;
  const auto [left, right] = std::minmax({corners[0][0], corners[1][0], corners[2][0], corners[3][0]});
  const auto [top, bottom] = std::minmax({corners[0][1], corners[1][1], corners[2][1], corners[3][1]});
  const double more = around * tag.edge_px;
  const int first = std::max(0, static_cast<int>(left - more));
  const int last = std::min(frame.width - 1, static_cast<int>(right + more));
  const int end = std::min(frame.height, static_cast<int>(bottom + more) + 1);
  for (int row = std::max(0, static_cast<int>(top - more)); row < end; ++row) {
    const std::uint8_t* const pixels = frame.row(row);
    for (int at = first; at < last; at += line) __builtin_prefetch(pixels + at);
    __builtin_prefetch(pixels + last);
  }
  tag.model.fetch();
}

void TrackerParts::follow(const Frame& frame) {
  // So many tags ahead, and what is remembered of them before: the memory is as busy as it can be.
  constexpr std::size_t ahead = 2;
  const std::size_t tags = wanted.size();
  for (std::size_t i = 0; i < std::min(2 * ahead, tags); ++i) fetch_memory(wanted[i]);
  for (std::size_t i = 0; i < std::min(ahead, tags); ++i)
    if (wanted[i].following) fetch(frame, wanted[i]);
  const Strip strip = audit_strip();
  for (std::size_t i = 0; i < tags; ++i) {
    if (i + 2 * ahead < tags) fetch_memory(wanted[i + 2 * ahead]);
    if (i + ahead < tags && wanted[i + ahead].following) fetch(frame, wanted[i + ahead]);
    gate.fetch(frame, strip.first, strip.last, static_cast<int>(i), static_cast<int>(tags));
    WantedTag& tag = wanted[i];
    if (!tag.following) continue;
    detail::Fit fit = fitter.fit(frame, tag.model, predict(tag, frame.captured_at));
    counters.looks += fit.looks;
    // It may have stopped short.
    const bool moved = tag.velocity.x != 0.0 || tag.velocity.y != 0.0 || tag.velocity.theta != 0.0;
    switch (fit.verdict) {
      case detail::FitVerdict::unlike:
        if (moved) fit = fitter.fit(frame, tag.model, tag.last);
        break;
      case detail::FitVerdict::good:
      case detail::FitVerdict::outside:
      case detail::FitVerdict::misshapen:
        break;
    }
    switch (fit.verdict) {
      case detail::FitVerdict::good:
        ++counters.fits;
        tag.predicted = true;
        accept(tag, frame, fit);
        break;
      case detail::FitVerdict::unlike:
      case detail::FitVerdict::outside:
      case detail::FitVerdict::misshapen:
        ++counters.failed_fits;
        break;
    }
  }
}

/// When the rows that show a tag were read: a rolling shutter comes to each of them later than to the first.
double TrackerParts::seen_at(const Frame& frame, const Corners& corners) const {
  const double row = 0.25 * (corners[0][1] + corners[1][1] + corners[2][1] + corners[3][1]);
  return frame.captured_at + calibration.row_time * row;
}

void TrackerParts::accept(WantedTag& tag, const Frame& frame, const detail::Fit& fit) {
  tag.found = true;
  tag.stretch = fit.stretch;
  tag.stretch_sigma = fit.stretch_sigma;
  tag.blur_px = fit.blur_px;
  tag.edge_px = fit.edge_px;
  tag.contrast = fit.contrast;
  tag.noise = fit.noise;
  tag.pose.tag = tag.tag;
  tag.pose.pose = fit.pose;
  tag.pose.captured_at = seen_at(frame, fit.corners);
  tag.pose.covariance = fit.covariance;
  tag.pose.sigma_xy = std::sqrt(0.5 * (fit.covariance(0, 0) + fit.covariance(1, 1)));
  tag.pose.sigma_theta = std::sqrt(fit.covariance(2, 2));
  tag.pose.corners = fit.corners;
}

/// Whether the newest fit shows the tag nearer to the camera, or farther from it, than the seconds before did. What
/// stays so for long is no hand, and becomes what is usual.
bool WantedTag::lifted(double tolerance) noexcept {
  constexpr int long_enough = 250;  // [frames]
  const bool unusual = has_usual() && std::abs(*stretch - usual_stretch) > tolerance + deviations * stretch_sigma;
  off_stretch = unusual ? off_stretch + 1 : 0;
  if (unusual && off_stretch < long_enough) return true;
  if (unusual) stretches = 0;
  stretches = std::min(stretches + 1, remembered);
  usual_stretch += (*stretch - usual_stretch) / stretches;
  usual_blur += (blur_px - usual_blur) / std::min(stretches, of_blur);
  return false;
}

/// A wanted tag was seen and is not taken, for the reason that this counts.
void TrackerParts::reject(std::int64_t& reason) {
  ++reason;
  ++counters.rejected;
}

namespace {

/// Whether the tag's paper is as bright as the camera can show: its edges then seem to lie inside the ink.
bool paper_is_clipped(const Frame& frame, const Corners& corners) {
  constexpr int brightest = 250;
  constexpr double paper = 4.5 / 4.0;  // half a module outside the black frame, from the middle of the tag
  const Eigen::Vector2d middle = middle_of(corners);
  int bright = 0;
  for (std::size_t k = 0; k < 4; ++k) {
    const auto &a = corners[k], &b = corners[(k + 1) % 4];
    const auto u = std::lround(std::lerp(middle.x(), 0.5 * (a[0] + b[0]), paper));
    const auto v = std::lround(std::lerp(middle.y(), 0.5 * (a[1] + b[1]), paper));
    if (u < 0 || v < 0 || u >= frame.width || v >= frame.height) continue;
    bright += frame.row(static_cast<int>(v))[u] >= brightest ? 1 : 0;
  }
  return bright >= 2;
}

}  // namespace

/// Whether all tags look larger or smaller at once, by the same part.
void TrackerParts::compare_scales() {
  constexpr double agreement = 0.004;
  const auto tells = [](const WantedTag& tag) { return tag.found && tag.stretch && tag.has_true_scale(); };
  scale_change.reset();
  changes.clear();
  for (const WantedTag& tag : wanted)
    if (tells(tag)) changes.push_back(*tag.stretch - tag.usual_stretch);
  if (changes.size() < 2) return;
  const double by = core::median_of(changes);
  for (const WantedTag& tag : wanted) {
    if (!tells(tag)) continue;
    if (std::abs(*tag.stretch - tag.usual_stretch - by) > agreement + deviations * tag.stretch_sigma) return;
  }
  scale_change = {by, changes.size()};
}

/// A tag that seems larger than all the others is nearer to the camera than they are: it is held up.
void TrackerParts::compare_shapes(const Frame& frame) {
  for (WantedTag& tag : wanted)
    if (tag.found && tag.stretch)
      tag.unclipped =
          paper_is_clipped(frame, tag.pose.corners) ? 0 : std::min(tag.unclipped + 1, WantedTag::remembered);
  compare_scales();
  stretches.clear();
  for (WantedTag& tag : wanted) {
    if (!tag.found || !tag.stretch) continue;
    stretches.push_back(*tag.stretch);
    tag.off = tag.lifted(options.lift_tolerance);
    if (!tag.off) continue;
    tag.found = false;
    reject(counters.lifted);
  }
  if (stretches.size() < 3) return;
  const double usual = core::median_of(stretches);
  for (WantedTag& tag : wanted) {
    if (!tag.found || !tag.stretch) continue;
    if (*tag.stretch - usual <= options.group_tolerance + deviations * tag.stretch_sigma) continue;
    tag.found = false;
    reject(counters.odd);
  }
}

void TrackerParts::conclude(const Frame& frame) {
  std::optional<double> least_contrast;
  double most_contrast = 0.0;
  double least_noise = 255.0;
  for (WantedTag& tag : wanted) {
    if (tag.ghost) {
      // It is not known which of the two is the robot: neither is reported until a full search finds only one.
      ++counters.ghosts;
      tag.following = false;
      tag.ambiguous = true;
      tag.velocity = {};
      continue;
    }
    const double elapsed = frame.captured_at - tag.last_seen_at;
    if (!tag.found) {
      ++tag.missed;
      tag.following = tag.following && elapsed >= 0.0 && elapsed < follow_for;
      continue;
    }
    const core::Pose& pose = tag.pose.pose;
    tag.velocity = {};
    if (tag.following && elapsed > 1e-4 && elapsed < follow_for) {
      const core::Pose velocity{(pose.x - tag.last.x) / elapsed, (pose.y - tag.last.y) / elapsed,
                                core::wrap_angle(pose.theta - tag.last.theta) / elapsed};
      // Put elsewhere, or turned by hand: no prediction then.
      const bool plausible =
          std::hypot(velocity.x, velocity.y) <= 2.0 * options.max_speed && std::abs(velocity.theta) <= fastest_turn;
      if (plausible) {
        tag.velocity = velocity;
        tag.velocity_over = elapsed;
      }
    }
    tag.pose.how = !tag.ever_seen ? How::detected : tag.predicted ? How::tracked : How::recovered;
    poses.push_back(tag.pose);
    ++counters.poses;
    least_contrast = std::min(tag.contrast, least_contrast.value_or(255.0));
    most_contrast = std::max(tag.contrast, most_contrast);
    least_noise = std::min(tag.noise, least_noise);
    tag.missed = 0;
    tag.last = pose;
    tag.last_seen_at = frame.captured_at;
    tag.ever_seen = tag.following = true;
    tag.ambiguous = false;
  }
  if (!least_contrast) return;
  contrast = std::max(*least_contrast, in_the_dark * most_contrast);
  noise = least_noise;
}

}  // namespace skein::vision

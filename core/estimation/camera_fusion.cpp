#include "core/estimation/camera_fusion.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/math/elementary.h"

namespace skein::core {

CameraFusion::CameraFusion(std::size_t robots, std::size_t cameras, const FilterParameters& parameters, double bridge)
    : robots_(robots),
      cameras_(cameras),
      parameters_(parameters),
      bridge_(bridge),
      seen_(robots * cameras),
      apart_(robots * (cameras * (cameras - 1) / 2)),
      comparisons_(cameras * (cameras - 1) / 2),
      believed_(robots),
      fused_(robots) {
  in_order_.reserve(cameras);
}

void CameraFusion::forget() noexcept {
  for (Seen& each : seen_) each = {};
  for (Measurement& each : believed_) each = {};
  for (Measurement& each : fused_) each = {};
  for (Apart& each : apart_) each = {};
  for (Comparison& each : comparisons_) each = {};
}

std::span<const std::size_t> CameraFusion::news(std::size_t robot, std::span<const Measurement> measurements) noexcept {
  const auto captured_at = [&](std::size_t camera) { return measurements[camera * robots_ + robot].captured_at; };
  double last = Measurement::never;
  for (std::size_t c = 0; c < cameras_; ++c) last = std::max(last, captured_at(c));
  in_order_.clear();
  for (std::size_t c = 0; c < cameras_; ++c)
    if (captured_at(c) > newest(robot, c).captured_at && captured_at(c) >= last - bridge_) in_order_.push_back(c);
  std::sort(in_order_.begin(), in_order_.end(), [&](std::size_t a, std::size_t b) {
    return captured_at(a) < captured_at(b) || (captured_at(a) == captured_at(b) && a < b);
  });
  return in_order_;
}

CameraFusion::Outcome CameraFusion::take(std::size_t robot, std::size_t camera, const Measurement& measurement,
                                         PoseFilter& filter, double now) noexcept {
  const Measurement before = std::exchange(seen_[camera * robots_ + robot].newest, measurement);
  Measurement fused = measurement;
  std::optional<Disagreement> difference;
  if (cameras_ > 1) {
    difference = compare(robot, camera, measurement, filter);
    const Verdict verdict = reconcile(robot, camera, before.captured_at, filter, now, fused);
    if (!verdict.agrees) return {.expected = {}, .disagreement = verdict.disagreement, .difference = difference};
  }
  if (measurement.captured_at > believed_[robot].captured_at) {
    believed_[robot] = measurement;
    fused_[robot] = fused;
  }
  return {.expected = filter.fuse(parameters_, fused), .disagreement = {}, .difference = difference};
}

/// A robot that a hand moves, or that does not drive as commanded, is not where it was in another camera's frame
/// either; but which of the two sees it ahead then changes with each frame.
std::optional<CameraFusion::Disagreement> CameraFusion::compare(std::size_t robot, std::size_t camera,
                                                                const Measurement& m,
                                                                const PoseFilter& filter) noexcept {
  constexpr double lasting = 0.5;   // [s]
  constexpr int enough = 10;        // measurements
  constexpr double unlikely = 4.0;  // standard deviations
  std::optional<Disagreement> found;
  for (std::size_t other = 0; other < cameras_; ++other) {
    const Measurement& by_other = newest(robot, other);
    if (other == camera || !(std::abs(m.captured_at - by_other.captured_at) <= bridge_)) continue;
    const std::size_t p = pair(std::min(camera, other), std::max(camera, other));
    Apart& apart = apart_[robot * comparisons_.size() + p];
    Comparison& comparison = comparisons_[p];
    const double at = std::max(m.captured_at, by_other.captured_at);
    const Pose here = filter.predict(m, at), there = filter.predict(by_other, at);
    const double sign = camera > other ? 1.0 : -1.0;
    const Pose way{sign * (here.x - there.x), sign * (here.y - there.y), 0.0};
    const bool goes_on = apart.count == 0 ||
                         (m.captured_at - apart.newest <= bridge_ && way.x * apart.sum.x + way.y * apart.sum.y > 0.0);
    if (!goes_on) apart = {};
    if (math::hypot(way.x, way.y) <= slight + unlikely * math::hypot(m.sigma_xy, by_other.sigma_xy)) {
      apart = {};
      comparison.compared = true;
      if (m.captured_at > comparison.at + bridge_) comparison.apart = 0.0;  // no robot is seen apart any more
      continue;
    }
    if (apart.count++ == 0) apart.since = m.captured_at;
    apart.newest = m.captured_at;
    apart.sum = {apart.sum.x + way.x, apart.sum.y + way.y, 0.0};
    if (apart.count < enough || apart.newest - apart.since < lasting) {
      comparison.undecided_at = m.captured_at;
      continue;
    }
    const double distance = math::hypot(apart.sum.x, apart.sum.y) / apart.count;
    const bool told = std::exchange(comparison.told, true);
    comparison = {.compared = true, .robot = robot, .apart = distance, .at = m.captured_at, .told = true};
    if (!told) found = Disagreement{other, distance};
  }
  return found;
}

/// Makes a camera's measurement agree with those of the others that see the robot, or says that they contradict it.
CameraFusion::Verdict CameraFusion::reconcile(std::size_t robot, std::size_t camera, double seen_before_at,
                                              const PoseFilter& filter, double now, Measurement& m) noexcept {
  constexpr int most_contradicted = 5;  // frames
  constexpr int frames_to_learn = 10;   // a shift: meanwhile the others tell where the robot is
  constexpr double fades = 1.0;         // time constant [s]
  Seen& seen = seen_[camera * robots_ + robot];
  std::size_t other = cameras_;  // that sees it too
  for (std::size_t c = 0; c < cameras_; ++c) {
    const Seen& by_other = seen_[c * robots_ + robot];
    const bool recent = by_other.newest.captured_at >= m.captured_at - bridge_;
    if (c != camera && recent && by_other.contradicted == 0) other = c;
  }
  const double seconds = m.captured_at - seen_before_at;
  const bool joins = !(seconds <= bridge_);
  const double share = joins ? 0.0 : other == cameras_ ? math::exp(-seconds / fades) : 1.0;
  seen.shift = {share * seen.shift.x, share * seen.shift.y, share * seen.shift.theta};
  if (joins) seen.learned = other < cameras_ ? 0 : frames_to_learn;
  if (seen.learned < frames_to_learn && other < cameras_ && align(seen, filter, m, now)) return {.agrees = false};
  const Pose measured = m.pose;
  m.pose = {m.pose.x + seen.shift.x, m.pose.y + seen.shift.y, wrap_angle(m.pose.theta + seen.shift.theta)};
  const std::optional<Pose> expected = filter.surprise(parameters_, m);
  const bool said_otherwise = expected && other < cameras_;
  if (!said_otherwise) {
    seen.contradicted = 0;
    return {.agrees = true};
  }
  if (++seen.contradicted != most_contradicted) return {.agrees = false};
  return {.agrees = false, .disagreement = Disagreement{other, distance(*expected, measured)}};
}

/// Learns the shift of a camera's poses of a robot from where the other cameras have it, a mean by the covariances of
/// its poses; false: they are farther apart than calibrations are.
bool CameraFusion::align(Seen& seen, const PoseFilter& filter, const Measurement& m, double now) const noexcept {
  constexpr double finest = 1e-6;  // [m]
  if (filter.surprise(parameters_, m)) return false;
  if (seen.learned++ == 0) seen.weight = 0.0;
  const double sigma = std::max(finest, m.sigma_xy), weight = 1.0 / (sigma * sigma);
  seen.weight += weight;
  const double part = weight / seen.weight;
  const Pose expected = filter.predict(now), by_camera = filter.predict(m, now);
  seen.shift.x += part * (expected.x - by_camera.x - seen.shift.x);
  seen.shift.y += part * (expected.y - by_camera.y - seen.shift.y);
  seen.shift.theta += part * (wrap_angle(expected.theta - by_camera.theta) - seen.shift.theta);
  return true;
}

}  // namespace skein::core

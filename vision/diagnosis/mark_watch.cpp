#include "vision/diagnosis/mark_watch.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "vision/tags/tag_plane.h"

namespace skein::vision {
namespace {

bool agree(const MarkSight& a, const MarkSight& b) {
  return a.state == b.state && (a.state != MarkSight::State::some_moved || a.moved == b.moved);
}

}  // namespace

bool tells(MarkSight::State state) {
  using State = MarkSight::State;
  switch (state) {
    case State::in_place:
    case State::some_moved:
    case State::camera_moved:
      return true;
    case State::too_few:
    case State::unclear:
      return false;
  }
  return false;
}

MarkWatch::MarkWatch(const Calibration& calibration, std::span<const int> not_these) : calibration_(calibration) {
  if (!calibration.world_from_camera) return;
  for (const FloorMark& mark : calibration.marks) {
    if (mark.tag < 0 || std::find(not_these.begin(), not_these.end(), mark.tag) != not_these.end()) continue;
    const auto seen = mark.seen ? world_from_pixel(calibration, {mark.u, mark.v}, mark.z) : std::nullopt;
    marks_.push_back({mark.tag, mark.size, mark.z, seen.value_or(Eigen::Vector2d(mark.x, mark.y))});
  }
}

/// How far from its place a mark is seen; none: it is hidden, whole or in part, or there twice.
std::optional<Eigen::Vector2d> MarkWatch::displacement(const Mark& mark, const std::vector<Detection>& found) const {
  // Of its edge: a robot's body over a corner makes another quadrilateral of it, and a camera that was tilted by some
  // degrees sees it larger or smaller.
  constexpr double least_square = 0.03, other_size = 0.15;
  const auto is_it = [&](const Detection& detection) { return detection.tag == mark.tag; };
  const auto first = std::find_if(found.begin(), found.end(), is_it);
  if (first == found.end() || std::count_if(found.begin(), found.end(), is_it) != 1) return {};
  Calibration at_mark = calibration_;
  at_mark.tag_height = mark.height;
  const auto square = place_on_plane(at_mark, first->corners);
  if (!square || square->misfit > least_square * square->edge) return {};
  if (mark.size > 0.0 && std::abs(square->edge - mark.size) > other_size * mark.size) return {};
  return Eigen::Vector2d(square->pose.x, square->pose.y) - mark.place;
}

MarkSight MarkWatch::judge(const std::vector<Detection>& found) const {
  using State = MarkSight::State;
  MarkSight sight;
  sight.marks = marks_.size();
  std::vector<Eigen::Vector2d> places, displaced;
  std::size_t stayed = 0;
  double all = 0.0, elsewhere = 0.0;
  for (const Mark& mark : marks_) {
    const auto by = displacement(mark, found);
    if (!by) {
      sight.missing.push_back(mark.tag);
      continue;
    }
    places.push_back(mark.place);
    displaced.push_back(*by);
    const double distance = by->norm();
    all += distance;
    // A mark between the two limits counts for neither: a camera that drifts moves the marks over the limit one after
    // the other.
    if (distance <= 0.5 * tolerance) ++stayed;
    if (distance <= tolerance) continue;
    sight.moved.push_back(mark.tag);
    elsewhere += distance;
  }
  sight.seen = places.size();
  if (sight.seen == 0) return sight;
  const auto count = static_cast<double>(sight.seen);
  sight.by = sight.moved.empty() ? all / count : elsewhere / static_cast<double>(sight.moved.size());
  Eigen::Vector2d middle(0.0, 0.0), mean(0.0, 0.0);
  for (std::size_t k = 0; k < sight.seen; ++k) middle += places[k] / count, mean += displaced[k] / count;
  double turning = 0.0, inertia = 0.0;
  for (std::size_t k = 0; k < sight.seen; ++k) {
    const Eigen::Vector2d arm = places[k] - middle, by = displaced[k] - mean;
    turning += arm.x() * by.y() - arm.y() * by.x();
    inertia += arm.squaredNorm();
  }
  if (inertia > 0.0) sight.turn = turning / inertia;
  const bool most_moved = 2 * sight.moved.size() > sight.seen, most_stayed = 2 * stayed > sight.seen;
  if (sight.seen < least_seen)
    sight.state = State::too_few;
  else if (most_moved && sight.moved.size() >= least_seen)
    sight.state = State::camera_moved;
  else if (most_stayed)
    sight.state = sight.moved.empty() ? State::in_place : State::some_moved;
  else
    sight.state = State::unclear;
  return sight;
}

std::vector<MissingTag> MarkWatch::missing() const {
  std::vector<MissingTag> missing;
  for (const Mark& mark : marks_) {
    if (!last_ || std::find(last_->missing.begin(), last_->missing.end(), mark.tag) == last_->missing.end()) continue;
    const FloorMark asked{
        .tag = mark.tag, .x = mark.place.x(), .y = mark.place.y(), .z = mark.height, .size = mark.size};
    missing.push_back({.tag = mark.tag, .last = core::Pose{asked.x, asked.y, 0.0}, .mark = asked});
  }
  return missing;
}

bool MarkWatch::update(const Frame& frame) {
  if (!detector_) detector_.emplace();
  const MarkSight sight = judge(detector_->detect(frame));
  const bool certain = last_ ? agree(*last_, sight) : sight.state == MarkSight::State::in_place;
  last_ = sight;
  const bool unseen = known_ && tells(known_->state) && !tells(sight.state);
  blind_ = unseen_.update(frame.captured_at, unseen) || (blind_ && unseen);
  const bool counts = tells(sight.state) || !known_ || !tells(known_->state);
  const bool news = !known_ || !agree(*known_, sight);
  doubts_ = counts && news && !certain;
  if (!counts || !certain) return false;
  known_ = sight;  // the newest numbers
  return news;
}

std::string sentence(const MarkSight& sight) {
  using State = MarkSight::State;
  const double mm = 1e3 * sight.by;
  switch (sight.state) {
    case State::in_place:
      return fmt::format("{} of {} marks on the floor are seen, and lie where they were, to {:.1f} mm", sight.seen,
                         sight.marks, mm);
    case State::some_moved:
      return fmt::format(
          "mark{} {} {} moved by {:.0f} mm, or put back wrongly; the other {} that are seen lie where they "
          "were",
          sight.moved.size() == 1 ? "" : "s", fmt::join(sight.moved, ", "), sight.moved.size() == 1 ? "was" : "were",
          mm, sight.seen - sight.moved.size());
    case State::camera_moved:
      return fmt::format("{} of {} marks on the floor that are seen are off by {:.0f} mm", sight.moved.size(),
                         sight.seen, mm);
    case State::too_few:
      return fmt::format("{} of {} marks on the floor are seen, {} are needed to tell whether the camera has moved",
                         sight.seen, sight.marks, MarkWatch::least_seen);
    case State::unclear:
      return fmt::format(
          "{} of {} marks on the floor that are seen are off by more than {:.0f} mm, others a little: the "
          "camera may have moved",
          sight.moved.size(), sight.seen, 1e3 * MarkWatch::tolerance);
  }
  return {};
}

}  // namespace skein::vision

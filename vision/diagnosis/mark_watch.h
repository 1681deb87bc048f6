#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "vision/calibration/calibration.h"
#include "vision/detector/detector.h"
#include "vision/frames/frame.h"

namespace skein::vision {

/// What a frame shows of the marks on the floor.
struct MarkSight {
  enum class State {
    in_place,      ///< most are where they were, and none is elsewhere
    some_moved,    ///< most are where they were, and some are elsewhere: somebody moved those
    camera_moved,  ///< three and more, and most, are elsewhere
    too_few,       ///< fewer than three are seen: nothing can be said
    unclear,       ///< neither most are where they were, nor most elsewhere
  };
  State state = State::too_few;
  std::size_t marks = 0, seen = 0;
  std::vector<int> moved{};  // tags that are elsewhere
  double by = 0.0;           // mean distance of these, of none moved that of all seen ones [m]
  double turn = 0.0;         // of all seen marks about their middle, counter-clockwise [rad]
};

/// Whether the camera has moved is known; what cannot tell says nothing against what was known before.
bool tells(MarkSight::State state);

/// One sentence without a full stop, for people: "mark 21 was moved by 50 mm, or put back wrongly; the other 5 are
/// where they were".
std::string sentence(const MarkSight& sight);

/// Compares where a camera sees the tags on the floor by which it was calibrated with where it saw them then (with
/// where they were measured, if it did not see them then). All that are seen moved: the camera did. One moved: somebody
/// moved that. A sight counts when the next one agrees, so that neither a hand nor a torn frame is believed; only the
/// first of all counts alone if it finds nothing wrong. For one thread.
class MarkWatch {
 public:
  static constexpr double tolerance = 5e-3;     ///< farther from its place a mark is elsewhere [m]
  static constexpr std::size_t least_seen = 3;  ///< marks, or nothing is said

  /// `not_these`: tags that drive about on robots.
  MarkWatch(const Calibration& calibration, std::span<const int> not_these);

  /// How many marks are looked for; with less than `least_seen` there is nothing to watch.
  std::size_t marks() const noexcept { return marks_.size(); }
  /// 0.1 s at 1280x960, the first time twice as long. True: what is known has changed. The frame must have the
  /// calibration's size.
  bool update(const Frame& frame);
  /// What is known; none: nothing yet.
  const std::optional<MarkSight>& known() const noexcept { return known_; }
  /// The newest sight differs from what is known: look again soon.
  bool doubts() const noexcept { return doubts_; }

 private:
  struct Mark {
    int tag;
    double size, height;    // [m]
    Eigen::Vector2d place;  // where this calibration sees it if nothing has moved [m]
  };
  MarkSight judge(const std::vector<Detection>& found) const;
  std::optional<Eigen::Vector2d> displacement(const Mark& mark, const std::vector<Detection>& found) const;

  Calibration calibration_;
  std::vector<Mark> marks_;
  std::optional<TagDetector> detector_;  // from the first look on
  std::optional<MarkSight> last_, known_;
  bool doubts_ = true;
};

}  // namespace skein::vision

#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "vision/calibration/calibration.h"
#include "vision/detector/detector.h"
#include "vision/diagnosis/diagnosis.h"
#include "vision/diagnosis/lasting_fault.h"
#include "vision/frames/frame.h"

namespace skein::vision {

/// What a frame shows of the marks on the floor.
struct MarkSight {
  enum class State {
    in_place,      ///< most are where they were, and none is elsewhere
    some_moved,    ///< most are where they were, and some are elsewhere: these were moved by hand
    camera_moved,  ///< at least three, and most of those seen, are elsewhere
    too_few,       ///< fewer than three are seen: nothing can be concluded
    unclear,       ///< neither most are where they were, nor most elsewhere
  };
  State state = State::too_few;
  std::size_t marks = 0, seen = 0;
  std::vector<int> moved{};    // tags that are elsewhere
  std::vector<int> missing{};  // tags that are not seen
  double by = 0.0;             // mean displacement of these, or of all seen marks if none moved [m]
  double turn = 0.0;           // of all seen marks about their middle, counter-clockwise [rad]
};

/// Whether this state tells if the camera has moved; one that does not leaves the last known state in force.
bool tells(MarkSight::State state);

/// One sentence without a full stop, for people: "mark 21 was moved by 50 mm, or put back wrongly; the other 5 are
/// where they were".
std::string sentence(const MarkSight& sight);

/// Compares where a camera sees the marks of its floor calibration with where it saw them when it was calibrated (or
/// with their measured places, if it did not see them then). If all visible marks have moved, the camera has; if one
/// has, that mark was moved by hand. A sight counts only when the next one agrees, so that neither a hand in the
/// picture nor a torn frame matters; only the very first one counts alone, if it finds nothing wrong. For one thread.
class MarkWatch {
 public:
  static constexpr double tolerance = 5e-3;     ///< a mark farther than this from its place has moved [m]
  static constexpr std::size_t least_seen = 3;  ///< marks; with fewer the result is too_few

  /// Marks that were seen and are hidden for longer than this are reported: a robot or somebody's arm is gone by then,
  /// a table or a jacket is not. [s]
  static constexpr double patience = 10.0;

  /// `not_these`: tags that drive about on robots.
  MarkWatch(const Calibration& calibration, std::span<const int> not_these);

  /// How many marks are looked for; with fewer than `least_seen` there is nothing to watch.
  std::size_t marks() const noexcept { return marks_.size(); }
  /// Takes 0.1 s at 1280x960, the first time twice as long. True: the known state has changed. The frame must have the
  /// calibration's size.
  bool update(const Frame& frame);
  /// The last known state; none: nothing is known yet.
  const std::optional<MarkSight>& known() const noexcept { return known_; }
  /// The newest sight differs from the known state and is not confirmed yet: look again soon.
  bool doubts() const noexcept { return doubts_; }
  /// The marks that the newest sight lacks, as `diagnose` asks for them.
  std::vector<MissingTag> missing() const;
  /// The newest sight, if for `patience` none has told whether the camera has moved since one did; null otherwise.
  const MarkSight* blind() const noexcept { return blind_ ? &*last_ : nullptr; }

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
  LastingFault unseen_{patience};
  bool blind_ = false;
};

}  // namespace skein::vision

#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "vision/calibration/calibration.h"
#include "vision/frames/frame.h"
#include "vision/tags/scale_change.h"
#include "vision/tags/tag_pose.h"
#include "vision/tracker/tracker_options.h"

namespace skein::vision {

struct TrackerParts;

/// Frames in, poses of the wanted tags out. A tag seen before is fitted photometrically, starting from where it should
/// be by now (a few microseconds); AprilTag finds the first ones and those that are lost: in a window, where a cheap
/// gate sees something like a tag, or in the full frame. Not for two threads at once.
class TagTracker {
 public:
  /// The calibration must have a world frame (std::invalid_argument: that is the caller's mistake).
  TagTracker(Calibration calibration, TrackerOptions options);
  ~TagTracker();
  TagTracker(TagTracker&&) noexcept;
  TagTracker& operator=(TagTracker&&) noexcept;

  /// The wanted tags that this frame shows, in the order of options.tags, each at most once. Valid until the next call.
  /// Tags that another camera sees are looked for at that place, and are missing only if it lies inside this picture.
  const std::vector<TagPose>& process(const Frame& frame, std::span<const SeenElsewhere> elsewhere = {});

  const TrackerCounters& counters() const;

  /// How much larger the tags look than tags of tag_size at tag_height, as a part of it: the median of the wanted tags'
  /// means over their last 100 fits. None: no tag has 25 fits yet.
  std::optional<double> stretch() const;

  /// By how much all tags that the last frame shows, two or more, look larger than they did in the seconds before: the
  /// median. None: they do not agree to 0.4 % and their noise, or fewer than two have 25 fits yet. Where one tag is
  /// lifted they do not agree; where the camera is raised, or its zoom is turned, they do.
  std::optional<ScaleChange> scale_change() const;

  /// The stretch that a wanted tag has shown for seconds, if it looks so different in the last frame that it was not
  /// reported (TrackerCounters::lifted).
  std::optional<double> lifted_from(int tag) const;

  /// How much the camera blurs the tags, across their direction of motion: standard deviation [px], likewise, over 25.
  /// A lens in focus: 0.9, of which 0.5 are the pixels' own.
  std::optional<double> blur() const;

  /// Of the last frame; zeros without TrackerOptions::clock.
  const StageTimes& stage_times() const;

 private:
  std::unique_ptr<TrackerParts> parts_;
};

}  // namespace skein::vision

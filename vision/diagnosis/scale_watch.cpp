#include "vision/diagnosis/scale_watch.h"

#include <fmt/format.h>

#include <cmath>

namespace skein::vision {

std::string ScaleWatch::update(double t, std::optional<double> stretch) {
  if (!stretch || !calibration_.world_from_camera) return {};
  if (!fault_.update(t, std::abs(*stretch) > tolerance)) return {};
  const double distance = calibration_.world_from_camera->position.z() - calibration_.tag_height;
  const double height = calibration_.tag_height + distance * *stretch / (1.0 + *stretch);
  return fmt::format(
      "the tags look {:.1f} % {} than [tags] size {:.1f} mm and height {:.0f} mm make them: measure both. {} size of "
      "{:.1f} mm would fit, or the camera hangs {} than it was calibrated, or fx and fy are too {}; unless it is the "
      "size, distances between robots are wrong by as much",
      100.0 * std::abs(*stretch), *stretch > 0.0 ? "larger" : "smaller", 1e3 * calibration_.tag_size,
      1e3 * calibration_.tag_height, height > 0.0 ? fmt::format("A height of about {:.0f} mm or a", 1e3 * height) : "A",
      1e3 * calibration_.tag_size * (1.0 + *stretch), *stretch > 0.0 ? "lower" : "higher",
      *stretch > 0.0 ? "small" : "large");
}

std::string ScaleWatch::update_change(double t, const std::optional<ScaleChange>& change) {
  const double by = change ? std::abs(change->by) : 0.0;
  const bool large = by > moved_from;
  const bool many = large && change->tags >= 3, pair = large && !many && keeps(*change);
  if (!large) pair_.reset();
  if (!many && !pair) moved_.reset();
  const bool many_have = move_.update(t, many), pair_has = still_.update(t, pair);
  if (many_have || pair_has) moved_ = change;
  if (!change_.update(t, by > steady) || moved_) return {};
  return fmt::format(
      "all {} tags look {:.1f} % {} than a few seconds before: the camera hangs {}, or its zoom or focus has changed. "
      "Distances from the middle of the picture are wrong by as much until it is calibrated again, unless the robots "
      "themselves were {}",
      change->tags, 100.0 * by, change->by > 0.0 ? "larger" : "smaller", change->by > 0.0 ? "lower" : "higher",
      change->by > 0.0 ? "lifted" : "put down");
}

/// Whether a change that two tags show is the one that they showed first.
bool ScaleWatch::keeps(const ScaleChange& change) {
  const bool same = pair_ && std::abs(change.by - *pair_) < same_change;
  if (!same) pair_ = change.by;
  return same;
}

}  // namespace skein::vision

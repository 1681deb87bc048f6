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
      "{:.1f} mm would fit, or the camera hangs {} than it was calibrated; unless it is the size, distances between "
      "robots are wrong by as much",
      100.0 * std::abs(*stretch), *stretch > 0.0 ? "larger" : "smaller", 1e3 * calibration_.tag_size,
      1e3 * calibration_.tag_height, height > 0.0 ? fmt::format("A height of about {:.0f} mm or a", 1e3 * height) : "A",
      1e3 * calibration_.tag_size * (1.0 + *stretch), *stretch > 0.0 ? "lower" : "higher");
}

}  // namespace skein::vision

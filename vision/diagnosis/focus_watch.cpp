#include "vision/diagnosis/focus_watch.h"

#include <fmt/format.h>

#include <algorithm>

namespace skein::vision {

std::string FocusWatch::update(double t, std::optional<double> blur) {
  if (!blur) return {};
  sharpest_ = std::min(sharpest_, *blur);
  const bool drifted = *blur > sharpest_ + growth, out = drifted || *blur > blurred;
  out_of_focus_ = out ? blur : std::nullopt;
  if (!fault_.update(t, out)) return {};
  constexpr const char* remedy =
      "turn the lens's focus and fix it, or set camera.focus, which turns an autofocus off; small tags are lost next";
  return drifted ? fmt::format(
                       "the focus has drifted: tags are blurred by {:.1f} px (standard deviation), {:.1f} px "
                       "when they were sharpest: {}",
                       *blur, sharpest_, remedy)
                 : fmt::format(
                       "the picture is not in focus: tags are blurred by {:.1f} px (standard deviation), 0.8 "
                       "px in focus: {}",
                       *blur, remedy);
}

}  // namespace skein::vision

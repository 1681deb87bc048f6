#include "vision/diagnosis/edge_widths.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace skein::vision::detail {

void edge_widths(const Frame& frame, const Window& part, double noise, std::vector<double>& widths) {
  const double least_slope = std::max(8.0, 2.0 * noise), least_difference = std::max(30.0, 3.0 * noise);
  const int left = std::max(0, part.left), top = std::max(0, part.top);
  const int right = std::min(frame.width, part.left + part.width);
  const int bottom = std::min(frame.height, part.top + part.height);
  const auto along = [&](const std::uint8_t* from, std::ptrdiff_t step, std::ptrdiff_t aside, int count) {
    const auto grey = [&](int i) {  // three neighbours along the edge have less noise
      const std::uint8_t* at = from + i * step;
      return (at[-aside] + at[0] + at[aside]) / 3.0;
    };
    const auto slope = [&](int i) { return 0.5 * (grey(i + 1) - grey(i - 1)); };
    for (int i = 2; i + 2 < count; ++i) {
      const double steepest = slope(i);
      const double size = std::abs(steepest);
      if (size < least_slope || size < std::abs(slope(i - 1)) || size <= std::abs(slope(i + 1))) continue;
      const double across = 0.5 * (from[i * step + aside] - from[i * step - aside]);
      if (std::abs(across) > size) continue;  // the other direction sees it better
      int first = i, last = i;
      const auto goes_on = [&](int k) { return slope(k) * steepest > 0.1 * steepest * steepest; };
      while (first > 2 && goes_on(first - 1)) --first;
      while (last + 3 < count && goes_on(last + 1)) ++last;
      const double difference = std::abs(grey(last + 1) - grey(first - 1));
      if (difference >= least_difference) widths.push_back(difference / std::hypot(size, across));
      i = last;
    }
  };
  for (int v = std::max(1, top); v < std::min(bottom, frame.height - 1); v += 2)
    along(frame.row(v) + left, 1, frame.width, right - left);
  for (int u = std::max(1, left); u < std::min(right, frame.width - 1); u += 2)
    along(frame.row(top) + u, frame.width, 1, bottom - top);
}

std::string range_of(std::span<const double> edge_widths) {
  const auto [least, most] = std::minmax_element(edge_widths.begin(), edge_widths.end());
  std::string from = fmt::format("{:.1f}", *least), to = fmt::format("{:.1f}", *most);
  return from == to ? from : from + " to " + to;
}

std::string blur_sentence(std::span<const double> edge_widths) {
  return fmt::format(
      "{} picture is blurred (its edges are {} px wide, those of a sharp one 2 to 3): turn the lens's focus, or "
      "shorten the exposure",
      edge_widths.size() == 1 ? "the" : "each", range_of(edge_widths));
}

}  // namespace skein::vision::detail

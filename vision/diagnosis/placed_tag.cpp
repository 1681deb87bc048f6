#include "vision/diagnosis/placed_tag.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <utility>
#include <vector>

#include "vision/frames/grey_at.h"
#include "vision/tags/tag_pattern.h"

namespace skein::vision::detail {
namespace {

constexpr int cells_a_side = pattern_cells;
constexpr double modules_an_edge = 8.0;
constexpr double least_step = 6.0;   // between ink and paper beside one another [grey levels]
constexpr double saturated = 250.0;  // [grey levels]
constexpr double clear_step = 20.0;  // mean of what is taken for a part of a tag; a floor's texture has less

using Greys = std::array<double, static_cast<std::size_t>(cells_a_side) * cells_a_side>;

/// A module of ink and one of paper that lie side by side in a tag.
struct Step {
  std::size_t ink, paper;
  bool of_bits;  // not between the black frame, which all tags have, and the white border
};

std::size_t cell(int row, int column) {
  return static_cast<std::size_t>(row) * cells_a_side + static_cast<std::size_t>(column);
}

bool in_border(int row, int column) {
  return std::min({row, column, cells_a_side - 1 - row, cells_a_side - 1 - column}) == 0;
}

std::vector<Step> steps_of(const TagPattern& pattern) {
  std::vector<Step> steps;
  const auto add = [&](int row, int column, int other_row, int other_column) {
    const auto a = cell(row, column);
    const auto b = cell(other_row, other_column);
    if (pattern[a] == pattern[b]) return;
    const bool of_bits = !in_border(row, column) && !in_border(other_row, other_column);
    steps.push_back({pattern[a] ? b : a, pattern[a] ? a : b, of_bits});
  };
  for (int row = 0; row < cells_a_side; ++row)
    for (int column = 0; column < cells_a_side; ++column) {
      if (column + 1 < cells_a_side) add(row, column, row, column + 1);
      if (row + 1 < cells_a_side) add(row, column, row + 1, column);
    }
  return steps;
}

/// How a frame shows the modules of a tag at a pose.
class Modules {
 public:
  Modules(const Frame& frame, const Calibration& calibration) : frame_(frame), calibration_(calibration) {}

  /// False: not all of them are in the frame.
  bool read(const Eigen::Vector2d& place, double theta, Greys& greys) const {
    const double module = calibration_.tag_size / modules_an_edge, c = std::cos(theta), s = std::sin(theta);
    for (int row = 0; row < cells_a_side; ++row)
      for (int column = 0; column < cells_a_side; ++column) {
        const double ahead = (column - 0.5 * (cells_a_side - 1)) * module,
                     left = (0.5 * (cells_a_side - 1) - row) * module;
        const auto found = grey({place.x() + c * ahead - s * left, place.y() + s * ahead + c * left});
        if (!found) return false;
        greys[cell(row, column)] = *found;
      }
    return true;
  }

 private:
  /// At a point of the plane.
  std::optional<double> grey(const Eigen::Vector2d& at) const {
    const auto pixel = pixel_from_world(calibration_, {at.x(), at.y(), calibration_.tag_height});
    return pixel ? grey_at(frame_, pixel->x(), pixel->y()) : std::nullopt;
  }
  const Frame& frame_;
  const Calibration& calibration_;
};

/// How many of some steps go as in the tag: 1 for all of them, 0 for as many right as wrong ones or for none at all.
struct Agreement {
  int steps = 0, bits = 0, right = 0, right_bits = 0;
  double rises = 0.0;  // sum over the steps [grey levels]
  void count(const Step& step, const Greys& greys) {
    const double rise = greys[step.paper] - greys[step.ink];
    const int sign = std::abs(rise) < least_step ? 0 : rise > 0.0 ? 1 : -1;
    ++steps, right += sign, rises += rise;
    if (step.of_bits) ++bits, right_bits += sign;
  }
  double share() const { return steps > 0 ? static_cast<double>(right) / steps : 0.0; }
  double mean_rise() const { return steps > 0 ? rises / steps : 0.0; }
  double share_of_bits() const { return bits > 0 ? static_cast<double>(right_bits) / bits : 0.0; }
};

/// Of the whole tag, and of its left, right, upper and lower half.
std::array<Agreement, 5> agreements(const std::vector<Step>& steps, const Greys& greys) {
  std::array<Agreement, 5> all;
  for (const Step& step : steps) {
    const bool left = step.ink % cells_a_side < cells_a_side / 2, upper = step.ink / cells_a_side < cells_a_side / 2;
    all[0].count(step, greys);
    all[left ? 1 : 2].count(step, greys);
    all[upper ? 3 : 4].count(step, greys);
  }
  return all;
}

/// The darkest and the brightest side of a square of modules. `depth`: 0 for the white border, 1 for the black frame.
std::pair<double, double> sides_of(const Greys& greys, int depth) {
  std::array<double, 4> sides{};
  const int last = cells_a_side - 1 - depth, count = last - depth;
  for (int k = depth; k < last; ++k) {  // each corner belongs to one side
    const int back = cells_a_side - 1 - k;
    const std::array<std::pair<int, int>, 4> around{{{depth, k}, {k, last}, {last, back}, {back, depth}}};
    for (std::size_t i = 0; i < 4; ++i) sides[i] += greys[cell(around[i].first, around[i].second)] / count;
  }
  const auto [least, most] = std::minmax_element(sides.begin(), sides.end());
  return {*least, *most};
}

/// Of a tag that is all there, or nearly so: the light on it. `share`: of its steps that go as in the tag.
TagRemains light_on(const TagPattern& pattern, const Greys& greys, double share) {
  constexpr double uneven = 1.7;        // of the paper's grey levels; a lamp over an arena makes less from edge to edge
  constexpr double every_step = 0.92;   // under something dark that covers a part, ink and paper are the same
  constexpr double brighter_ink = 0.5;  // of what is brighter on the paper; that in a shadow and in the light is less
  constexpr double clear_reflection = 60.0;  // [grey levels]; blur and a place half a module off make a third of it
  constexpr double bright_paper = 230.0;     // [grey levels]
  // A reflection is added to ink and paper alike.
  const auto [dark_ink, bright_ink] = sides_of(greys, 1);
  const auto [dark_side, bright_side] = sides_of(greys, 0);
  const double more_ink = bright_ink - dark_ink;
  if (bright_side > bright_paper && more_ink > clear_reflection && more_ink > brighter_ink * (bright_side - dark_side))
    return TagRemains::reflection;
  std::vector<double> paper;
  for (std::size_t k = 0; k < greys.size(); ++k)
    if (pattern[k]) paper.push_back(greys[k]);
  std::sort(paper.begin(), paper.end());
  const std::size_t tenth = paper.size() / 10;
  if (paper[paper.size() - 1 - tenth] <= uneven * paper[tenth]) return TagRemains::whole;
  return share >= every_step ? TagRemains::shadow : TagRemains::part;
}

/// Most of the steps that do not go as in the tag have saturated ink.
bool lost_in_light(const std::vector<Step>& steps, const Greys& greys) {
  std::size_t lost = 0, bright = 0;
  for (const Step& step : steps) {
    if (greys[step.paper] - greys[step.ink] >= least_step) continue;
    ++lost;
    bright += greys[step.ink] >= saturated ? 1 : 0;
  }
  return 2 * bright > lost;
}

}  // namespace

TagRemains remains_of_tag(const Frame& frame, const Calibration& calibration, const Eigen::Vector2d& place, int tag) {
  constexpr double all_of_it = 0.8, most_of_a_half = 0.6, some_bits = 0.5;
  constexpr int enough_bits = 8, turns = 60, reach = 2;  // a place is known to a module, in steps of half of one
  const TagPattern pattern = tag_patterns().at(static_cast<std::size_t>(tag));
  const std::vector<Step> steps = steps_of(pattern);
  const Modules shown(frame, calibration);
  const double half_module = 0.5 * calibration.tag_size / modules_an_edge;
  TagRemains remains = TagRemains::none;
  double best_rise = 0.0, best_half = most_of_a_half;
  Greys greys{};
  for (int turn = 0; turn < turns; ++turn)
    for (int i = -reach; i <= reach; ++i)
      for (int j = -reach; j <= reach; ++j) {
        const Eigen::Vector2d at = place + half_module * Eigen::Vector2d(i, j);
        if (!shown.read(at, 2.0 * std::numbers::pi * turn / turns, greys)) continue;
        const auto all = agreements(steps, greys);
        // Where the modules are met best, ink and paper differ most.
        if (all[0].share() >= all_of_it && all[0].mean_rise() > best_rise) {
          best_rise = all[0].mean_rise();
          best_half = 1.0;
          remains = light_on(pattern, greys, all[0].share());
        }
        for (std::size_t half = 1; half < all.size(); ++half) {
          const bool there = all[half].bits >= enough_bits && all[half].share_of_bits() >= some_bits &&
                             all[half].mean_rise() >= clear_step;
          if (!there || all[half].share() <= best_half) continue;
          best_half = all[half].share();
          remains = lost_in_light(steps, greys) ? TagRemains::reflection : TagRemains::part;
        }
      }
  return remains;
}

bool fits_best(const Frame& frame, const Calibration& calibration, const core::Pose& pose, int tag) {
  constexpr int turns = 3, reach = 2;
  constexpr double turn_step = 4.0 * std::numbers::pi / 180.0;
  const Modules shown(frame, calibration);
  const double half_module = 0.5 * calibration.tag_size / modules_an_edge;
  std::vector<Greys> views;
  Greys greys{};
  for (int turn = -turns; turn <= turns; ++turn)
    for (int i = -reach; i <= reach; ++i)
      for (int j = -reach; j <= reach; ++j) {
        const Eigen::Vector2d at = Eigen::Vector2d(pose.x, pose.y) + half_module * Eigen::Vector2d(i, j);
        if (shown.read(at, pose.theta + turn * turn_step, greys)) views.push_back(greys);
      }
  const auto best_of = [&](const TagPattern& pattern) {
    const std::vector<Step> steps = steps_of(pattern);
    double best = -1.0;
    for (const Greys& view : views) {
      Agreement all;
      for (const Step& step : steps) all.count(step, view);
      best = std::max(best, all.share());
    }
    return best;
  };
  const auto& patterns = tag_patterns();
  const auto own = static_cast<std::size_t>(tag);
  const double best = best_of(patterns.at(own));
  for (std::size_t other = 0; other < patterns.size(); ++other)
    if (other != own && best_of(patterns[other]) >= best) return false;
  return true;
}

}  // namespace skein::vision::detail

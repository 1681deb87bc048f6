#include "vision/diagnosis/cut_tags.h"

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <Eigen/LU>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <numbers>
#include <utility>

#include "core/math/elementary.h"
#include "vision/diagnosis/light_limits.h"
#include "vision/tags/tag_pattern.h"
#include "vision/tags/tag_plane.h"

namespace skein::vision::detail {
namespace {

constexpr int side = pattern_cells;
constexpr std::size_t cells = static_cast<std::size_t>(side) * side;
constexpr double modules = 8.0;  // of a tag's edge
constexpr int least_bits = 18;
constexpr double least_correlation = 0.9;  // of a tag that is in place; sharp ones have 0.97, others at most 0.95
// The border leaves what is whole; a cover's edge may lie in what is compared. Free halves have 0.97, others 0.93.
constexpr double least_of_a_half = 0.95;
constexpr double least_of_a_guess = 0.4;  // of one that is half a module and 4 degrees away

/// Means of a frame over the squares around its pixels, computed once: the search asks for each of them many times.
class SquareMeans {
 public:
  /// `half`: of a square's side, rounded to pixels around the one in its middle.
  SquareMeans(const Frame& frame, double half)
      : reach_(static_cast<int>(std::lround(half))),
        width_(frame.width),
        height_(frame.height),
        means_(static_cast<std::size_t>(frame.width) * static_cast<std::size_t>(frame.height)) {
    const int square = 2 * reach_ + 1;
    std::vector<int> columns(static_cast<std::size_t>(width_));  // sums over the rows of a square
    for (int v = 0; v < height_; ++v) {
      for (int u = 0; u < width_; ++u) {
        int& sum = columns[static_cast<std::size_t>(u)];
        sum += frame.row(v)[u] - (v >= square ? frame.row(v - square)[u] : 0);
      }
      if (v + 1 < square) continue;
      int sum = 0;
      for (int u = 0; u < width_; ++u) {
        sum += columns[static_cast<std::size_t>(u)];
        if (u >= square) sum -= columns[static_cast<std::size_t>(u - square)];
        if (u + 1 >= square)
          means_[at(u - reach_, v - reach_)] = static_cast<float>(sum) / static_cast<float>(square * square);
      }
    }
  }
  /// Around a pixel that is `reach()` or more inside the frame's border.
  float mean_inside(int u, int v) const { return means_[at(u, v)]; }
  int reach() const { return reach_; }
  /// Around the pixel that is next to a place; none: the square reaches over the frame's border.
  std::optional<float> mean(const Eigen::Vector2d& middle) const {
    const double u = middle.x() + 0.5, v = middle.y() + 0.5;
    if (!(u >= reach_ && v >= reach_ && u < width_ - reach_ && v < height_ - reach_))
      return {};  // nor if it is no number
    return means_[at(static_cast<int>(u), static_cast<int>(v))];
  }

 private:
  std::size_t at(int u, int v) const {
    return static_cast<std::size_t>(v) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(u);
  }
  int reach_, width_, height_;
  std::vector<float> means_;
};

constexpr int depth(std::size_t cell) {  // 0: the white border, 1: the black one, more: a bit
  const int row = static_cast<int>(cell) / side, column = static_cast<int>(cell) % side;
  return std::min({row, column, side - 1 - row, side - 1 - column});
}

constexpr bool is_bit(std::size_t cell) {
  return depth(cell) > 1;
}

struct Cell {
  std::size_t k = 0;      // row by row
  Eigen::Vector2d place;  // of its middle in the tag [modules]
  bool border = false;    // the white one
};

/// The cells that all tags share, in an order in which the first few are spread over all sides, and the bits.
struct Cells {
  std::vector<Cell> shared, bits;
  explicit Cells(bool left_half) {
    constexpr std::size_t apart = 7;
    for (std::size_t first = 0; first < apart; ++first)
      for (std::size_t k = first; k < cells; k += apart) {
        if (left_half && k % side >= side / 2) continue;
        const std::size_t row = k / side, column = k % side;
        const Eigen::Vector2d place(static_cast<double>(column) - 0.5 * (side - 1),
                                    0.5 * (side - 1) - static_cast<double>(row));
        (is_bit(k) ? bits : shared).push_back({k, place, depth(k) == 0});
      }
  }
};

/// A tag's plane around one place of the picture.
struct Spot {
  Eigen::Vector2d pixel, world;
  Eigen::Matrix2d px_per_metre;
};

std::optional<Spot> spot_at(const Calibration& calibration, const Eigen::Vector2d& pixel) {
  const auto world = world_from_pixel(calibration, pixel, calibration.tag_height);
  if (!world) return {};
  Spot spot{pixel, *world, {}};
  const double reach = 0.5 * calibration.tag_size;
  for (int axis = 0; axis < 2; ++axis) {
    Eigen::Vector3d ahead(world->x(), world->y(), calibration.tag_height), behind = ahead;
    ahead[axis] += reach;
    behind[axis] -= reach;
    const auto there = pixel_from_world(calibration, ahead), here = pixel_from_world(calibration, behind);
    if (!there || !here) return {};
    spot.px_per_metre.col(axis) = (*there - *here) / (2.0 * reach);
  }
  return spot;
}

using CellValues = std::array<float, cells>;

/// What a frame shows of the cells of a tag that is at a pose.
struct View {
  CellValues grey{};
  CellValues deviation{};  // of what is shown, from its mean; else 0 [grey levels]
  double count = 0.0;      // of the cells that are shown
  double spread = 0.0;     // the sum of the deviations' squares
  std::array<bool, cells> shown{};
  bool cut = false;     // not all cells are
  double middle = 0.0;  // between the cells that all tags have in paper and those that all have in ink [grey levels]
};

/// Grey levels of the cells that are ink in all tags, and of those that are paper in all.
struct Contrast {
  std::array<double, 2> sum{}, count{};  // of ink, of paper

  /// Whether the cell is shown.
  bool add(const Cell& cell, const std::optional<float>& grey) {
    if (!grey) return false;
    const std::size_t which = cell.border ? 1 : 0;
    sum[which] += *grey;
    count[which] += 1.0;
    return true;
  }
  /// The paper is brighter by so much, or one of them is not shown.
  bool reaches(double least) const { return sum[1] * count[0] - sum[0] * count[1] >= least * count[0] * count[1]; }
  bool shows_both() const { return count[0] > 0.0 && count[1] > 0.0; }
  double middle() const { return 0.5 * (sum[0] / count[0] + sum[1] / count[1]); }
};

// Of nearly all places a few cells show that no tag is there: more than those are not worth their time there.
constexpr std::size_t glance = 6, first_look = 16;  // cells

class Viewer {
 public:
  /// `left_half`: only of the half that is on the left in the view; the other one is not looked at.
  Viewer(const Frame& frame, const Calibration& calibration, bool left_half)
      : means_(frame, 0.3 * tag_edge_px(calibration) / modules),
        module_(calibration.tag_size / modules),
        cells_(left_half) {}

  /// None: too little of a tag, or nothing that could be one.
  std::optional<View> view(const Spot& spot, double theta) const {
    return view(spot, Eigen::Rotation2Dd(theta).toRotationMatrix());
  }
  /// At the angle of a rotation matrix.
  std::optional<View> view(const Spot& spot, const Eigen::Matrix2d& rotation) const {
    const Eigen::Matrix2d px_per_module = module_ * spot.px_per_metre * rotation;
    const auto grey_of = [&](const Cell& cell) { return means_.mean(spot.pixel + px_per_module * cell.place); };
    Contrast contrast;
    std::size_t next = 0, seen = 0;
    const auto look_at = [&](std::size_t enough) {
      for (; next < cells_.shared.size() && seen < enough; ++next)
        seen += contrast.add(cells_.shared[next], grey_of(cells_.shared[next])) ? 1 : 0;
    };
    look_at(glance);
    if (!contrast.reaches(0.5 * least_contrast)) return {};
    look_at(first_look);
    if (!contrast.reaches(least_contrast)) return {};
    return whole_view(grey_of);
  }

  /// Around the middle of a tag of this edge [px] no two modules could be ink and paper.
  bool is_plain(const Eigen::Vector2d& pixel, double edge) const {
    const double module = edge / modules;
    float darkest = 255.0F, brightest = 0.0F;
    for (int row = -2; row <= 2; ++row)
      for (int column = -2; column <= 2; ++column) {
        const auto grey = means_.mean(pixel + module * Eigen::Vector2d(column, row));
        if (!grey) continue;
        darkest = std::min(darkest, *grey);
        brightest = std::max(brightest, *grey);
      }
    return brightest - darkest < least_contrast;
  }

  const SquareMeans& means() const { return means_; }
  std::span<const Cell> first_cells() const { return std::span(cells_.shared).first(first_look); }
  double module() const { return module_; }
  /// How many of the cells that are looked at are paper in a tag.
  double papers_of(const TagPattern& tag) const {
    double papers = 0.0;
    for (const auto* some : {&cells_.shared, &cells_.bits})
      for (const Cell& cell : *some) papers += tag[cell.k] ? 1.0 : 0.0;
    return papers;
  }

 private:
  template <typename GreyOf>
  std::optional<View> whole_view(const GreyOf& grey_of) const {
    View view;
    const auto look = [&](const Cell& cell) {
      const auto grey = grey_of(cell);
      view.shown[cell.k] = grey.has_value();
      view.cut = view.cut || !grey;
      if (grey) view.grey[cell.k] = *grey;
      return grey;
    };
    Contrast contrast;
    for (const Cell& cell : cells_.shared) contrast.add(cell, look(cell));
    if (!contrast.shows_both() || !contrast.reaches(least_contrast)) return {};
    view.middle = contrast.middle();
    int bits = 0;
    for (const Cell& cell : cells_.bits) bits += look(cell) ? 1 : 0;
    if (bits < least_bits) return {};
    compare_with_mean(view);
    return view;
  }

  static void compare_with_mean(View& view) {
    double sum = 0.0;
    for (std::size_t k = 0; k < cells; ++k)
      if (view.shown[k]) sum += view.grey[k], view.count += 1.0;
    const auto mean = static_cast<float>(sum / view.count);
    for (std::size_t k = 0; k < cells; ++k) {
      if (view.shown[k]) view.deviation[k] = view.grey[k] - mean;
      view.spread += core::math::squared(view.deviation[k]);
    }
  }

  SquareMeans means_;
  double module_;  // [m]
  Cells cells_;
};

/// What a viewer looks at first, at all angles of a search. Where the cells are around the middle of a tag is computed
/// once for all middles that are less than an edge away.
class FirstLooks {
 public:
  FirstLooks(const Viewer& viewer, const Spot& spot, std::span<const Eigen::Matrix2d> rotations)
      : means_(viewer.means()), steps_(rotations.size() * first_look) {
    const std::span<const Cell> first = viewer.first_cells();
    for (const std::span<float> weights : {std::span<float>(of_a_glance_), std::span<float>(of_a_first_look_)}) {
      std::array<float, 2> count{};  // of ink, of paper
      for (const Cell& cell : first.first(weights.size())) count[cell.border ? 1 : 0] += 1.0F;
      for (std::size_t k = 0; k < weights.size(); ++k)
        weights[k] = first[k].border ? 1.0F / count[1] : -1.0F / count[0];
    }
    auto step = steps_.begin();
    for (const Eigen::Matrix2d& rotation : rotations)
      for (const Cell& cell : first) {
        const Eigen::Vector2d place = viewer.module() * spot.px_per_metre * rotation * cell.place;
        *step = {static_cast<int>(std::lround(place.x())), static_cast<int>(std::lround(place.y()))};
        farthest_ = std::max({farthest_, std::abs(step->u), std::abs(step->v)});
        ++step;
      }
  }
  /// Whether all cells that are looked at are shown.
  bool fit(const Frame& frame, int u, int v) const {
    const int reach = farthest_ + means_.reach();
    return u >= reach && v >= reach && u < frame.width - reach && v < frame.height - reach;
  }
  /// Whether the paper of what could be a tag there is bright enough. They have to fit.
  bool show_contrast(int u, int v, std::size_t angle) const {
    const Step* step = &steps_[angle * first_look];
    const auto contrast = [&](const auto& weights) {
      float sum = 0.0F;
      for (std::size_t k = 0; k < weights.size(); ++k)
        sum += weights[k] * means_.mean_inside(u + step[k].u, v + step[k].v);
      return sum;
    };
    return contrast(of_a_glance_) >= 0.5F * least_contrast && contrast(of_a_first_look_) >= least_contrast;
  }

 private:
  struct Step {
    int u, v;
  };
  const SquareMeans& means_;
  std::array<float, glance> of_a_glance_{};
  std::array<float, first_look> of_a_first_look_{};
  std::vector<Step> steps_;  // by angle, then cell [px]
  int farthest_ = 0;
};

/// As it lies where a tag that is turned by a quarter to the left has it upright.
TagPattern turned(const TagPattern& pattern) {
  TagPattern result{};
  for (std::size_t row = 0; row < side; ++row)
    for (std::size_t column = 0; column < side; ++column)
      result[row * side + column] = pattern[column * side + side - 1 - row];
  return result;
}

/// All bits that are shown are the tag's.
bool reads_as(const View& view, const TagPattern& pattern) {
  for (std::size_t k = 0; k < cells; ++k)
    if (is_bit(k) && view.shown[k] && (view.grey[k] > view.middle) != pattern[k]) return false;
  return true;
}

/// They are no other tag's, turned in any way: what the border leaves of two tags may be the same.
bool reads_only_as(const View& view, const TagPattern& tag, const std::vector<TagPattern>& all) {
  if (!reads_as(view, tag)) return false;
  int ways = 0;
  for (TagPattern pattern : all)
    for (int turn = 0; turn < 4; ++turn, pattern = turned(pattern)) ways += reads_as(view, pattern) ? 1 : 0;
  return ways == 1;
}

struct Guess {
  Eigen::Vector2d pixel;
  double theta = 0.0;    // of the view
  std::size_t turn = 0;  // quarters to the left from the view to the tag
  double correlation = 0.0;
};

constexpr double quarter = 0.5 * std::numbers::pi;

/// A tag as a view would show it without noise.
struct Expected {
  TagPattern pattern;
  double papers;       // in all that is looked at
  CellValues paper{};  // 1, else 0

  Expected(const TagPattern& tag, const Viewer& viewer) : pattern(tag), papers(viewer.papers_of(tag)) {
    for (std::size_t k = 0; k < cells; ++k) paper[k] = tag[k] ? 1.0F : 0.0F;
  }
};

/// The correlation of what is shown with a tag.
double correlation(const View& view, const Expected& tag) {
  constexpr std::size_t lanes = 4;  // sums that do not wait for each other
  static_assert(cells % lanes == 0);
  std::array<float, lanes> products{};
  for (std::size_t k = 0; k < cells; k += lanes)
    for (std::size_t lane = 0; lane < lanes; ++lane) products[lane] += view.deviation[k + lane] * tag.paper[k + lane];
  double papers = tag.papers;
  if (view.cut) {
    papers = 0.0;
    for (std::size_t k = 0; k < cells; ++k) papers += view.shown[k] ? tag.paper[k] : 0.0F;
  }
  const double spread = view.spread * papers * (1.0 - papers / view.count);
  const double product = (products[0] + products[1]) + (products[2] + products[3]);
  return spread > 0.0 ? product / std::sqrt(spread) : 0.0;
}

using Turns = std::array<Expected, 4>;

Turns turns_of(const TagPattern& tag, const Viewer& viewer) {
  const TagPattern once = turned(tag), twice = turned(once);
  return {Expected(tag, viewer), Expected(once, viewer), Expected(twice, viewer), Expected(turned(twice), viewer)};
}

/// Where one of the tags that are turned in `tags` may be, of which the border hides a part, or, if `covered`,
/// something else: the best place in each square of half an edge, with the tag's index.
std::vector<std::pair<std::size_t, Guess>> guesses_of(const Frame& frame, const Calibration& calibration,
                                                      const Viewer& viewer, double step, double edge,
                                                      const std::vector<Turns>& tags, bool covered, const Window& part,
                                                      const std::stop_token& stop) {
  constexpr int angles = 12;                               // of a quarter: 7.5 degrees
  const int all_angles = covered ? 4 * angles : angles;    // the half that is left may be on any side
  const double outside = 0.2 * edge, inside = 0.9 * edge;  // the middle of a tag that is cut [px]
  std::vector<Eigen::Matrix2d> rotations;
  rotations.reserve(static_cast<std::size_t>(all_angles));
  for (int angle = 0; angle < all_angles; ++angle)
    rotations.push_back(Eigen::Rotation2Dd(quarter * angle / angles).toRotationMatrix());
  std::map<std::array<long, 3>, Guess> best;
  const auto look_at = [&](int u, int v, const FirstLooks* first) {
    std::optional<Spot> spot;
    for (std::size_t angle = 0; angle < rotations.size(); ++angle) {
      if (first && !first->show_contrast(u, v, angle)) continue;
      if (!spot) spot = spot_at(calibration, Eigen::Vector2d(u, v));
      if (!spot) return;
      const auto view = viewer.view(*spot, rotations[angle]);
      for (std::size_t i = 0; view && i < tags.size(); ++i)
        for (std::size_t turn = 0; turn < 4; ++turn) {
          const double like = correlation(*view, tags[i][turn]);
          if (like < least_of_a_guess) continue;
          Guess& guess = best[{static_cast<long>(i), std::lround(2.0 * u / edge), std::lround(2.0 * v / edge)}];
          if (like > guess.correlation)
            guess = {Eigen::Vector2d(u, v), quarter * static_cast<double>(angle) / angles, turn, like};
        }
    }
  };
  const auto inner = [&](int u, int v) {
    return std::min({1.0 * u, 1.0 * v, frame.width - 1.0 - u, frame.height - 1.0 - v}) > inside;
  };
  const auto column = [&](int k) { return static_cast<int>(std::lround(part.left - outside + k * step)); };
  const auto row = [&](int k) { return static_cast<int>(std::lround(part.top - outside + k * step)); };
  const int columns = static_cast<int>((part.width + 2.0 * outside) / step) + 1;
  const int rows = static_cast<int>((part.height + 2.0 * outside) / step) + 1;
  const int square = static_cast<int>(edge / step);
  for (int top = 0; top < rows && !stop.stop_requested(); top += square)
    for (int left = 0; left < columns; left += square) {
      const auto middle = spot_at(calibration, Eigen::Vector2d(column(left + square / 2), row(top + square / 2)));
      std::optional<FirstLooks> first;
      for (int v = top; v < std::min(top + square, rows); ++v)
        for (int u = left; u < std::min(left + square, columns); ++u) {
          const int x = column(u), y = row(v);
          if (covered ? viewer.is_plain(Eigen::Vector2d(x, y), edge) : inner(x, y)) continue;
          if (!first && middle) first.emplace(viewer, *middle, rotations);
          look_at(x, y, first && first->fit(frame, x, y) ? &*first : nullptr);
        }
    }
  std::vector<std::pair<std::size_t, Guess>> all;
  all.reserve(best.size());
  for (const auto& [place, guess] : best) all.emplace_back(static_cast<std::size_t>(place[0]), guess);
  return all;
}

/// Moves and turns a guess by smaller and smaller steps to where it is most like the tag.
void improve(Guess& guess, const Calibration& calibration, const Viewer& viewer, double step, const Expected& tag) {
  constexpr double first_turn = 0.06;  // [rad]
  for (double part = 1.0; part > 0.05; part *= 0.5) {
    const double move = part * step, turn = part * first_turn;
    for (bool better = true; better;) {
      better = false;
      for (const auto& [du, dv, dtheta] :
           {std::array{move, 0.0, 0.0}, std::array{-move, 0.0, 0.0}, std::array{0.0, move, 0.0},
            std::array{0.0, -move, 0.0}, std::array{0.0, 0.0, turn}, std::array{0.0, 0.0, -turn}}) {
        Guess other{guess.pixel + Eigen::Vector2d(du, dv), guess.theta + dtheta, guess.turn};
        const auto spot = spot_at(calibration, other.pixel);
        const auto view = spot ? viewer.view(*spot, other.theta) : std::nullopt;
        if (!view) continue;
        other.correlation = correlation(*view, tag);
        if (other.correlation <= guess.correlation) continue;
        guess = other;
        better = true;
      }
    }
  }
}

std::vector<std::optional<core::Pose>> find(const Frame& frame, const Calibration& calibration,
                                            std::span<const int> tags, bool covered, const Window& part,
                                            const std::stop_token& stop) {
  std::vector<std::optional<core::Pose>> found(tags.size());
  const double edge = tag_edge_px(calibration), step = std::max(1.0, edge / (2.0 * modules));  // half a module
  if (tags.empty() || !(edge >= modules && edge < frame.width + frame.height)) return found;
  const std::vector<TagPattern> all = tag_patterns();
  std::vector<Turns> wanted;
  const Viewer viewer(frame, calibration, covered);
  for (const int tag : tags) wanted.push_back(turns_of(all.at(static_cast<std::size_t>(tag)), viewer));
  std::vector<double> best(tags.size(), covered ? least_of_a_half : least_correlation);
  for (auto& [i, guess] : guesses_of(frame, calibration, viewer, step, edge, wanted, covered, part, stop)) {
    if (stop.stop_requested()) break;
    const Expected& tag = wanted[i][guess.turn];
    improve(guess, calibration, viewer, step, tag);
    const auto spot = spot_at(calibration, guess.pixel);
    const auto view = spot ? viewer.view(*spot, guess.theta) : std::nullopt;
    if (!view || guess.correlation < best[i] || !(covered || view->cut) || !reads_only_as(*view, tag.pattern, all))
      continue;
    best[i] = guess.correlation;
    const double theta = guess.theta + quarter * static_cast<double>(guess.turn);
    found[i] = core::Pose{spot->world.x(), spot->world.y(), core::wrap_angle(theta)};
  }
  return found;
}

}  // namespace

std::vector<std::optional<core::Pose>> find_cut_tags(const Frame& frame, const Calibration& calibration,
                                                     std::span<const int> tags) {
  return find(frame, calibration, tags, false, {0, 0, frame.width, frame.height}, {});
}

std::vector<std::optional<core::Pose>> find_covered_tags(const Frame& frame, const Calibration& calibration,
                                                         std::span<const int> tags, const Window& part,
                                                         const std::stop_token& stop) {
  return find(frame, calibration, tags, true, part, stop);
}

}  // namespace skein::vision::detail

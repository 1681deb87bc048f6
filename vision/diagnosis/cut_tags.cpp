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

/// What a frame shows of the cells of a tag that is at a pose.
struct View {
  std::array<float, cells> grey{};
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
    // Of nearly all places a few cells show that no tag is there: more than those are not worth their time there.
    constexpr std::size_t glance = 6, first_look = 16;  // cells
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
    return view;
  }

  SquareMeans means_;
  double module_;  // [m]
  Cells cells_;
};

/// The correlation of what is shown with a tag.
double correlation(const View& view, const TagPattern& pattern) {
  double n = 0.0, greys = 0.0, squares = 0.0, papers = 0.0, products = 0.0;
  for (std::size_t k = 0; k < cells; ++k) {
    if (!view.shown[k]) continue;
    const double grey = view.grey[k], paper = pattern[k] ? 1.0 : 0.0;
    n += 1.0;
    greys += grey;
    squares += grey * grey;
    papers += paper;
    products += paper * grey;
  }
  const double spread = (n * squares - greys * greys) * (n * papers - papers * papers);
  return spread > 0.0 ? (n * products - papers * greys) / std::sqrt(spread) : 0.0;
}

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

using Turns = std::array<TagPattern, 4>;

Turns turns_of(const TagPattern& tag) {
  const TagPattern once = turned(tag), twice = turned(once);
  return {tag, once, twice, turned(twice)};
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
  for (double v = part.top - outside; v < part.top + part.height + outside && !stop.stop_requested(); v += step)
    for (double u = part.left - outside; u < part.left + part.width + outside; u += step) {
      if (!covered && std::min({u, v, frame.width - 1.0 - u, frame.height - 1.0 - v}) > inside) {
        u = std::max(u, frame.width - 1.0 - inside - step);  // on to the other side
        continue;
      }
      if (covered && viewer.is_plain({u, v}, edge)) continue;
      const auto spot = spot_at(calibration, {u, v});
      for (int angle = 0; spot && angle < all_angles; ++angle) {
        const auto view = viewer.view(*spot, rotations[static_cast<std::size_t>(angle)]);
        for (std::size_t i = 0; view && i < tags.size(); ++i)
          for (std::size_t turn = 0; turn < 4; ++turn) {
            const double like = correlation(*view, tags[i][turn]);
            if (like < least_of_a_guess) continue;
            Guess& guess = best[{static_cast<long>(i), std::lround(2.0 * u / edge), std::lround(2.0 * v / edge)}];
            if (like > guess.correlation) guess = {{u, v}, quarter * angle / angles, turn, like};
          }
      }
    }
  std::vector<std::pair<std::size_t, Guess>> all;
  all.reserve(best.size());
  for (const auto& [place, guess] : best) all.emplace_back(static_cast<std::size_t>(place[0]), guess);
  return all;
}

/// Moves and turns a guess by smaller and smaller steps to where it is most like the tag.
void improve(Guess& guess, const Calibration& calibration, const Viewer& viewer, double step, const TagPattern& tag) {
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
  if (tags.empty() || edge < modules) return found;
  const std::vector<TagPattern> all = tag_patterns();
  std::vector<Turns> wanted;
  for (const int tag : tags) wanted.push_back(turns_of(all.at(static_cast<std::size_t>(tag))));
  const Viewer viewer(frame, calibration, covered);
  std::vector<double> best(tags.size(), covered ? least_of_a_half : least_correlation);
  for (auto& [i, guess] : guesses_of(frame, calibration, viewer, step, edge, wanted, covered, part, stop)) {
    if (stop.stop_requested()) break;
    const TagPattern& tag = wanted[i][guess.turn];
    improve(guess, calibration, viewer, step, tag);
    const auto spot = spot_at(calibration, guess.pixel);
    const auto view = spot ? viewer.view(*spot, guess.theta) : std::nullopt;
    if (!view || guess.correlation < best[i] || !(covered || view->cut) || !reads_only_as(*view, tag, all)) continue;
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

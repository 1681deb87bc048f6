#include "vision/calibrate/intrinsics.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/estimation/statistics.h"
#include "core/geometry/pose.h"
#include "vision/modules/media_loader.h"

namespace skein::vision {
namespace {

constexpr std::size_t least_corners = 6;  // of a view: four give its pose, the rest say something
constexpr std::size_t least_views = 3;
constexpr double corner_limit = 4.0;  // times the usual residual of a corner of its view
constexpr double view_limit = 3.0;    // times that of the middle view
constexpr double least_limit = 0.3;   // nothing closer than this is an outlier [px]
constexpr int most_rounds = 15;
constexpr double least_tilt = 5.0;  // of the board in one view [deg]
// Between the board's planes in two views. With less, the focal length is wrong by much more than its deviation, which
// knows only of noise and not of the small errors that all corners of equal views share. [deg]
constexpr double least_turn = 8.0;
// A board that is another one than was said, or pictures of several cameras. Of the picture's width; blurred corners in
// large pictures scatter by a thousandth.
constexpr double largest_rms = 0.0025;

std::vector<BoardView*> used(std::vector<BoardView>& views) {
  std::vector<BoardView*> result;
  for (BoardView& view : views)
    if (!view.rejected) result.push_back(&view);
  return result;
}

/// Leaves out what does not fit the rest; false: everything does. Corners first, by the scatter of their own view, so
/// that two bad ones cost themselves and not the view whose pose they spoil; then one view at a time, since a bad one
/// spoils all the others.
bool reject(const std::vector<BoardView*>& views, const std::vector<std::vector<double>>& residuals) {
  constexpr double rms_over_median = 1.2;  // of a distance whose two coordinates scatter normally
  bool any = false;
  std::vector<double> of_views;
  for (std::size_t i = 0; i < views.size(); ++i) {
    BoardView& view = *views[i];
    of_views.push_back(core::median(residuals[i]));
    const double worst = std::max(least_limit, corner_limit * rms_over_median * of_views.back());
    std::vector<BoardCorner> kept;
    for (std::size_t k = 0; k < view.corners.size(); ++k)
      if (residuals[i][k] <= worst) kept.push_back(view.corners[k]);
    if (kept.size() == view.corners.size()) continue;
    any = true;
    view.outliers += static_cast<int>(view.corners.size() - kept.size());
    view.corners = std::move(kept);
    view.rejected = view.corners.size() < least_corners;
  }
  if (any) return true;
  const auto worst = std::max_element(of_views.begin(), of_views.end());
  if (*worst <= std::max(least_limit, view_limit * core::median(of_views))) return false;
  views[static_cast<std::size_t>(worst - of_views.begin())]->rejected = true;
  return true;
}

/// How far a view is from another, by the corners that both have. [px]
double distance(const BoardView& a, const BoardView& b) {
  double moved = 0.0;
  int common = 0;
  for (const BoardCorner& p : a.corners)
    for (const BoardCorner& q : b.corners)
      if (p.id == q.id) {
        moved += std::hypot(p.u - q.u, p.v - q.v);
        ++common;
      }
  return common > 0 ? moved / common : 1e9;
}

}  // namespace

tl::expected<std::vector<BoardCorner>, std::string> find_board(const Frame& frame, const Board& board) {
  const auto module = boards();
  if (!module) return tl::unexpected(module.error());
  std::vector<BoardCorner> corners;
  (*module)->find(frame, board, corners);
  return corners;
}

void Coverage::add(const BoardView& view) {
  for (const BoardCorner& corner : view.corners) {
    const int column = static_cast<int>((corner.u + 0.5) / width * columns);
    const int row = static_cast<int>((corner.v + 0.5) / height * rows);
    if (column >= 0 && column < columns && row >= 0 && row < rows)
      ++corners[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(column)];
  }
}

double Coverage::share() const {
  const auto hit = std::count_if(corners.begin(), corners.end(), [](int n) { return n > 0; });
  return static_cast<double>(hit) / static_cast<double>(corners.size());
}

std::string Coverage::text() const {
  std::string picture;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    picture += corners[i] == 0 ? '.' : corners[i] < 10 ? '-' : '#';
    if ((i + 1) % columns == 0) picture += '\n';
  }
  return picture;
}

std::string uneven_focal_lengths(const Intrinsics& intrinsics) {
  constexpr double share = 0.003, deviations = 4.0;
  const double fx = intrinsics.calibration.fx, fy = intrinsics.calibration.fy, apart = std::abs(fx - fy);
  if (apart <= share * std::min(fx, fy) || apart <= deviations * std::sqrt(2.0) * intrinsics.focal_sigma) return {};
  return fmt::format(
      "fx and fy differ by {:.1f} %, but cameras have square pixels: the board is probably stretched in one direction; "
      "measure ten of its squares in both directions, print it without scaling, and also show it turned by 90 deg",
      100.0 * apart / std::min(fx, fy));
}

std::string equal_tilts(const Intrinsics& intrinsics) {
  constexpr double degree = core::pi / 180.0;
  if (intrinsics.spread >= least_turn * degree) return {};
  return fmt::format(
      "the views do not determine the focal length: the board is tilted in the same way in all of them, to within "
      "{:.1f} deg; "
      "needed: {:g} deg between two of them, better 60: tilt it to different sides",
      intrinsics.spread / degree, least_turn);
}

std::string systematic_residuals(const Intrinsics& intrinsics) {
  constexpr double least = 0.15, times = 1.2;
  const double systematic =
      std::sqrt(std::max(0.0, intrinsics.rms * intrinsics.rms - intrinsics.scatter * intrinsics.scatter));
  if (systematic <= least || systematic <= times * intrinsics.scatter) return {};
  return fmt::format(
      "corners beside one another are off in the same direction, by {:.2f} px, where each alone scatters by {:.2f} px: "
      "no camera with this board gives these views, and the deviations above are too small. Either the board is not "
      "flat, or it is stretched (measure ten of its squares in both directions), or focus or zoom changed between the "
      "views, or the lens is a fisheye",
      systematic, intrinsics.scatter);
}

tl::expected<Intrinsics, std::string> solve_intrinsics(std::vector<BoardView> views, int width, int height) {
  const auto module = boards();
  if (!module) return tl::unexpected(module.error());
  Intrinsics result;
  for (BoardView& view : views) view.rejected = view.corners.size() < least_corners;
  for (int round = 0;; ++round) {
    const std::vector<BoardView*> in = used(views);
    if (in.size() < least_views)
      return tl::unexpected(fmt::format(
          "{}, allowed: {} or more, each with at least {} corners, from different sides{}",
          views.size() < least_views
              ? fmt::format("found the board in {} view{}", views.size(), views.size() == 1 ? "" : "s")
              : fmt::format("only {} of {} views of the board can be used, since the others show too few corners or "
                            "do not fit",
                            in.size(), views.size()),
          least_views, least_corners,
          views.empty() ? ". Is the board described as it was printed (kind, columns x rows, bits of its markers), not "
                          "mirrored, and in focus?"
                        : ""));
    std::vector<std::vector<double>> residuals;
    if (std::string problem = (*module)->calibrate(in, width, height, result, residuals); !problem.empty())
      return tl::unexpected(problem);
    double squares = 0.0;
    std::size_t corners = 0;
    for (std::size_t i = 0; i < in.size(); ++i) {
      double of_view = 0.0;
      for (const double r : residuals[i]) of_view += r * r;
      in[i]->rms = std::sqrt(of_view / static_cast<double>(residuals[i].size()));
      squares += of_view;
      corners += residuals[i].size();
    }
    result.rms = std::sqrt(squares / static_cast<double>(corners));
    if (round == most_rounds || !reject(in, residuals)) break;
  }
  if (const double allowed = std::max(1.5, largest_rms * width); result.rms > allowed)
    return tl::unexpected(
        fmt::format("no single camera model fits these views: the corners are {:.3g} px (rms) from where they should "
                    "be; allowed: {:.3g} px. Is the board described as it was printed (kind, columns x rows)?",
                    result.rms, allowed));
  if (!std::isfinite(result.rms + result.focal_sigma + result.centre_sigma) || !(result.calibration.fx > 0.0))
    return tl::unexpected(
        std::string("the views do not determine the camera: show the board from other sides, tilted"));
  // Of a board that is parallel to the picture, a camera twice as far away with twice the focal length sees the same.
  if (constexpr double degree = core::pi / 180.0; result.tilt < least_tilt * degree)
    return tl::unexpected(
        fmt::format("the views do not determine the focal length: in none is the board tilted by more than {:.1f} deg; "
                    "needed: {:g} deg in some, better 30",
                    result.tilt / degree, least_tilt));
  result.views = std::move(views);
  return result;
}

bool is_new_view(const std::vector<BoardView>& views, const BoardView& view, double least_px) {
  return std::none_of(views.begin(), views.end(),
                      [&](const BoardView& known) { return distance(known, view) < least_px; });
}

std::vector<BoardView> most_different(std::vector<BoardView> views, std::size_t count) {
  if (views.size() <= count) return views;
  std::vector<BoardView> chosen{views.front()};
  std::vector<double> nearest(views.size(), 1e9);  // of the chosen ones
  while (chosen.size() < count) {
    for (std::size_t i = 0; i < views.size(); ++i) nearest[i] = std::min(nearest[i], distance(views[i], chosen.back()));
    chosen.push_back(
        views[static_cast<std::size_t>(std::max_element(nearest.begin(), nearest.end()) - nearest.begin())]);
  }
  return chosen;
}

}  // namespace skein::vision

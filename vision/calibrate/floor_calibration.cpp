#include "vision/calibrate/floor_calibration.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "vision/detector/detector.h"
#include "vision/diagnosis/diagnosis.h"
#include "vision/frames/frame.h"
#include "vision/modules/media_loader.h"
#include "vision/tags/detection.h"
#include "vision/tags/tag_plane.h"

namespace skein::vision {
namespace {

constexpr std::size_t least_marks = 4;
constexpr std::size_t least_to_suspect = 6;
constexpr double farthest = 100.0;                         // of a camera, along each axis [m]
constexpr double smallest_tag = 0.005, largest_tag = 2.0;  // that is printed [m]

/// Where the picture shows a tag's middle: its diagonals' crossing, which perspective leaves alone (the corners' mean
/// is not it).
Eigen::Vector2d middle(const std::vector<Eigen::Vector2d>& c) {
  const auto line = [](const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
    return Eigen::Vector3d(a.x(), a.y(), 1.0).cross(Eigen::Vector3d(b.x(), b.y(), 1.0)).eval();
  };
  const Eigen::Vector3d crossing = line(c[0], c[2]).cross(line(c[1], c[3]));
  return crossing.head<2>() / crossing.z();
}

std::vector<FloorMark> seen_ones(const std::vector<FloorMark>& marks) {
  std::vector<FloorMark> seen;
  std::copy_if(marks.begin(), marks.end(), std::back_inserter(seen), [](const FloorMark& m) { return m.seen; });
  return seen;
}

/// The smaller extent of the marks over the larger: 0 where all are on one line.
double spread(const std::vector<FloorMark>& marks) {
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const FloorMark& m : marks) mean += Eigen::Vector2d(m.x, m.y) / static_cast<double>(marks.size());
  Eigen::Matrix2d moment = Eigen::Matrix2d::Zero();
  for (const FloorMark& m : marks) {
    const Eigen::Vector2d d = Eigen::Vector2d(m.x, m.y) - mean;
    moment += d * d.transpose();
  }
  const double half = 0.5 * moment.trace();
  const double root = std::sqrt(std::max(0.0, half * half - moment.determinant()));
  return half + root > 0.0 ? std::sqrt(std::max(0.0, half - root) / (half + root)) : 0.0;
}

}  // namespace

tl::expected<FloorSight, std::string> look_at_floor(FrameSource& source, const Calibration& calibration, int frames,
                                                    const std::function<bool(int)>& keep_going) {
  struct Sum {
    std::array<Eigen::Vector2d, 4> corners{Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero(),
                                           Eigen::Vector2d::Zero()};
    int count = 0;
  };
  std::map<int, Sum> sums;
  FloorSight sight;
  TagDetector detector;
  Frame frame;
  while (sight.frames < frames) {
    const auto more = source.read(frame);
    if (!more) return tl::unexpected(more.error());
    if (!*more) break;
    if (frame.width != calibration.width || frame.height != calibration.height)
      return tl::unexpected(fmt::format("frame {} is {}x{} px, but the calibration holds for {}x{}", frame.source,
                                        frame.width, frame.height, calibration.width, calibration.height));
    const std::vector<Detection>& found = detector.detect(frame);
    for (std::size_t i = 1; i < found.size(); ++i)
      if (found[i].tag == found[i - 1].tag && (sight.doubled.empty() || sight.doubled.back() != found[i].tag))
        sight.doubled.push_back(found[i].tag);
    for (const Detection& detection : found) {
      Sum& sum = sums[detection.tag];
      for (std::size_t k = 0; k < 4; ++k)
        sum.corners[k] += Eigen::Vector2d(detection.corners[k][0], detection.corners[k][1]);
      ++sum.count;
    }
    ++sight.frames;
    if (!sight.doubled.empty() || (keep_going && !keep_going(sight.frames))) break;
  }
  if (sums.empty() && sight.frames > 0) sight.why_no_tag = why_no_tag(frame);
  for (const auto& [tag, sum] : sums) {
    if (std::find(sight.doubled.begin(), sight.doubled.end(), tag) != sight.doubled.end()) continue;
    if (2 * sum.count < sight.frames) {  // a flicker of the floor's texture
      sight.seldom.push_back({tag, sum.count});
      continue;
    }
    sight.ids.push_back(tag);
    auto& corners = sight.corners.emplace_back();
    for (const Eigen::Vector2d& corner : sum.corners) corners.emplace_back(corner / sum.count);
  }
  sight.last = std::move(frame);
  return sight;
}

void enter(const FloorSight& sight, std::vector<FloorMark>& marks) {
  for (FloorMark& mark : marks) {
    const auto found = std::find(sight.ids.begin(), sight.ids.end(), mark.tag);
    if (mark.tag < 0 || found == sight.ids.end()) continue;
    const Eigen::Vector2d at = middle(sight.corners[static_cast<std::size_t>(found - sight.ids.begin())]);
    mark.u = at.x();
    mark.v = at.y();
    mark.seen = true;
  }
}

tl::expected<FloorCheck, std::string> check_floor(const Calibration& calibration, const std::vector<FloorMark>& marks,
                                                  const FloorMark* left_out) {
  if (!calibration.world_from_camera) return tl::unexpected(std::string("the calibration has no world frame"));
  FloorCheck check;
  double squares = 0.0;
  for (const FloorMark& mark : marks) {
    if (!mark.seen) continue;
    const auto at = world_from_pixel(calibration, {mark.u, mark.v}, mark.z);
    if (!at) return tl::unexpected(fmt::format("{}: its pixel does not show the floor", mark.name));
    const FloorResidual residual{&mark, at->x() - mark.x, at->y() - mark.y, &mark == left_out};
    check.residuals.push_back(residual);
    if (residual.left_out) continue;
    const double off = std::hypot(residual.dx, residual.dy);
    squares += off * off;
    check.worst = std::max(check.worst, off);
    ++check.marks;
  }
  if (check.marks == 0) return tl::unexpected(std::string("none of the marks is seen"));
  check.rms = std::sqrt(squares / static_cast<double>(check.marks));
  return check;
}

tl::expected<Calibration, std::string> solve_floor(const Calibration& intrinsics, const std::vector<FloorMark>& marks) {
  const std::vector<FloorMark> seen = seen_ones(marks);
  if (seen.size() < least_marks)
    return tl::unexpected(
        fmt::format("{} of {} marks are seen; needed: {} or more", seen.size(), marks.size(), least_marks));
  if (spread(seen) < 0.05)
    return tl::unexpected(std::string("the visible marks lie on one line; spread them over the arena"));
  const auto module = boards();
  if (!module) return tl::unexpected(module.error());
  std::vector<Landmark> landmarks;
  landmarks.reserve(seen.size());
  for (const FloorMark& mark : seen) landmarks.push_back({mark.x, mark.y, mark.z, mark.u, mark.v});
  Calibration result = intrinsics;
  if (std::string problem = (*module)->locate(landmarks, result); !problem.empty()) return tl::unexpected(problem);
  if (!(result.world_from_camera->position.z() > 0.0))
    return tl::unexpected(
        std::string("the camera would be under the floor: are x and y of the marks in a frame whose z "
                    "points up (x right, y up as seen from above)?"));
  const Eigen::Vector3d& at = result.world_from_camera->position;
  if (!(at.cwiseAbs().maxCoeff() <= farthest))
    return tl::unexpected(fmt::format(
        "the camera would hang at ({:.0f}, {:.0f}, {:.0f}) m; allowed: {:.0f} m and less: are the places of "
        "the marks in m?",
        at.x(), at.y(), at.z(), farthest));
  return result;
}

const FloorMark* suspect(const Calibration& intrinsics, const std::vector<FloorMark>& marks) {
  const auto rms_of = [&](const std::vector<FloorMark>& some) {
    const auto solved = solve_floor(intrinsics, some);
    if (!solved) return 1e9;
    const auto check = check_floor(*solved, some);
    return check ? check->rms : 1e9;
  };
  if (seen_ones(marks).size() < least_to_suspect) return nullptr;
  const double with_all = rms_of(marks);
  const FloorMark* worst = nullptr;
  double least = with_all / 3.0;
  for (std::size_t i = 0; i < marks.size(); ++i) {
    if (!marks[i].seen) continue;
    std::vector<FloorMark> others = marks;
    others[i].seen = false;
    const double without = rms_of(others);
    if (without >= least) continue;
    least = without;
    worst = &marks[i];
  }
  return worst;
}

double single_error(const FloorCheck& check) {
  constexpr double taken_up = 3.0;  // marks of two coordinates each that a pose of six could meet without a residual
  const auto marks = static_cast<double>(check.marks);
  return marks > taken_up ? check.worst * marks / (marks - taken_up) : std::numeric_limits<double>::infinity();
}

namespace {

constexpr double most_off = 10e-3;  // of a mark that is used, as far as can be known [m]

/// "; with the places of tag 20 and tag 21 exchanged they agree to 0.2 mm: are these two swapped?", or nothing.
std::string two_swapped(const Calibration& intrinsics, const std::vector<FloorMark>& marks) {
  constexpr std::size_t most_marks = 30;  // 435 pairs
  std::vector<FloorMark> tried = seen_ones(marks);
  std::string said;
  double least = most_off;
  if (tried.size() > most_marks) return said;
  const auto exchange = [](FloorMark& a, FloorMark& b) {
    std::swap(a.x, b.x);
    std::swap(a.y, b.y);
    std::swap(a.z, b.z);
  };
  for (std::size_t i = 0; i < tried.size(); ++i)
    for (std::size_t j = i + 1; j < tried.size(); ++j) {
      exchange(tried[i], tried[j]);
      const auto solved = solve_floor(intrinsics, tried);
      const auto check = solved ? check_floor(*solved, tried) : tl::expected<FloorCheck, std::string>{};
      if (solved && check && single_error(*check) < least) {
        least = single_error(*check);
        said = fmt::format("; with the places of {} and {} exchanged they agree to {:.1f} mm: are these two swapped?",
                           tried[i].name, tried[j].name, 1e3 * check->worst);
      }
      exchange(tried[i], tried[j]);
    }
  return said;
}

}  // namespace

tl::expected<TrustedFloor, std::string> solve_trusted_floor(const Calibration& intrinsics,
                                                            const std::vector<FloorMark>& marks) {
  constexpr double clearly_off = 5e-3;  // [m]
  TrustedFloor floor;
  std::vector<FloorMark> used = marks;
  if (const FloorMark* odd = suspect(intrinsics, marks)) {
    used[static_cast<std::size_t>(odd - marks.data())].seen = false;
    const auto without = solve_floor(intrinsics, used);
    const auto check = without ? check_floor(*without, {*odd}) : tl::expected<FloorCheck, std::string>{};
    if (without && check && check->worst > clearly_off) {
      floor.left_out = odd;
      floor.off = check->worst;
    } else {
      used = marks;
    }
  }
  const auto solved = solve_floor(intrinsics, used);
  if (!solved) return tl::unexpected(solved.error() + two_swapped(intrinsics, marks));
  floor.calibration = *solved;
  const auto check = check_floor(*solved, used);
  if (!check) return tl::unexpected(check.error());
  if (const double off = single_error(*check); off > most_off)
    return tl::unexpected(
        fmt::format("the marks disagree by up to {:.0f} mm, as if one of the {} were off by {:.0f} mm; allowed: {:.0f} "
                    "mm: check their places, and the camera's focus{}",
                    1e3 * check->worst, check->marks, 1e3 * off, 1e3 * most_off, two_swapped(intrinsics, marks)));
  return floor;
}

namespace {

/// The edge of a mark, as the picture shows it. [m]
std::optional<double> size_of(const FloorMark& mark, const FloorSight& sight, const Calibration& floor) {
  const auto found = std::find(sight.ids.begin(), sight.ids.end(), mark.tag);
  if (mark.tag < 0 || found == sight.ids.end()) return {};
  Corners corners{};
  for (std::size_t k = 0; k < corners.size(); ++k) {
    const Eigen::Vector2d& corner = sight.corners[static_cast<std::size_t>(found - sight.ids.begin())][k];
    corners[k] = {corner.x(), corner.y()};
  }
  Calibration at_mark = floor;
  at_mark.tag_height = mark.z;
  const auto square = place_on_plane(at_mark, corners);
  return square ? std::optional(square->edge) : std::nullopt;
}

}  // namespace

std::string doubled_tags(const FloorSight& sight) {
  if (sight.doubled.empty()) return {};
  const bool one = sight.doubled.size() == 1;
  return fmt::format("tag{} {} {} in frame {} twice; allowed: once", one ? "" : "s", fmt::join(sight.doubled, ", "),
                     one ? "is" : "are", sight.last.source);
}

std::vector<std::string> why_not_seen(const FloorSight& sight, const std::vector<FloorMark>& marks,
                                      const Calibration& floor) {
  if (!sight.why_no_tag.empty()) return {sight.why_no_tag};
  std::vector<std::string> sentences;
  std::vector<MissingTag> missing;
  std::vector<double> sizes;
  for (const FloorMark& mark : marks) {
    if (const auto size = size_of(mark, sight, floor)) sizes.push_back(*size);
    if (mark.seen) continue;
    const auto seldom = std::find_if(sight.seldom.begin(), sight.seldom.end(),
                                     [&](const FloorSight::Seldom& one) { return one.tag == mark.tag; });
    if (seldom != sight.seldom.end()) {
      sentences.push_back(fmt::format(
          "mark {} is seen in {} of {} frames only, and half are needed: keep the light steady and the floor clear",
          mark.tag, seldom->frames, sight.frames));
      continue;
    }
    missing.push_back({.tag = mark.tag, .mark = mark});
    missing.back().mark->size = 0.0;  // no size is wrong here
  }
  Calibration of_marks = floor;
  if (!sizes.empty()) {
    const auto usual = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
    std::nth_element(sizes.begin(), usual, sizes.end());
    of_marks.tag_size = *usual;
  }
  if (sight.frames == 0 || missing.empty()) return sentences;
  for (std::string& one : mark_sentences(diagnose(sight.last, of_marks, missing), of_marks))
    sentences.push_back(std::move(one));
  return sentences;
}

std::vector<FloorMark> kept_marks(const TrustedFloor& floor, const std::vector<FloorMark>& marks,
                                  const FloorSight& sight) {
  std::vector<FloorMark> kept;
  for (const FloorMark& mark : marks) {
    if (&mark == floor.left_out) continue;
    FloorMark& mine = kept.emplace_back(mark);
    if (const auto size = size_of(mark, sight, floor.calibration)) mine.size = *size;
  }
  return kept;
}

std::string wrong_mark_size(const std::vector<FloorMark>& kept) {
  for (const FloorMark& mark : kept)
    if (mark.size > 0.0 && !(mark.size >= smallest_tag && mark.size <= largest_tag))
      return fmt::format(
          "{} on the floor would have an edge of {:.3g} mm; allowed: {:.0f} to {:.0f} mm: are the places of the marks "
          "in m?",
          mark.name, 1e3 * mark.size, 1e3 * smallest_tag, 1e3 * largest_tag);
  return {};
}

std::optional<PoseShift> pose_shift(const Calibration& before, const Calibration& after) {
  if (!before.world_from_camera || after.marks.empty()) return {};
  Eigen::Vector2d low(after.marks.front().x, after.marks.front().y), high = low;
  for (const FloorMark& mark : after.marks) {
    low = low.cwiseMin(Eigen::Vector2d(mark.x, mark.y));
    high = high.cwiseMax(Eigen::Vector2d(mark.x, mark.y));
  }
  PoseShift shift;
  const auto at = [&](double right, double up, PoseShift::Place& place) {
    place.x = low.x() + right * (high.x() - low.x());
    place.y = low.y() + up * (high.y() - low.y());
    const auto pixel = pixel_from_world(before, {place.x, place.y, before.tag_height});
    const auto moved = pixel ? world_from_pixel(after, *pixel, after.tag_height) : std::nullopt;
    if (!moved) return false;
    place.dx = moved->x() - place.x;
    place.dy = moved->y() - place.y;
    return true;
  };
  shift.places = {{{"centre"}, {"bottom left"}, {"bottom right"}, {"top left"}, {"top right"}}};
  bool all = at(0.5, 0.5, shift.places[0]);
  for (std::size_t k = 0; k < 4; ++k) all = at(k % 2 == 0 ? 0.0 : 1.0, k < 2 ? 0.0 : 1.0, shift.places[k + 1]) && all;
  constexpr int steps = 8;
  double squares = 0.0;
  for (int i = 0; i <= steps; ++i)
    for (int j = 0; j <= steps; ++j) {
      PoseShift::Place place;
      all = at(static_cast<double>(i) / steps, static_cast<double>(j) / steps, place) && all;
      squares += place.dx * place.dx + place.dy * place.dy;
    }
  if (!all) return {};
  shift.rms = std::sqrt(squares / ((steps + 1) * (steps + 1)));
  return shift;
}

std::string wrong_tag_height(const Calibration& calibration) {
  const double camera = calibration.world_from_camera->position.z();
  if (calibration.tag_height < camera) return {};
  return fmt::format("tags at a height of {:.0f} mm; allowed: below the camera, which is at {:.0f} mm",
                     1e3 * calibration.tag_height, 1e3 * camera);
}

std::optional<double> tag_height_of(const Calibration& calibration, const std::vector<Eigen::Vector2d>& corners) {
  if (!calibration.world_from_camera || corners.size() != 4) return {};
  Corners seen{};
  for (std::size_t k = 0; k < 4; ++k) seen[k] = {corners[k].x(), corners[k].y()};
  // The higher the plane, the smaller the tag that looks this large.
  const auto edge_at = [&](double height) {
    Calibration c = calibration;
    c.tag_height = height;
    const auto place = place_on_plane(c, seen);
    return place ? place->edge : 0.0;
  };
  double low = -0.5 * calibration.tag_size;
  double high = 0.9 * calibration.world_from_camera->position.z();
  if (edge_at(low) < calibration.tag_size || edge_at(high) > calibration.tag_size) return {};
  for (int i = 0; i < 60; ++i) {
    const double half = 0.5 * (low + high);
    (edge_at(half) > calibration.tag_size ? low : high) = half;
  }
  return 0.5 * (low + high);
}

}  // namespace skein::vision

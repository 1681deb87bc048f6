#include "vision/diagnosis/diagnosis.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <string_view>

#include "vision/detector/family_reader.h"
#include "vision/diagnosis/cut_tags.h"
#include "vision/diagnosis/edge_widths.h"
#include "vision/diagnosis/light_limits.h"
#include "vision/diagnosis/module_grey.h"
#include "vision/diagnosis/placed_tag.h"
#include "vision/modules/media_loader.h"
#include "vision/tags/detection.h"
#include "vision/tags/tag_plane.h"

namespace skein::vision {
namespace {

using detail::blur_sentence;
using detail::blurred_edge;
using detail::dark_grey;
using detail::faint;
using detail::least_contrast;
using detail::saturated_share;

// The tracker's own tolerance for shapes (TrackerOptions::shape_tolerance).
constexpr double size_tolerance = 0.06;

// A tag that looks so much larger than the others is above them. AprilTag's corners tell edges of 25 px to a hundredth.
constexpr double lift_tolerance = 0.012;

// Of a square's edge: how far its corners may be from a square's on the plane of the tags.
constexpr double misfit_tolerance = 0.03;

// What looks so much like the tag between the corners that were found (0.98 and more in focus) is all of it. Where a
// part of its edge is covered, the edge of the cover is taken for the tag's, and its bits are elsewhere: 0.90 at most.
constexpr double whole_likeness = 0.95;

// Of a whole tag that the tracker does not take: from here on, shape or size is the reason. AprilTag's corners make
// less.
constexpr double slight_misfit = 0.012, slight_size = 0.03;

double edge_px_of(const Corners& corners) {
  double sum = 0.0;
  for (std::size_t i = 0; i < 4; ++i) {
    const auto& a = corners[i];
    const auto& b = corners[(i + 1) % 4];
    sum += std::hypot(a[0] - b[0], a[1] - b[1]);
  }
  return sum / 4.0;
}

/// The part of a frame around a tag of this edge [px].
Window crop_around(const Eigen::Vector2d& middle, double edge) {
  const int size = static_cast<int>(std::ceil(2.0 * edge));  // a turned tag with its border spans 1.8 edges
  return {static_cast<int>(middle.x() - edge), static_cast<int>(middle.y() - edge), size, size};
}

/// As far as it lies in the frame; width 0: nowhere.
Window within(const Frame& frame, const Window& window) {
  const int left = std::max(window.left, 0), top = std::max(window.top, 0);
  const int right = std::min(window.left + window.width, frame.width);
  const int bottom = std::min(window.top + window.height, frame.height);
  return right > left && bottom > top ? Window{left, top, right - left, bottom - top} : Window{};
}

/// The white border of a tag reaches over the border of the frame.
bool cut_by_border(const Frame& frame, const Corners& corners) {
  constexpr double paper = 10.0 / 8.0;
  const Eigen::Vector2d middle = middle_of(corners);
  return std::any_of(corners.begin(), corners.end(), [&](const auto& corner) {
    const Eigen::Vector2d at = middle + paper * (Eigen::Vector2d(corner[0], corner[1]) - middle);
    return at.x() < 0.0 || at.y() < 0.0 || at.x() > frame.width - 1.0 || at.y() > frame.height - 1.0;
  });
}

/// A tag at this pose, or its border, is at most half a tag away from the border of the frame.
bool near_border(const Frame& frame, const Calibration& calibration, const core::Pose& pose) {
  const auto at = pixel_from_world(calibration, {pose.x, pose.y, calibration.tag_height});
  const double reach = 1.5 * tag_edge_px(calibration);
  return !at || at->x() < reach || at->y() < reach || at->x() > frame.width - 1.0 - reach ||
         at->y() > frame.height - 1.0 - reach;
}

/// The calibration with the plane and the size that a missing tag has.
Calibration plane_of(const MissingTag& tag, const Calibration& calibration) {
  Calibration plane = calibration;
  if (!tag.mark) return plane;
  plane.tag_height = tag.mark->z;
  if (tag.mark->size > 0.0) plane.tag_size = tag.mark->size;
  return plane;
}

/// How far a pixel is from the border of a picture; negative: outside of it. [px]
double depth_in_picture(const Eigen::Vector2d& at, int width, int height) {
  return std::min({at.x(), at.y(), width - 1.0 - at.x(), height - 1.0 - at.y()});
}

/// Where a detection is and how it looks, into the answer.
void describe(const Detection& seen, const Calibration& calibration, TagDiagnosis& answer) {
  answer.pixels.push_back(middle_of(seen.corners));
  answer.crops.push_back(crop_around(middle_of(seen.corners), edge_px_of(seen.corners)));
  answer.edge_px = edge_px_of(seen.corners);
  answer.contrast = 2.0 * seen.decision_margin;
  if (const auto place = place_on_plane(calibration, seen.corners)) {
    answer.places.emplace_back(place->pose.x, place->pose.y);
    answer.size = place->edge;
  }
}

/// Of a tag that AprilTag decodes in a single place.
NotSeen reason_of(const Detection& seen, const Frame& frame, const Calibration& calibration,
                  const TagDiagnosis& answer) {
  if (cut_by_border(frame, seen.corners)) return NotSeen::at_border;
  const auto place = place_on_plane(calibration, seen.corners);
  const bool of_this_size = !answer.mark || answer.mark->size > 0.0;
  if (calibration.world_from_camera && (!place || place->misfit > misfit_tolerance * place->edge))
    return seen.likeness < whole_likeness && answer.contrast >= least_contrast ? NotSeen::covered : NotSeen::tilted;
  if (place && of_this_size && std::abs(place->edge / calibration.tag_size - 1.0) > size_tolerance)
    return NotSeen::wrong_size;
  return answer.contrast < least_contrast ? NotSeen::in_shadow : NotSeen::covered;
}

/// Of a tag that would be called covered although all of it is there, in focus.
NotSeen reason_of_whole(const Detection& seen, const Calibration& calibration, const TagDiagnosis& answer) {
  const auto place = place_on_plane(calibration, seen.corners);
  if (!place || seen.likeness < whole_likeness) return NotSeen::covered;
  if (place->misfit > slight_misfit * place->edge) return NotSeen::tilted;
  if (answer.mark) return NotSeen::covered;
  return std::abs(place->edge / calibration.tag_size - 1.0) > slight_size ? NotSeen::wrong_size : NotSeen::covered;
}

/// The middle of the edges, as a part of tag_size, of the tags that are not asked about; none where there are no two.
std::optional<double> usual_edge(const std::vector<Detection>& found, std::span<const MissingTag> missing,
                                 const Calibration& calibration) {
  std::vector<double> edges;
  for (const Detection& seen : found) {
    const bool asked =
        std::any_of(missing.begin(), missing.end(), [&](const MissingTag& tag) { return tag.tag == seen.tag; });
    const auto place = place_on_plane(calibration, seen.corners);
    if (!asked && place && std::abs(place->edge / calibration.tag_size - 1.0) < size_tolerance)
      edges.push_back(place->edge / calibration.tag_size);
  }
  if (edges.size() < 2) return {};
  const auto middle = edges.begin() + static_cast<std::ptrdiff_t>(edges.size() / 2);
  std::nth_element(edges.begin(), middle, edges.end());
  return *middle;
}

/// OpenCV's markers, which are read where there is no AprilTag.
struct ArucoFamily {
  TagFamily family;
  int bits;
  int last_sure;  // this number and lower ones are believed of a single marker; others may be texture
};
constexpr std::array aruco_families{ArucoFamily{{"ArUco 4x4"}, 4, 49}, ArucoFamily{{"ArUco 5x5"}, 5, 999},
                                    ArucoFamily{{"ArUco 6x6"}, 6, 999}, ArucoFamily{{"ArUco 7x7"}, 7, 999}};

/// Markers of ArUco, of the dictionary of which there are most. It loads OpenCV: not where robots drive.
std::vector<FamilyTag> aruco_markers(const Frame& frame) {
  std::vector<FamilyTag> most;
  const auto module = boards();
  if (!module) return most;
  for (const ArucoFamily& aruco : aruco_families) {
    std::vector<Detection> found;
    (*module)->detect_aruco(frame, aruco.bits, found);
    if (found.size() <= most.size() || (found.size() == 1 && found.front().tag > aruco.last_sure)) continue;
    most.clear();
    for (const Detection& seen : found) most.push_back({&aruco.family, seen});
  }
  return most;
}

/// No white border is around a tag: there it is darker than between its ink and its paper.
bool without_border(const Frame& frame, const Corners& corners) {
  constexpr int modules = 8;
  constexpr double paper_share = 0.7;  // of the way from ink to paper; a border in a soft picture reaches 0.85
  const auto grey = [&](double column, double row) { return detail::module_grey(frame, corners, column, row); };
  std::vector<double> inside, around;
  for (int i = 0; i < modules; ++i) {
    const double along = i + 0.5;
    for (int j = 0; j < modules; ++j) inside.push_back(grey(along, j + 0.5));
    for (const double beyond : {-0.5, modules + 0.5}) {
      around.push_back(grey(along, beyond));
      around.push_back(grey(beyond, along));
    }
  }
  std::sort(inside.begin(), inside.end());
  std::sort(around.begin(), around.end());
  const std::size_t tenth = inside.size() / 10;
  const double ink = inside[tenth], paper = inside[inside.size() - 1 - tenth];
  return around[around.size() / 2] < ink + paper_share * (paper - ink);
}

/// What is found where a mark should be.
bool in_its_place(const TagDiagnosis& mark, const Detection& seen) {
  return mark.mark_at && (middle_of(seen.corners) - *mark.mark_at).norm() < mark.edge_px;
}

/// Tags that are not found, but would be in another family, in a mirror or in negative. In the place of a mark they may
/// have another number.
void look_for_other_families(const std::vector<FamilyTag>& tags, std::span<const Calibration> planes,
                             std::vector<TagDiagnosis>& answers) {
  const auto take = [&](const FamilyTag& tag, const auto& is_it) {
    for (std::size_t i = 0; i < answers.size(); ++i) {
      TagDiagnosis& answer = answers[i];
      if (answer.why != NotSeen::not_found || !is_it(answer)) continue;
      describe(tag.seen, planes[i], answer);
      answer.why = tag.family->name == in_mirror ? NotSeen::mirrored : NotSeen::other_family;
      answer.family = tag.family->name;
      if (tag.seen.tag != answer.tag) answer.other = tag.seen.tag;
      return;
    }
  };
  for (const FamilyTag& tag : tags)
    take(tag, [&](const TagDiagnosis& answer) {
      const bool same = tag.seen.tag == answer.tag;
      return tag.family->name != in_36h11 && in_its_place(answer, tag.seen) && (same || !tag.family->has_ghosts);
    });
  for (const FamilyTag& tag : tags)
    take(tag, [&](const TagDiagnosis& answer) {
      return tag.seen.tag == answer.tag && !(answer.mark_at && tag.family->has_ghosts);
    });
}

/// Tags that are not found, because the border of the picture cuts them.
void look_at_border(const Frame& frame, const Calibration& calibration, std::vector<TagDiagnosis>& answers) {
  std::vector<TagDiagnosis*> asked;
  std::vector<int> tags;
  for (TagDiagnosis& answer : answers) {
    if (answer.why != NotSeen::not_found || answer.mark) continue;  // a mark's place tells
    asked.push_back(&answer);
    tags.push_back(answer.tag);
  }
  const auto found = detail::find_cut_tags(frame, calibration, tags);
  for (std::size_t i = 0; i < found.size(); ++i) {
    if (!found[i]) continue;
    TagDiagnosis& answer = *asked[i];
    answer.why = NotSeen::at_border;
    answer.places = {{found[i]->x, found[i]->y}};
    answer.size = calibration.tag_size;
    if (const auto at = pixel_from_world(calibration, {found[i]->x, found[i]->y, calibration.tag_height}))
      answer.crops = {crop_around(*at, answer.edge_px)};
  }
}

struct Light {
  double saturated = 0.0;  // share of the pixels
  int brightest = 0;       // 99 % of the pixels are darker or equal
};

/// The part must lie in the frame.
Light light_of(const Frame& frame, const Window& part) {
  std::array<std::size_t, 256> count{};
  for (int v = part.top; v < part.top + part.height; ++v)
    for (int u = part.left; u < part.left + part.width; ++u) ++count[frame.row(v)[u]];
  Light light;
  std::size_t above = 0;
  const std::size_t pixels = static_cast<std::size_t>(part.width) * static_cast<std::size_t>(part.height);
  const auto hundredth = pixels / 100;
  for (int grey = 255; grey >= 0; --grey) {
    above += count[static_cast<std::size_t>(grey)];
    if (grey == 250) light.saturated = static_cast<double>(above) / static_cast<double>(pixels);
    if (light.brightest == 0 && above > hundredth) light.brightest = grey;
  }
  return light;
}

/// What the place of a mark that nothing decodes as shows.
void look_at_place(const Frame& frame, const std::vector<Detection>& found, TagDiagnosis& mark) {
  constexpr double black_reach = 0.71;      // of its edge: a corner of the black square, however it is turned
  constexpr double saturated_place = 0.75;  // share of the black square; half of a tag in good light is white
  const double edge = mark.edge_px;
  if (!mark.mark_at || depth_in_picture(*mark.mark_at, frame.width, frame.height) < black_reach * edge) {
    mark.why = NotSeen::at_border;
    mark.outside = !mark.mark_at || depth_in_picture(*mark.mark_at, frame.width, frame.height) < -black_reach * edge;
    return;
  }
  const auto there =
      std::find_if(found.begin(), found.end(), [&](const Detection& seen) { return in_its_place(mark, seen); });
  if (there != found.end()) {
    mark.other = there->tag;
    return;
  }
  const int side = static_cast<int>(std::ceil(edge));
  const Eigen::Vector2d corner = *mark.mark_at - Eigen::Vector2d(0.5 * edge, 0.5 * edge);
  const Light light =
      light_of(frame, within(frame, {static_cast<int>(corner.x()), static_cast<int>(corner.y()), side, side}));
  if (light.saturated > saturated_place)
    mark.why = NotSeen::too_bright;
  else if (light.brightest < dark_grey)
    mark.why = NotSeen::in_shadow;
}

/// How wide the clear edges of a frame are, in the middle [px]; none: they are too few to tell.
std::optional<double> usual_edge_width(const Frame& frame) {
  constexpr std::size_t enough = 40;
  std::vector<double> widths;
  detail::edge_widths(frame, {0, 0, frame.width, frame.height}, 0.0, widths);
  if (widths.size() < enough) return {};
  const auto middle = widths.begin() + static_cast<std::ptrdiff_t>(widths.size() / 2);
  std::nth_element(widths.begin(), middle, widths.end());
  return *middle;
}

/// The same of a frame that is blurred.
std::optional<double> blur_of(const Frame& frame) {
  const auto width = usual_edge_width(frame);
  return width && *width >= blurred_edge ? width : std::nullopt;
}

/// The picture is too soft for tags of this edge (0: not known): then the tags that are not found may be there all the
/// same. [px]
bool too_soft(double edge_width, double edge_px) {
  constexpr double soft_edge = 2.7;        // a lens in focus gives 2 to 2.5 [px]
  constexpr double of_a_module = 0.8 / 8;  // AprilTag reads tags of 3 px a module with edges up to this
  return edge_width >= std::min(blurred_edge, std::max(soft_edge, of_a_module * edge_px));
}

/// Says what hides a tag, at a place on the floor, that nothing decodes as.
void look_for_remains(const Frame& frame, const Calibration& plane, const Eigen::Vector2d& place, TagDiagnosis& tag) {
  switch (detail::remains_of_tag(frame, plane, place, tag.tag)) {
    case detail::TagRemains::none:
      break;
    case detail::TagRemains::part:
      tag.why = NotSeen::covered;
      break;
    case detail::TagRemains::reflection:
      tag.why = NotSeen::too_bright;
      tag.partly = true;
      break;
    case detail::TagRemains::shadow:
      tag.why = NotSeen::in_shadow;
      tag.partly = true;
      break;
    case detail::TagRemains::whole:
      tag.why = NotSeen::blurred;
      tag.edge_width = usual_edge_width(frame).value_or(0.0);
      break;
  }
}

/// A cover whose edge goes askew over a tag leaves no half of it free.
bool a_part_is_left(const Frame& frame, const Calibration& calibration, const core::Pose& pose, int tag) {
  using detail::TagRemains;
  const TagRemains remains = detail::remains_of_tag(frame, calibration, {pose.x, pose.y}, tag);
  return remains != TagRemains::none && remains != TagRemains::whole &&
         detail::fits_best(frame, calibration, pose, tag);
}

/// Says of a tag that is not found, but of which a part is at `pose`, what hides the rest.
void look_at_covered(const Frame& frame, const Calibration& calibration, const std::vector<Detection>& found,
                     const core::Pose& pose, TagDiagnosis& answer) {
  const auto at = pixel_from_world(calibration, {pose.x, pose.y, calibration.tag_height});
  const bool of_another = !at || std::any_of(found.begin(), found.end(), [&](const Detection& seen) {
    return (middle_of(seen.corners) - *at).norm() < answer.edge_px;
  });
  if (of_another) return;
  answer.edge_width = 0.0;
  look_for_remains(frame, calibration, {pose.x, pose.y}, answer);
  if (!answer.partly) answer.why = NotSeen::covered;  // AprilTag would have found a whole one
  answer.places = {{pose.x, pose.y}};
  answer.pixels = {*at};
  answer.size = calibration.tag_size;
  answer.crops = {crop_around(*at, answer.edge_px)};
}

/// Tags that are not found where they were last seen, because something covers a part of them, or a lamp's reflection
/// or a shadow lies on it: they are looked for near that place.
void look_near_last_places(const Frame& frame, const Calibration& calibration, std::span<const MissingTag> missing,
                           const std::vector<Detection>& found, std::vector<TagDiagnosis>& answers) {
  constexpr double edges_around = 3.0;
  for (std::size_t i = 0; i < answers.size(); ++i) {
    TagDiagnosis& answer = answers[i];
    if (answer.why != NotSeen::not_found || answer.mark || !missing[i].last) continue;
    const auto at = pixel_from_world(calibration, {missing[i].last->x, missing[i].last->y, calibration.tag_height});
    if (!at) continue;
    const int reach = static_cast<int>(edges_around * answer.edge_px);
    const Window near{static_cast<int>(at->x()) - reach, static_cast<int>(at->y()) - reach, 2 * reach, 2 * reach};
    auto pose = detail::find_covered_tags(frame, calibration, std::array{answer.tag}, near).front();
    // A robot that is not seen stops: where it was, less than a half of its tag tells.
    if (!pose && a_part_is_left(frame, calibration, *missing[i].last, answer.tag)) pose = missing[i].last;
    if (pose) look_at_covered(frame, calibration, found, *pose, answer);
  }
}

/// The first few of the others that may be anywhere.
std::vector<std::size_t> never_seen_of(std::span<const MissingTag> missing, const std::vector<TagDiagnosis>& answers) {
  constexpr std::size_t most = 4;
  std::vector<std::size_t> never_seen;
  for (std::size_t i = 0; i < answers.size() && never_seen.size() < most; ++i) {
    const bool may_be_there = answers[i].why == NotSeen::not_found || answers[i].why == NotSeen::blurred;
    if (may_be_there && answers[i].places.empty() && !answers[i].mark && !missing[i].last) never_seen.push_back(i);
  }
  return never_seen;
}

/// They are looked for everywhere, which takes long.
void look_everywhere(const Frame& frame, const Calibration& calibration, const std::vector<std::size_t>& never_seen,
                     const std::vector<Detection>& found, const std::stop_token& stop,
                     std::vector<TagDiagnosis>& answers) {
  std::vector<int> tags;
  tags.reserve(never_seen.size());
  for (const std::size_t i : never_seen) tags.push_back(answers[i].tag);
  const auto poses = detail::find_covered_tags(frame, calibration, tags, {0, 0, frame.width, frame.height}, stop);
  for (std::size_t k = 0; k < poses.size(); ++k)
    if (poses[k]) look_at_covered(frame, calibration, found, *poses[k], answers[never_seen[k]]);
}

bool any_not_found(const std::vector<TagDiagnosis>& answers) {
  return std::any_of(answers.begin(), answers.end(),
                     [](const TagDiagnosis& answer) { return answer.why == NotSeen::not_found; });
}

}  // namespace

std::vector<TagDiagnosis> diagnose(const Frame& frame, const Calibration& calibration,
                                   std::span<const MissingTag> missing, const DiagnosesSoFar& so_far,
                                   const std::stop_token& stop) {
  std::vector<TagDiagnosis> answers;
  std::vector<Calibration> planes;
  for (const MissingTag& tag : missing) {
    const Calibration& plane = planes.emplace_back(plane_of(tag, calibration));
    TagDiagnosis& answer = answers.emplace_back();
    answer.tag = tag.tag;
    answer.mark = tag.mark;
    if (!tag.mark) continue;
    answer.mark_at = pixel_from_world(calibration, {tag.mark->x, tag.mark->y, tag.mark->z});
    answer.edge_px = tag_edge_px(plane);
  }
  const std::vector<FamilyTag> tags = read_families(frame, faint);
  const std::vector<Detection> found = of_family(tags, in_36h11);
  const std::optional<double> usual = usual_edge(found, missing, calibration);
  for (std::size_t i = 0; i < answers.size(); ++i) {
    TagDiagnosis& answer = answers[i];
    const Detection* one = nullptr;
    int times = 0;
    for (const Detection& seen : found) {
      if (seen.tag != answer.tag) continue;
      one = &seen;
      ++times;
      describe(seen, planes[i], answer);
    }
    if (times == 1) answer.why = reason_of(*one, frame, planes[i], answer);
    if (answer.why == NotSeen::covered && usual && !answer.mark &&
        answer.size > (1.0 + lift_tolerance) * *usual * calibration.tag_size) {
      const double nearer = 1.0 - *usual * calibration.tag_size / answer.size;
      answer.above = nearer * (calibration.world_from_camera->position.z() - calibration.tag_height);
      const bool was_seen = std::any_of(missing.begin(), missing.end(),
                                        [&](const MissingTag& tag) { return tag.tag == answer.tag && tag.last; });
      if (!was_seen) answer.printed = answer.size / *usual;
      answer.why = NotSeen::lifted;
    }
    // Without a border the tag's edge is where its robot's body ends to be dark: its size is not known.
    const bool of_this_tag = answer.why == NotSeen::lifted || answer.why == NotSeen::wrong_size ||
                             answer.why == NotSeen::tilted || answer.why == NotSeen::covered;
    if (times == 1 && of_this_tag && !answer.mark && without_border(frame, one->corners)) {
      answer.why = NotSeen::covered;
      answer.bare = true;
    }
    answer.others_fit = usual.has_value();
    if (times > 1) answer.why = NotSeen::doubled;
  }
  look_for_other_families(tags, planes, answers);
  const auto ever_seen = [](const MissingTag& tag) { return tag.last.has_value(); };
  if (found.empty() && std::none_of(missing.begin(), missing.end(), ever_seen) && any_not_found(answers))
    look_for_other_families(aruco_markers(frame), planes, answers);

  const Light light = light_of(frame, {0, 0, frame.width, frame.height});
  for (std::size_t i = 0; i < answers.size(); ++i) {
    TagDiagnosis& answer = answers[i];
    // Where all of the picture is too dark or too bright, a tag that is not accepted lacks light above all: where white
    // spills over the ink's edges, the tag looks smaller.
    const bool smaller = answer.why == NotSeen::wrong_size && answer.size < calibration.tag_size;
    if ((smaller || answer.why == NotSeen::covered) && light.saturated > saturated_share)
      answer.why = NotSeen::too_bright;
    if (answer.bare) continue;
    // In the dark neither what is missing nor a size is known.
    if ((answer.why == NotSeen::covered || answer.why == NotSeen::lifted) && light.brightest < dark_grey)
      answer.why = NotSeen::in_shadow;
    const std::optional<double>& before = missing[i].lifted_from;
    if (answer.why == NotSeen::covered && before) {
      answer.change = answer.size / calibration.tag_size - (1.0 + *before);
      answer.above = answer.change / (1.0 + answer.change) *
                     (calibration.world_from_camera->position.z() - calibration.tag_height);
      answer.why = NotSeen::lifted;
    }
    if (answer.why == NotSeen::covered) {
      const auto one = std::find_if(found.begin(), found.end(),
                                    [&](const Detection& detection) { return detection.tag == answer.tag; });
      answer.why = reason_of_whole(*one, planes[i], answer);
    }
    if (answer.why != NotSeen::not_found) continue;
    if (!answer.mark) answer.edge_px = tag_edge_px(planes[i]);
    const auto last = answer.mark ? std::nullopt : missing[i].last;
    if (last)
      if (const auto at = pixel_from_world(calibration, {last->x, last->y, calibration.tag_height}))
        answer.crops.push_back(crop_around(*at, answer.edge_px));
    if (answer.mark && calibration.world_from_camera) look_at_place(frame, found, answer);
    if (answer.why != NotSeen::not_found || answer.other) continue;
    if (calibration.world_from_camera && answer.edge_px < least_edge_px)
      answer.why = NotSeen::too_small;
    else if (light.saturated > saturated_share)
      answer.why = NotSeen::too_bright;
    else if (light.brightest < dark_grey)
      answer.why = NotSeen::in_shadow;
    else if (last && near_border(frame, calibration, *last))
      answer.why = NotSeen::at_border;
    else if (answer.mark && calibration.world_from_camera)
      look_for_remains(frame, planes[i], {answer.mark->x, answer.mark->y}, answer);
  }
  look_at_border(frame, calibration, answers);
  look_near_last_places(frame, calibration, missing, found, answers);
  // Tags of few pixels that are blurred beyond recognition leave few edges that show it: what they showed before does.
  constexpr double width = 2.5;  // of an edge, for each of the blur's standard deviations
  for (std::size_t i = 0; i < answers.size(); ++i) {
    if (answers[i].why != NotSeen::not_found || !missing[i].blur) continue;
    answers[i].why = NotSeen::blurred;
    answers[i].edge_width = width * *missing[i].blur;
  }
  const auto edge_width = any_not_found(answers) ? usual_edge_width(frame) : std::nullopt;
  for (TagDiagnosis& answer : answers) {
    if (!edge_width || answer.why != NotSeen::not_found || answer.other) continue;
    // Where a mark should be, nothing of it is left.
    const bool may_be_there = found.empty() && !answer.mark_at && too_soft(*edge_width, answer.edge_px);
    if (*edge_width < blurred_edge && !may_be_there) continue;
    answer.why = NotSeen::blurred;
    answer.edge_width = *edge_width;
  }
  const std::vector<std::size_t> never_seen = never_seen_of(missing, answers);
  if (never_seen.empty()) return answers;
  if (so_far) so_far(answers);
  look_everywhere(frame, calibration, never_seen, found, stop, answers);
  return answers;
}

Frame picture_of(const Frame& frame, const TagDiagnosis& diagnosis) {
  std::vector<Window> parts;
  int width = 0, height = 0;
  for (const Window& crop : diagnosis.crops) {
    const Window part = within(frame, crop);
    if (part.width == 0) continue;
    parts.push_back(part);
    width += part.width;
    height = std::max(height, part.height);
  }
  Frame picture;
  picture.resize(width, height);
  std::fill(picture.grey.begin(), picture.grey.end(), std::uint8_t{255});
  int left = 0;
  for (const Window& part : parts) {
    for (int v = 0; v < part.height; ++v)
      std::copy_n(frame.row(part.top + v) + part.left, part.width, picture.row(v) + left);
    left += part.width;
  }
  return picture;
}

std::string why_no_tag(const Frame& frame) {
  std::vector<FamilyTag> tags = read_families(frame, faint);
  const auto ids_of = [&](std::string_view family) {
    std::vector<int> ids;
    for (const Detection& seen : of_family(tags, family)) ids.push_back(seen.tag);
    std::sort(ids.begin(), ids.end());  // ArUco's are in no order
    return ids;
  };
  const auto changed = [&](std::string_view family, std::string_view how, std::string_view remedy) {
    const std::vector<int> ids = ids_of(family);
    if (ids.empty()) return std::string();
    return fmt::format("tag{} {} {} {}: {}", ids.size() == 1 ? "" : "s", fmt::join(ids, ", "),
                       ids.size() == 1 ? "is" : "are", how, remedy);
  };
  if (std::string said = changed(in_mirror, "mirrored", "switch the camera's mirror off"); !said.empty()) return said;
  if (std::string said = changed(in_negative, "in negative, black and white exchanged",
                                 "switch the camera's negative effect off, or print anew");
      !said.empty())
    return said;
  std::vector<int> ids;
  std::string_view family;
  const auto take_if_most = [&] {
    for (const FamilyTag& tag : tags) {
      if (tag.family->name == in_36h11 || tag.family->name == family) continue;
      std::vector<int> of_this = ids_of(tag.family->name);
      if (of_this.size() <= ids.size() || (tag.family->has_ghosts && of_this.size() < 2)) continue;
      ids = std::move(of_this);
      family = tag.family->name;
    }
  };
  take_if_most();
  if (ids.empty()) {
    tags = aruco_markers(frame);
    take_if_most();
  }
  if (ids.empty()) {
    const auto blur = blur_of(frame);
    return blur ? blur_sentence(std::array{*blur}) : std::string();
  }
  return fmt::format("no tag is of the family 36h11, but {} look{} like {} ({}): print {} anew in 36h11", ids.size(),
                     ids.size() == 1 ? "s" : "", family, fmt::join(ids, ", "), ids.size() == 1 ? "it" : "them");
}

}  // namespace skein::vision

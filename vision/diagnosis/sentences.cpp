// What people read of a diagnosis.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "vision/detector/family_reader.h"
#include "vision/diagnosis/diagnosis.h"
#include "vision/diagnosis/edge_widths.h"
#include "vision/diagnosis/light_limits.h"

namespace skein::vision {

namespace {

using detail::blur_sentence;
using detail::blurred_edge;
using detail::least_contrast;
using detail::range_of;

std::string millimetres(double metres) {
  return fmt::format("{:.3g} mm", 1e3 * metres);
}

std::string place(const Eigen::Vector2d& at) {
  const auto without_sign_of_0 = [](double metres) { return std::abs(metres) < 0.005 ? 0.0 : metres; };
  return fmt::format("({:.2f}, {:.2f}) m", without_sign_of_0(at.x()), without_sign_of_0(at.y()));
}

/// Where a mark was found, or where it should be: "(0.10, 0.30) m, pixel (640, 480)"; empty: nobody knows.
std::string where(const TagDiagnosis& d) {
  const auto pixel = [](const Eigen::Vector2d& at) { return fmt::format("pixel ({:.0f}, {:.0f})", at.x(), at.y()); };
  std::string all;
  for (std::size_t i = 0; i < d.pixels.size(); ++i)
    all += fmt::format("{}{}{}",
                       i == 0                     ? ""
                       : i + 1 == d.pixels.size() ? " and "
                                                  : "; ",
                       d.places.size() == d.pixels.size() ? place(d.places[i]) + ", " : "", pixel(d.pixels[i]));
  if (d.pixels.empty() && d.mark_at) all = fmt::format("{}, {}", place({d.mark->x, d.mark->y}), pixel(*d.mark_at));
  return all;
}

/// What follows "mark 24 is not seen: ".
std::string reason_of_mark(const TagDiagnosis& d, const Calibration& calibration) {
  const FloorMark& mark = *d.mark;
  const std::string there = where(d), at = there.empty() ? "" : " at " + there;
  switch (d.why) {
    case NotSeen::not_found:
      if (d.other)
        return fmt::format(
            "tag {} lies in its place{}: correct number or place in the list of the marks, or move the robot that "
            "stands there",
            *d.other, at);
      if (there.empty()) return "no such tag is in the picture: uncover it, or move it into the picture";
      return fmt::format("nothing can be read{}: uncover it, turn its face up, put it back, or lay a larger one", at);
    case NotSeen::wrong_size:
      return fmt::format(
          "its edge is {}{}, and it was {} when the camera was calibrated: put back the old one, or "
          "calibrate the floor anew",
          millimetres(d.size), at, millimetres(mark.size));
    case NotSeen::lifted:
    case NotSeen::tilted:
      return fmt::format("it does not lie flat at a height of {}{}: lay it flat, or correct its z", millimetres(mark.z),
                         at);
    case NotSeen::doubled:
      return fmt::format(
          "it is there {}{}: take away {}", d.pixels.size() == 2 ? "twice" : "more than once", at,
          d.mark_at ? fmt::format("what does not lie at {}", place({mark.x, mark.y})) : std::string("all but one"));
    case NotSeen::covered:
      return fmt::format("part of it is covered or blurred{}: clear it", at);
    case NotSeen::at_border:
      return fmt::format("{}{} of {}x{}: move it inwards and measure its place again, or turn the camera",
                         d.outside ? "it lies outside the picture" : "the border of the picture cuts it", at,
                         calibration.width, calibration.height);
    case NotSeen::too_small:
      return fmt::format("a tag of {} has {:.1f} px{}, and {:.0f} are needed: lay a larger one",
                         millimetres(mark.size > 0.0 ? mark.size : calibration.tag_size), d.edge_px, at, least_edge_px);
    case NotSeen::too_bright:
      if (d.partly)
        return fmt::format(
            "the reflection of a lamp lies on a part of it{}: move it or the lamp, or print it on matt paper", at);
      return fmt::format("the picture is too bright{}: lower the exposure, or keep the light's reflection away", at);
    case NotSeen::in_shadow:
      if (d.partly)
        return fmt::format(
            "the edge of a shadow, or something thin and dark, lies across it{}: light it evenly, or clear it", at);
      if (d.contrast == 0.0 || d.contrast >= least_contrast)
        return fmt::format("the picture is dark{}: put light on it, or raise the exposure", at);
      return fmt::format(
          "it is in shadow{}, with {:.0f} grey levels between ink and paper, and {:.0f} are needed: put "
          "light on it",
          at, d.contrast, least_contrast);
    case NotSeen::blurred:
      if (d.edge_width >= blurred_edge) return blur_sentence(std::array{d.edge_width});
      if (!d.mark_at)
        return fmt::format(
            "no such tag can be read, and the picture is soft (its edges are {:.1f} px wide): turn the lens's focus, "
            "uncover it, or move it into the picture",
            d.edge_width);
      return fmt::format(
          "all of it is there, but blurred or faint, and {:.1f} px are few for a square of it{}: turn the lens's "
          "focus, "
          "put light on it, or lay a larger one",
          d.edge_px / 8.0, at);
    case NotSeen::mirrored:
      return fmt::format("it is mirrored{}: print it anew, or switch the camera's mirror off", at);
    case NotSeen::other_family:
      if (d.family == in_negative)
        return fmt::format(
            "it is in negative, black and white exchanged{}: print it anew, or switch the camera's "
            "negative effect off",
            at);
      return fmt::format("tag {} of the family {} lies{}: print it anew in 36h11", d.other.value_or(d.tag), d.family,
                         at);
  }
  return {};
}

}  // namespace

std::vector<std::string> mark_sentences(std::span<const TagDiagnosis> marks, const Calibration& calibration) {
  std::vector<std::pair<std::string, std::vector<int>>> reasons;
  for (const TagDiagnosis& mark : marks) {
    std::string reason = reason_of_mark(mark, calibration);
    const auto same = std::find_if(reasons.begin(), reasons.end(), [&](const auto& r) { return r.first == reason; });
    if (same == reasons.end())
      reasons.emplace_back(std::move(reason), std::vector{mark.tag});
    else
      same->second.push_back(mark.tag);
  }
  std::vector<std::string> sentences;
  sentences.reserve(reasons.size());
  for (const auto& [reason, ids] : reasons)
    sentences.push_back(fmt::format("mark{} {} {} not seen: {}", ids.size() == 1 ? "" : "s", fmt::join(ids, ", "),
                                    ids.size() == 1 ? "is" : "are", reason));
  return sentences;
}

std::vector<std::string> soft_sentences(std::span<const SoftPicture> pictures) {
  struct Group {
    std::vector<int> tags;
    bool blurred;  // for any tag, not only for such small ones
    double edge_px;
    std::vector<std::string> names;
    std::vector<double> edge_widths;
  };
  std::vector<Group> groups;
  for (const SoftPicture& picture : pictures) {
    if (picture.tags.empty()) continue;
    const TagDiagnosis& first = picture.tags.front();  // the width is the picture's
    std::vector<int> ids;
    ids.reserve(picture.tags.size());
    for (const TagDiagnosis& tag : picture.tags) ids.push_back(tag.tag);
    const bool blurred = first.edge_width >= blurred_edge;
    auto group = std::find_if(groups.begin(), groups.end(),
                              [&](const Group& g) { return g.blurred == blurred && g.tags == ids; });
    if (group == groups.end()) group = groups.insert(group, {std::move(ids), blurred, first.edge_px, {}, {}});
    group->names.push_back(picture.name);
    group->edge_widths.push_back(first.edge_width);
  }
  std::vector<std::string> sentences;
  sentences.reserve(groups.size());
  for (const Group& g : groups) {
    constexpr std::size_t few = 3;  // are named one by one
    const std::string in = g.names.front().empty() ? std::string()
                           : g.names.size() <= few ? fmt::format("{}: ", fmt::join(g.names, ", "))
                                                   : fmt::format("{} pictures from {} to {}: ", g.names.size(),
                                                                 g.names.front(), g.names.back());
    const bool one = g.tags.size() == 1;
    const std::string none = fmt::format("{} {}", one ? "no tag" : "none of tags", fmt::join(g.tags, ", "));
    sentences.push_back(
        g.blurred ? fmt::format("{}{} is found, and {}", in, none, blur_sentence(g.edge_widths))
                  : fmt::format("{}{} can be read, and {} picture is soft: its edges are {} px wide, the squares of "
                                "such a tag {:.1f} px; if {} there, turn the lens's focus, or use a larger tag",
                                in, none, g.names.size() == 1 ? "the" : "each", range_of(g.edge_widths),
                                g.edge_px / 8.0, one ? "it is" : "they are"));
  }
  return sentences;
}

std::string sentence(const TagDiagnosis& d, const Calibration& calibration) {
  if (d.mark) return mark_sentences(std::array{d}, calibration).front();
  const bool found = d.contrast > 0.0;
  switch (d.why) {
    case NotSeen::not_found:
      return fmt::format("no tag {} is in the picture", d.tag);
    case NotSeen::wrong_size: {
      const double edge = std::round(1e3 * d.size) / 1e3;  // both numbers of the sentence are of the edge that it names
      const double part = edge / calibration.tag_size - 1.0;
      std::string seen =
          fmt::format("tag {} is there, but its edge is {}, {:.0f} % {} than [tags] size {}", d.tag, millimetres(edge),
                      100.0 * std::abs(part), part < 0.0 ? "smaller" : "larger", millimetres(calibration.tag_size));
      if (!d.others_fit) return seen + ": correct the size, or [tags] height if all robots' tags are off by as much";
      return seen + ", which fits the other tags: print it anew" +
             (part < 0.0 ? "" : ", or put its robot down if it is held up");
    }
    case NotSeen::lifted: {
      if (d.change != 0.0)
        return fmt::format(
            "tag {} is there, but looks {:.1f} % {} than a few seconds before: it is about {:.0f} mm {}, or the camera "
            "or its zoom has moved",
            d.tag, 100.0 * std::abs(d.change), d.change > 0.0 ? "larger" : "smaller", 1e3 * std::abs(d.above),
            d.change > 0.0 ? "higher" : "lower");
      const std::string seen =
          fmt::format("tag {} is there, but looks larger than the other tags: it is about {:.0f} mm above them", d.tag,
                      1e3 * d.above);
      if (d.printed == 0.0) return seen + ". Is the robot held up, or its tag on another plate?";
      return fmt::format(
          "{}, or printed about {:.0f} % too large. Is the robot held up, its tag on another plate, or its print "
          "scaled?",
          seen, 100.0 * (d.printed / calibration.tag_size - 1.0));
    }
    case NotSeen::tilted:
      return fmt::format("tag {} is there, but does not lie flat at [tags] height {}", d.tag,
                         millimetres(calibration.tag_height));
    case NotSeen::doubled: {
      std::string where;
      for (std::size_t i = 0; i < d.places.size(); ++i)
        where += (i == 0 ? "" : i + 1 == d.places.size() ? " and " : ", ") + place(d.places[i]);
      return fmt::format("tag {} is there {}, at {}: give one of the robots another tag", d.tag,
                         d.places.size() == 2 ? "twice" : "more than once", where);
    }
    case NotSeen::covered:
      if (d.bare)
        return fmt::format(
            "tag {} is there, but no white border is around it: print it anew, and cut it out along the dashed lines",
            d.tag);
      return fmt::format("tag {} is there, but part of it is covered or blurred", d.tag);
    case NotSeen::at_border:
      return fmt::format("the border of the picture cuts tag {}: move the robot inwards", d.tag);
    case NotSeen::too_small:
      return fmt::format("tag {} cannot be read: a tag of {} has {:.1f} px in this picture, and {:.0f} are needed",
                         d.tag, millimetres(calibration.tag_size), d.edge_px, least_edge_px);
    case NotSeen::too_bright:
      if (d.partly)
        return fmt::format(
            "tag {} is there, but the reflection of a lamp lies on a part of it: move the lamp, or print the tag on "
            "matt paper",
            d.tag);
      return found
                 ? fmt::format("tag {} is there, but much of the picture is too bright: lower the exposure", d.tag)
                 : fmt::format("no tag {} is in the picture, and much of the picture is too bright: lower the exposure",
                               d.tag);
    case NotSeen::in_shadow:
      if (d.partly)
        return fmt::format(
            "tag {} is there, but the edge of a shadow, or something thin and dark, lies across it: light it evenly, "
            "or "
            "clear it",
            d.tag);
      if (!found)
        return fmt::format(
            "no tag {} is in the picture, and the picture is dark: is the lamp on, is the lens free? Or raise the "
            "exposure",
            d.tag);
      return d.contrast < least_contrast
                 ? fmt::format(
                       "tag {} is there, but in shadow: {:.0f} grey levels between ink and paper, "
                       "and {:.0f} are needed",
                       d.tag, d.contrast, least_contrast)
                 : fmt::format("tag {} is there, but the picture is dark: raise the exposure", d.tag);
    case NotSeen::blurred:
      return soft_sentences(std::array{SoftPicture{.tags = {d}}}).front();
    case NotSeen::mirrored:
      return fmt::format("tag {} is there, but mirrored: switch the camera's mirror off", d.tag);
    case NotSeen::other_family:
      if (d.family == in_negative)
        return fmt::format(
            "tag {} is there, but in negative, black and white exchanged: print it anew, or switch the camera's "
            "negative effect off",
            d.tag);
      return fmt::format("tag {} looks like {} of the family {}: print it anew in 36h11", d.tag, d.tag, d.family);
  }
  return {};
}

}  // namespace skein::vision

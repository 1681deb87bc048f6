#pragma once

#include <cstdint>
#include <string_view>

namespace skein::core {

/// Why a camera's tracker reports no pose of a tag.
enum class NotSeen : std::uint8_t {
  not_found,     ///< nothing in the frame decodes as this tag
  wrong_size,    ///< it is there, but larger or smaller than the calibration's tag_size on the plane of the tags
  lifted,        ///< it is there, but nearer to the camera than the other tags
  tilted,        ///< it is there, but not a square on the plane of the tags
  doubled,       ///< it is there twice
  covered,       ///< it is there, but part of it is hidden or blurred
  at_border,     ///< the border of the frame cuts it, or did when it was last seen
  too_small,     ///< this camera gives tags of tag_size too few pixels to be decoded
  too_bright,    ///< much of the frame is as bright as the camera can show
  in_shadow,     ///< ink and paper differ by too few grey levels
  blurred,       ///< nothing decodes as this tag, and the edges of the whole frame are blurred
  mirrored,      ///< the camera mirrors its frames
  other_family,  ///< a tag of another family has this id
};

/// As a word for logs (core/words.h).
constexpr std::string_view word(NotSeen why) noexcept {
  switch (why) {
    case NotSeen::not_found:
      return "not_found";
    case NotSeen::wrong_size:
      return "wrong_size";
    case NotSeen::lifted:
      return "lifted";
    case NotSeen::tilted:
      return "tilted";
    case NotSeen::doubled:
      return "doubled";
    case NotSeen::covered:
      return "covered";
    case NotSeen::at_border:
      return "at_border";
    case NotSeen::too_small:
      return "too_small";
    case NotSeen::too_bright:
      return "too_bright";
    case NotSeen::in_shadow:
      return "in_shadow";
    case NotSeen::blurred:
      return "blurred";
    case NotSeen::mirrored:
      return "mirrored";
    case NotSeen::other_family:
      return "other_family";
  }
  return {};
}

}  // namespace skein::core

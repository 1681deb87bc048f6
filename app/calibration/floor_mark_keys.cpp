#include "app/calibration/floor_mark_keys.h"

#include <fmt/format.h>

#include <algorithm>

#include "vision/tags/tag_family.h"

namespace skein::app {

using vision::FloorMark;

void read_tag(TomlTable& t, const char* key, std::span<const FloorMark> before, FloorMark& mark, Problems& problems) {
  t.integer(key, mark.tag, 0, vision::largest_tag);
  if (mark.tag < 0) return;
  mark.name = fmt::format("tag {}", mark.tag);
  if (std::any_of(before.begin(), before.end(), [&](const FloorMark& m) { return m.tag == mark.tag; }))
    problems.add(t.full(key), fmt::format("found {} again, allowed: each tag once", mark.tag));
}

void read_place(TomlTable& t, FloorMark& mark) {
  constexpr Range place = between(-100.0, 100.0, "m");
  t.needed("x", mark.x, place);
  t.needed("y", mark.y, place);
  t.number("z", mark.z, between(-10.0, 10.0, "m"));
}

}  // namespace skein::app

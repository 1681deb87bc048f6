#include "app/calibration/floor_marks_file.h"

#include <fmt/format.h>

#include "app/experiment/text_file.h"
#include "app/experiment/toml_table.h"

namespace skein::app {
namespace {

using vision::FloorMark;

void read_place(TomlTable& t, FloorMark& mark) {
  const Range place = between(-100.0, 100.0, "m");
  t.needed("x", mark.x, place);
  t.needed("y", mark.y, place);
  t.number("z", mark.z, between(-10.0, 10.0, "m"));
  t.finish();
}

}  // namespace

tl::expected<std::vector<FloorMark>, std::string> parse_floor_marks(std::string_view text, const std::string& name) {
  const auto document = parse_toml(text, name);
  if (!document) return tl::unexpected(messages(document.error()));
  Problems problems(*document, name);
  TomlTable root(&*document, "", problems);
  std::vector<FloorMark> marks;
  for (TomlTable& t : root.tables("tag")) {
    FloorMark mark;
    t.require("id", "the number of a tag, 0 to 586");
    t.integer("id", mark.tag, 0, 586);
    mark.name = fmt::format("tag {}", mark.tag);
    for (const FloorMark& other : marks)
      if (other.tag == mark.tag && mark.tag >= 0)
        problems.add(t.full("id"), fmt::format("found {} again, allowed: each tag once", mark.tag));
    read_place(t, mark);
    marks.push_back(mark);
  }
  std::size_t points = 0;
  for (TomlTable& t : root.tables("point")) {
    FloorMark mark;
    mark.name = fmt::format("point {}", ++points);
    const Range pixel = between(-1.0, 32768.0, "px");
    t.needed("u", mark.u, pixel);
    t.needed("v", mark.v, pixel);
    mark.seen = true;
    read_place(t, mark);
    marks.push_back(mark);
  }
  root.finish();
  if (marks.empty() && problems.empty())
    problems.add({{1, 1}, {1, 1}, nullptr}, "no mark on this floor, allowed: [[tag]] or [[point]], 4 and more");
  if (!problems.empty()) return tl::unexpected(messages(std::move(problems).sorted()));
  return marks;
}

tl::expected<std::vector<FloorMark>, std::string> load_floor_marks(const std::filesystem::path& path) {
  const auto text = read_text(path.string());
  if (!text) return tl::unexpected(messages(text.error()));
  return parse_floor_marks(*text, path.string());
}

}  // namespace skein::app

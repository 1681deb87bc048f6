#include "app/calibration/floor_marks_file.h"

#include <fmt/format.h>

#include "app/calibration/floor_mark_keys.h"
#include "app/experiment/text_file.h"
#include "app/experiment/toml_table.h"
#include "vision/tags/tag_family.h"

namespace skein::app {

using vision::FloorMark;

tl::expected<std::vector<FloorMark>, std::string> parse_floor_marks(std::string_view text, const std::string& name) {
  const auto document = parse_toml(text, name, FileKind::marks);
  if (!document) return tl::unexpected(messages(document.error()));
  Problems problems(*document, name);
  TomlTable root(&*document, "", problems);
  std::vector<FloorMark> marks;
  for (TomlTable& t : root.tables("tag")) {
    FloorMark mark;
    t.require("id", fmt::format("the number of a tag, 0 to {}", vision::largest_tag));
    read_tag(t, "id", marks, mark, problems);
    read_place(t, mark);
    t.finish();
    marks.push_back(mark);
  }
  std::size_t points = 0;
  for (TomlTable& t : root.tables("point")) {
    FloorMark mark;
    mark.name = fmt::format("point {}", ++points);
    t.needed("u", mark.u, pixel_range);
    t.needed("v", mark.v, pixel_range);
    mark.seen = true;
    read_place(t, mark);
    t.finish();
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

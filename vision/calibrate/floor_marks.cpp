// The file of what lies where on the floor.
#include <fmt/format.h>

#include <toml++/toml.h>
#include <fstream>
#include <sstream>

#include "vision/calibrate/floor_calibration.h"
#include "vision/calibration/toml_reader.h"

namespace skein::vision {
namespace {

using detail::Problem;
using detail::Range;
using detail::Reader;

constexpr Range place{-100.0, 100.0};  // [m]

const toml::array* list(const Reader& reader, const toml::table& root, std::string_view key) {
  const toml::node* node = root.get(key);
  if (node == nullptr) return nullptr;
  const toml::array* array = node->as_array();
  if (array == nullptr || !array->is_homogeneous(toml::node_type::table))
    reader.fail(node->source(), reader.wrong(key, *node, fmt::format("tables [[{}]]", key)));
  return array;
}

void read_place(const Reader& reader, const toml::table& table, std::string_view of, FloorMark& mark) {
  mark.x = reader.number(table, of, "x", place);
  mark.y = reader.number(table, of, "y", place);
  if (table.contains("z")) mark.z = reader.number(table, of, "z", {-10.0, 10.0});
}

std::vector<FloorMark> read(const Reader& reader, const toml::table& root) {
  reader.only(root, "", {"tag", "point"});
  std::vector<FloorMark> marks;
  if (const toml::array* tags = list(reader, root, "tag"))
    for (const toml::node& node : *tags) {
      const toml::table& table = *node.as_table();
      reader.only(table, "tag.", {"id", "x", "y", "z"});
      FloorMark mark;
      mark.tag = reader.integer(table, "tag.", "id", {0, 586});
      mark.name = fmt::format("tag {}", mark.tag);
      for (const FloorMark& other : marks)
        if (other.tag == mark.tag) reader.fail(table.source(), fmt::format("tag.id = {} stands here twice", mark.tag));
      read_place(reader, table, "tag.", mark);
      marks.push_back(mark);
    }
  if (const toml::array* points = list(reader, root, "point"))
    for (std::size_t i = 0; i < points->size(); ++i) {
      const toml::table& table = *points->get(i)->as_table();
      reader.only(table, "point.", {"u", "v", "x", "y", "z"});
      FloorMark mark;
      mark.name = fmt::format("point {}", i + 1);
      mark.u = reader.number(table, "point.", "u", {-1.0, 32768.0});
      mark.v = reader.number(table, "point.", "v", {-1.0, 32768.0});
      mark.seen = true;
      read_place(reader, table, "point.", mark);
      marks.push_back(mark);
    }
  if (marks.empty()) reader.fail(root.source(), "nothing lies on this floor; needed: [[tag]] or [[point]]");
  return marks;
}

}  // namespace

tl::expected<std::vector<FloorMark>, std::string> parse_floor_marks(std::string_view text, const std::string& name) {
  const Reader reader(name);
  try {
    return read(reader, toml::parse(text, name));
  } catch (const toml::parse_error& error) {
    return tl::unexpected(
        fmt::format("{}:{}:{}: {}", name, error.source().begin.line, error.source().begin.column, error.description()));
  } catch (const Problem& problem) {
    return tl::unexpected(problem.text);
  }
}

tl::expected<std::vector<FloorMark>, std::string> load_floor_marks(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  if (!file || !(text << file.rdbuf()))
    return tl::unexpected(fmt::format("{}: the file of the floor's marks cannot be read", path.string()));
  return parse_floor_marks(text.str(), path.string());
}

}  // namespace skein::vision

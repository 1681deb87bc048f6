#include "rules.h"
#include "tests/places.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <optional>
#include <set>
#include <sstream>
#include <string_view>

namespace skein::test {
namespace {

using std::string;
using std::string_view;

/// skein (the program) -> ui -> app -> { vision, comms } -> core. Every room may also include itself.
const std::map<string, std::set<string>, std::less<>> arrows{
    {"core", {"core"}},
    {"vision", {"vision", "core"}},
    {"comms", {"comms", "core"}},
    {"app", {"app", "vision", "comms", "core"}},
    {"ui", {"ui", "app", "core"}},
};

/// What core may take from the standard library: everything that computes, nothing that waits, reads, writes or looks
/// at a clock.
const std::set<string, std::less<>> core_std{"algorithm",
                                             "array",
                                             "bit",
                                             "cassert",
                                             "cfloat",
                                             "cmath",
                                             "compare",
                                             "complex",
                                             "concepts",
                                             "cstddef",
                                             "cstdint",
                                             "cstdlib",
                                             "cstring",
                                             "deque",
                                             "exception",
                                             "functional",
                                             "initializer_list",
                                             "iterator",
                                             "limits",
                                             "map",
                                             "memory",
                                             "new",
                                             "numbers",
                                             "numeric",
                                             "optional",
                                             "random",
                                             "ranges",
                                             "ratio",
                                             "set",
                                             "span",
                                             "stdexcept",
                                             "string",
                                             "string_view",
                                             "tuple",
                                             "type_traits",
                                             "unordered_map",
                                             "unordered_set",
                                             "utility",
                                             "valarray",
                                             "variant",
                                             "vector"};

bool starts_with_any(string_view text, std::initializer_list<string_view> beginnings) {
  return std::any_of(beginnings.begin(), beginnings.end(), [&](string_view b) { return text.starts_with(b); });
}

string room_of(string_view path) {
  return string(path.substr(0, path.find('/')));
}

bool is_opencv_or_apriltag(string_view header) {
  return starts_with_any(header, {"opencv", "apriltag", "tag16h5", "tag25h9", "tag36h", "tagCircle", "tagCustom",
                                  "tagStandard", "common/zarray", "common/image_u8", "common/matd"});
}

bool is_bluez(string_view header) {
  return header.starts_with("bluetooth/") || header.starts_with("systemd/");  // its sockets, its daemon on D-Bus
}

/// <QWidget>, <QtCore/QObject>, <qcustomplot.h>, <qwidget.h>
bool is_qt(string_view header) {
  const bool capital = header.size() > 1 && header[0] == 'Q' && std::isalpha(static_cast<unsigned char>(header[1]));
  return capital || starts_with_any(header, {"qcustomplot", "qt", "qwidget", "qobject", "qapplication"});
}

/// Files of vision that only vision itself sees.
bool is_private_to_vision(string_view path) {
  return path.ends_with(".cpp") ||
         starts_with_any(path, {"vision/boards/", "vision/fit/", "vision/media/", "vision/modules/"});
}

struct Include {
  int line;
  string header;
};

/// The header that a line includes, in quotes or angle brackets; empty where it is no include directive.
string_view included_by(string_view line) {
  const auto skip_blanks = [&] { line.remove_prefix(std::min(line.find_first_not_of(" \t"), line.size())); };
  const auto skip = [&](string_view word) {
    skip_blanks();
    const bool found = line.starts_with(word);
    if (found) line.remove_prefix(word.size());
    return found;
  };
  if (!skip("#") || !skip("include")) return {};
  skip_blanks();
  if (!starts_with_any(line, {"<", "\""})) return {};
  const auto end = line.find_first_of(">\"", 1);
  return end == string_view::npos ? string_view() : line.substr(1, end - 1);
}

std::vector<Include> includes_of(const string& text) {
  std::vector<Include> found;
  std::istringstream lines(text);
  int number = 0;
  for (string line; std::getline(lines, line);) {
    ++number;
    if (const string_view header = included_by(line); !header.empty()) found.push_back({number, string(header)});
  }
  return found;
}

/// Why `path` may not include `header`; nothing where it may.
std::optional<string> objection(const string& path, const string& header) {
  const string room = room_of(path);
  const bool is_program = path == "app/program/main.cpp";
  const string target = header.find('/') == string::npos ? string() : room_of(header);

  if (arrows.contains(target)) {
    if (is_program && target == "ui") return {};
    if (!arrows.at(room).contains(target)) return room + " must not know " + target;
    if (target == "vision" && room != "vision" && is_private_to_vision(header)) return header + " is private to vision";
    return {};
  }
  if (header.starts_with(".")) return "includes are written from the project's root";
  if (is_qt(header) && room != "ui") return room + " must do without Qt";
  if (is_opencv_or_apriltag(header)) {
    if (room != "vision") return "OpenCV and AprilTag are private to vision";
    if (!is_private_to_vision(path)) return "OpenCV and AprilTag must not show in vision's public headers";
  }
  if (is_bluez(header) && !(room == "comms" && path.ends_with(".cpp"))) return "BlueZ is private to comms' .cpp files";
  if (room == "core" && !header.starts_with("Eigen/") && !core_std.contains(header))
    return "core is made of itself, Eigen and the parts of the standard library that compute";
  return {};
}

bool is_source(const std::filesystem::path& path) {
  static const std::set<string> endings{".h", ".hpp", ".hh", ".cpp", ".cc", ".cxx", ".c", ".ipp", ".inl", ".in"};
  return endings.contains(path.extension().string());
}

}  // namespace

std::vector<string> broken_rules(const SourceFile& file) {
  std::vector<string> broken;
  for (const Include& include : includes_of(file.text))
    if (const auto why = objection(file.path, include.header))
      broken.push_back(file.path + ":" + std::to_string(include.line) + ": includes " + include.header + ": " + *why);
  return broken;
}

std::vector<SourceFile> sources_of(const string& room) {
  const std::filesystem::path root = test::in_source("");
  std::vector<SourceFile> files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(root / room)) {
    if (!entry.is_regular_file() || !is_source(entry.path())) continue;
    std::ifstream in(entry.path());
    files.push_back({entry.path().lexically_relative(root).generic_string(),
                     string(std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>())});
  }
  std::sort(files.begin(), files.end(), [](const auto& a, const auto& b) { return a.path < b.path; });
  return files;
}

}  // namespace skein::test

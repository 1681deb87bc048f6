#include "rules.h"
#include "tests/places.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <optional>
#include <regex>
#include <set>
#include <sstream>
#include <stdexcept>
#include <string_view>

namespace skein::test {
namespace {

using std::string;
using std::string_view;

const std::set<string, std::less<>> rooms{"core", "vision", "comms", "app", "ui"};

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

string folder_of(string_view path) {
  const auto slash = path.rfind('/');
  return slash == string_view::npos ? string() : string(path.substr(0, slash));
}

bool is_inside(string_view path, string_view folder) {
  return path == folder || (path.starts_with(folder) && path[folder.size()] == '/');
}

/// The line of the table that speaks for a file: that of its folder, or of the nearest folder above.
Arrows::const_iterator line_for(const Arrows& arrows, string_view path) {
  auto nearest = arrows.end();
  for (auto line = arrows.begin(); line != arrows.end(); ++line)
    if (is_inside(path, line->first) && (nearest == arrows.end() || line->first.size() > nearest->first.size()))
      nearest = line;
  return nearest;
}

/// The header without its ending, likewise the source: both are one unit.
string unit_of(string_view path) {
  return string(path.substr(0, path.rfind('.')));
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

/// Why the line of the table does not let `path` include `header` of another room or folder; nothing where it does.
std::optional<string> forbidden_arrow(const string& path, const string& header, const Arrows& arrows) {
  const auto line = line_for(arrows, path);
  if (line == arrows.end()) return "ARCHITECTURE.md has no arrows for " + folder_of(path);
  const auto& [folder, allowed] = *line;
  if (is_inside(header, folder)) return {};
  if (std::any_of(allowed.begin(), allowed.end(), [&](const string& to) { return is_inside(header, to); })) return {};
  return folder + " must not know " + folder_of(header);
}

/// Why `path` may not include `header`; nothing where it may.
std::optional<string> objection(const string& path, const string& header, const Arrows& arrows) {
  const string room = room_of(path);
  const string target = header.find('/') == string::npos ? string() : room_of(header);

  if (rooms.contains(target)) {
    if (auto why = forbidden_arrow(path, header, arrows)) return why;
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
  if (header == "sleef.h" && path == "core/math/elementary.cpp") return {};
  if (room == "core" && !header.starts_with("Eigen/") && !core_std.contains(header))
    return "core is made of itself, Eigen, SLEEF in core/math and the parts of the standard library that compute";
  return {};
}

/// The rooms whose namespace a line of code names ("comms::LinkState"), comments and texts left out.
std::set<string, std::less<>> rooms_named_in(string_view line) {
  std::set<string, std::less<>> named;
  bool in_text = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (line[i] == '\\') {
      ++i;
    } else if (line[i] == '"') {
      in_text = !in_text;
    } else if (!in_text && line.substr(i).starts_with("//")) {
      break;
    } else if (!in_text && line.substr(i).starts_with("::")) {
      auto begin = i;
      while (begin > 0 && (std::isalnum(static_cast<unsigned char>(line[begin - 1])) || line[begin - 1] == '_'))
        --begin;
      const string word(line.substr(begin, i - begin));
      if (rooms.contains(word)) named.insert(word);
    }
  }
  return named;
}

/// The function that a line of code calls of those whose last digit is another one on another machine; empty where it
/// calls none.
string changing_function_in(string_view line) {
  static const std::regex call(
      R"(std::(sinh?|cosh?|tanh?|asin|acos|atan2?|exp2?|expm1|log(2|10|1p)?|pow|cbrt|hypot)\()");
  std::match_results<string_view::const_iterator> found;
  const string_view code = line.substr(0, line.find("//"));
  return std::regex_search(code.begin(), code.end(), found, call) ? "std::" + found[1].str() : string();
}

/// True where the table lets `path` use something of `room`.
bool may_name(const string& path, string_view room, const Arrows& arrows) {
  if (room_of(path) == room) return true;
  const auto line = line_for(arrows, path);
  return line != arrows.end() &&
         std::any_of(line->second.begin(), line->second.end(), [&](const string& to) { return room_of(to) == room; });
}

/// One cycle of a graph as a sentence, "a -> b -> a"; empty where there is none.
string cycle_of(const std::map<string, std::set<string>>& graph) {
  enum class Mark { unseen, open, done };
  std::map<string, Mark> marks;
  std::vector<string> way;
  const auto visit = [&](const auto& self, const string& node) -> string {
    marks[node] = Mark::open;
    way.push_back(node);
    if (const auto targets = graph.find(node); targets != graph.end()) {
      for (const string& next : targets->second) {
        if (marks[next] == Mark::open) {
          string cycle;
          for (auto at = std::find(way.begin(), way.end(), next); at != way.end(); ++at) cycle += *at + " -> ";
          return cycle + next;
        }
        if (marks[next] == Mark::unseen)
          if (string cycle = self(self, next); !cycle.empty()) return cycle;
      }
    }
    marks[node] = Mark::done;
    way.pop_back();
    return {};
  };
  for (const auto& [node, targets] : graph)
    if (marks[node] == Mark::unseen)
      if (string cycle = visit(visit, node); !cycle.empty()) return cycle;
  return {};
}

bool is_source(const std::filesystem::path& path) {
  static const std::set<string> endings{".h", ".hpp", ".hh", ".cpp", ".cc", ".cxx", ".c", ".ipp", ".inl", ".in"};
  return endings.contains(path.extension().string());
}

}  // namespace

Arrows arrows_of(string_view page) {
  constexpr string_view begin = "```arrows\n";
  const auto start = page.find(begin);
  if (start == string_view::npos) throw std::runtime_error("the page has no block ```arrows");
  const auto body = page.substr(start + begin.size());
  std::istringstream lines{string(body.substr(0, body.find("```")))};
  Arrows arrows;
  for (string line; std::getline(lines, line);) {
    std::istringstream words(line);
    string folder, arrow;
    if (!(words >> folder >> arrow) || arrow != "->") throw std::runtime_error("no arrow: " + line);
    auto& allowed = arrows[folder];
    for (string to; words >> to;) {
      if (to.ends_with(',')) to.pop_back();
      allowed.insert(to);
    }
  }
  return arrows;
}

std::vector<string> broken_rules(const SourceFile& file, const Arrows& arrows) {
  std::vector<string> broken;
  const auto report = [&](int line, const string& what) {
    broken.push_back(file.path + ":" + std::to_string(line) + ": " + what);
  };
  for (const Include& include : includes_of(file.text))
    if (const auto why = objection(file.path, include.header, arrows))
      report(include.line, "includes " + include.header + ": " + *why);
  std::istringstream lines(file.text);
  int number = 0;
  for (string line; std::getline(lines, line);) {
    ++number;
    for (const string& room : rooms_named_in(line))
      if (!may_name(file.path, room, arrows)) report(number, "uses " + room + ":: without an arrow to " + room);
    if (const string room = room_of(file.path); room == "core" || room == "app")
      if (const string function = changing_function_in(line); !function.empty())
        report(number, "calls " + function + ", which is not the same to the bit everywhere: core/math/elementary.h");
  }
  return broken;
}

std::vector<string> cycles_in(const std::vector<SourceFile>& files) {
  std::set<string, std::less<>> paths;
  for (const SourceFile& file : files) paths.insert(file.path);
  std::map<string, std::set<string>> units, folders;
  for (const SourceFile& file : files)
    for (const Include& include : includes_of(file.text)) {
      if (!paths.contains(include.header)) continue;
      const auto link = [](auto& graph, const string& from, const string& to) {
        if (from != to) graph[from].insert(to);
      };
      link(units, unit_of(file.path), unit_of(include.header));
      link(folders, folder_of(file.path), folder_of(include.header));
    }
  std::vector<string> found;
  if (const string cycle = cycle_of(units); !cycle.empty()) found.push_back("units include each other: " + cycle);
  if (const string cycle = cycle_of(folders); !cycle.empty()) found.push_back("folders include each other: " + cycle);
  return found;
}

std::vector<std::string> choices_by_one_enumerator(const std::vector<SourceFile>& files) {
  const std::regex declaration(R"(enum class (\w+)[^{;]*\{([^}]*)\})"), comment("//[^\n]*"), enumerator(R"(\w+)");
  const std::regex choice(R"([!=]=\s*(?:\w+::)*(\w+)::(\w+)\s*\)?\s*\?)");
  std::set<std::pair<std::string, std::string>> enumerators;
  for (const SourceFile& file : files)
    for (std::sregex_iterator e(file.text.begin(), file.text.end(), declaration), none; e != none; ++e) {
      const std::string body = std::regex_replace((*e)[2].str(), comment, "");
      for (std::sregex_iterator name(body.begin(), body.end(), enumerator); name != none; ++name)
        enumerators.emplace((*e)[1], name->str());
    }
  std::vector<std::string> found;
  for (const SourceFile& file : files)
    for (std::sregex_iterator c(file.text.begin(), file.text.end(), choice), none; c != none; ++c) {
      if (!enumerators.contains({(*c)[1], (*c)[2]})) continue;
      const auto line = 1 + std::count(file.text.begin(), file.text.begin() + c->position(), '\n');
      found.push_back(file.path + ":" + std::to_string(line) + ": ? : by " + (*c)[1].str() + "::" + (*c)[2].str() +
                      ": a new enumerator would silently be one of the others; a switch has to handle it");
    }
  return found;
}

std::vector<std::string> definitions_that_meet(const std::vector<SourceFile>& files) {
  const std::regex constant(R"(^(?:constexpr|const) [^;({=]*\b(\w+)(?:\[[^\]]*\])? *[={].*)"), main(R"(int main\(.*)"),
      function(R"(^[\w:<>,&*][\w:<>,&* ]* [&*]*\w+\(.*\) (?:noexcept )?\{)");
  std::map<std::pair<string, string>, string> first;  // by folder and definition: where it stands
  std::vector<std::string> found;
  for (const SourceFile& file : files) {
    if (!file.path.ends_with(".cpp")) continue;
    const string folder = file.path.substr(0, file.path.rfind('/'));
    std::istringstream text(file.text);
    string line;
    for (int number = 1; std::getline(text, line); ++number) {
      std::smatch parts;
      string what;
      if (std::regex_match(line, parts, constant))
        what = parts[1];
      else if (std::regex_match(line, function) && !std::regex_match(line, main))
        what = line;
      if (what.empty()) continue;
      const string here = file.path + ":" + std::to_string(number);
      const auto [other, added] = first.emplace(std::pair(folder, what), here);
      const bool for_another_machine = other->second.starts_with(file.path + ":");  // twice in one source: under #if
      if (!added && !for_another_machine)
        found.push_back(here + ": " + what + ": defined at " + other->second + " too: names within a room differ");
    }
  }
  return found;
}

std::vector<SourceFile> sources_of(const string& room) {
  const std::filesystem::path root = test::in_source("");
  std::vector<SourceFile> files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(root / room)) {
    if (!entry.is_regular_file() || !is_source(entry.path())) continue;
    const string path = entry.path().lexically_relative(root).generic_string();
    files.push_back({path, text_of(path)});
  }
  std::sort(files.begin(), files.end(), [](const auto& a, const auto& b) { return a.path < b.path; });
  return files;
}

string text_of(const string& path) {
  std::ifstream in(test::in_source(path));
  return string(std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>());
}

}  // namespace skein::test

#include "app/experiment/file_kind.h"

#include <algorithm>
#include <initializer_list>

#include <fmt/format.h>

#include "core/words.h"

namespace skein::app {
namespace {

bool has_one_of(const toml::table& document, std::initializer_list<std::string_view> keys) {
  return std::any_of(keys.begin(), keys.end(), [&](std::string_view key) { return document.contains(key); });
}

/// Whether the document has keys that only this kind of file has.
bool has_keys_of(const toml::table& document, FileKind kind) {
  switch (kind) {
    case FileKind::experiment:
      return has_one_of(document, {"reference", "controller", "duration", "arena", "robot_defaults", "simulation"});
    case FileKind::study:
      return document["experiment"].is_string();
    case FileKind::calibration:
      return static_cast<bool>(document["camera"]["fx"]);
    case FileKind::robots:
      return document.size() == 1 && document.contains("robot");
    case FileKind::marks:
      return has_one_of(document, {"tag", "point"});
    case FileKind::faults:
      return document.contains("fault");
  }
  return false;
}

}  // namespace

std::optional<Problem> check_kind(const toml::table& document, const std::string& file, FileKind read_as) {
  if (has_keys_of(document, read_as)) return {};
  for (const FileKind kind : core::all_of<FileKind>()) {
    if (kind == FileKind::robots && read_as == FileKind::experiment) continue;  // it may have robots alone
    if (has_keys_of(document, kind))
      return Problem{file, 0, 0, fmt::format("found {}, allowed: {}", word(kind), word(read_as))};
  }
  return {};
}

}  // namespace skein::app

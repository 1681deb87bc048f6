#include "app/runs/run_folder.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>

#include "app/experiment/text_file.h"
#include "app/run/home.h"
#include "app/run/utf8.h"
#include "app/runs/sha256.h"

namespace skein::app {

namespace fs = std::filesystem;

std::string kept_calibration(std::size_t camera) {
  return camera == 0 ? "calibration.toml" : fmt::format("calibration-{}.toml", camera + 1);
}

tl::expected<std::string, std::string> runs_directory(const std::string& asked) {
  if (!asked.empty()) return asked;
  if (const char* const runs = std::getenv("SKEIN_RUNS"); runs && *runs) return runs;
  if (const char* const data = std::getenv("XDG_DATA_HOME"); data && *data == '/')
    return (fs::path(data) / "skein/runs").string();
  const std::string home = home_folder();
  if (home.empty())
    return tl::unexpected(
        std::string("no folder for kept runs: this user has no home, allowed: --runs-dir, or a folder in SKEIN_RUNS"));
  return (fs::path(home) / ".local/share/skein/runs").string();
}

std::optional<std::string> folder_of_a_run(const std::string& directory) {
  std::error_code unknown;
  if (!fs::exists(fs::path(directory) / run_files::story, unknown)) return {};
  return directory + ": is the folder of a kept run itself, allowed: the folder that has the runs";
}

std::vector<std::string> files_of_run(const std::string& folder) {
  std::vector<std::string> names;
  std::error_code error;
  constexpr auto others = fs::directory_options::skip_permission_denied;
  for (fs::recursive_directory_iterator file(folder, others, error), end; !error && file != end; file.increment(error))
    if (std::error_code gone; file->is_regular_file(gone))
      names.push_back(file->path().lexically_relative(folder).string());
  std::sort(names.begin(), names.end());
  return names;
}

std::uintmax_t bytes_of_run(const std::string& folder) {
  std::uintmax_t bytes = 0;
  for (const std::string& name : files_of_run(folder)) {
    std::error_code error;
    const std::uintmax_t size = fs::file_size(fs::path(folder) / name, error);
    if (!error) bytes += size;
  }
  return bytes;
}

std::optional<std::uintmax_t> bytes_when_written(const nlohmann::ordered_json& story, std::uintmax_t story_bytes) {
  const auto files = story.find("files");
  if (files == story.end() || !files->is_object()) return {};
  std::uintmax_t bytes = story_bytes;
  for (const auto& file : *files) {
    const auto size = file.is_object() ? file.find("bytes") : file.end();
    if (size == file.end() || !size->is_number_unsigned()) return {};
    bytes += size->get<std::uintmax_t>();
  }
  return bytes;
}

std::optional<std::string> little_room(const std::string& directory, std::uintmax_t least) {
  std::error_code error;
  fs::path place = fs::absolute(directory, error);
  while (!error && !fs::exists(place, error) && place.has_relative_path()) place = place.parent_path();
  const fs::space_info space = fs::space(place, error);
  if (error || space.available >= least) return {};
  const auto free = static_cast<double>(space.available);
  const std::string said = free < 1e8 ? fmt::format("{:.0f} MB", free / 1e6) : fmt::format("{:.1f} GB", free / 1e9);
  return fmt::format("{}: only {} are free for kept runs; `skein runs remove` makes room", directory, said);
}

tl::expected<nlohmann::ordered_json, std::string> read_story(const std::string& folder) {
  const std::string path = (fs::path(folder) / run_files::story).string();
  const auto text = read_text(path);
  if (!text) return tl::unexpected(text.error().front().message());
  constexpr int deepest = 100;  // what is nested deeper cannot be written again: that recurses
  bool too_deep = false;
  const auto is_shallow = [&](int depth, nlohmann::ordered_json::parse_event_t, nlohmann::ordered_json&) {
    too_deep = too_deep || depth > deepest;
    return !too_deep;
  };
  std::string why = "it is not a JSON object";
  try {
    auto story = nlohmann::ordered_json::parse(*text, is_shallow);
    if (story.is_object() && !too_deep) return story;
    if (too_deep) why = fmt::format("it is nested more than {} levels deep", deepest);
  } catch (const nlohmann::json::exception& error) {  // "[json.exception...] parse error at line 3, column 7: ..."
    constexpr std::size_t longest = 200;              // it repeats the text that it does not understand
    why = error.what();
    why.erase(0, why.find("] ") + 2);
    if (why.size() > longest) why = std::string(first_letters(why, longest)) + "...";
  }
  return tl::unexpected(fmt::format("{}: {}, allowed: a file written by `skein run --keep`", path, why));
}

std::optional<std::int64_t> began_at(const nlohmann::ordered_json& story) {
  const auto found = story.find("began");
  if (found == story.end() || !found->is_string()) return {};
  const std::string text = found->get<std::string>();  // 2026-11-20T20:15:01.123+01:00
  constexpr std::size_t seconds_at = 17, zone_long = 6;
  if (text.size() < seconds_at + zone_long) return {};
  const std::string zone_text = text.substr(text.size() - zone_long);
  int year = 0, month = 0, day = 0, hour = 0, minute = 0, zone_hours = 0, zone_minutes = 0;
  double second = 0.0;  // read without the window's language, which may have another point
  char sign = 0;
  if (std::sscanf(text.c_str(), "%4d-%2d-%2dT%2d:%2d:", &year, &month, &day, &hour, &minute) != 5 ||
      std::from_chars(text.data() + seconds_at, text.data() + text.size() - zone_long, second).ec != std::errc{} ||
      std::sscanf(zone_text.c_str(), "%c%2d:%2d", &sign, &zone_hours, &zone_minutes) != 3 ||
      (sign != '+' && sign != '-'))
    return {};
  const std::chrono::year_month_day date{std::chrono::year(year), std::chrono::month(static_cast<unsigned>(month)),
                                         std::chrono::day(static_cast<unsigned>(day))};
  // Nanoseconds since 1970 end in April 2262. A second may be a leap second, and no zone is a day away.
  constexpr int earliest = 1700, latest = 2261;
  const auto within = [](auto value, auto low, auto high) { return value >= low && value <= high; };
  if (!date.ok() || !within(year, earliest, latest) || !within(hour, 0, 23) || !within(minute, 0, 59) ||
      !within(second, 0.0, 61.0) || !within(zone_hours, 0, 23) || !within(zone_minutes, 0, 59))
    return {};
  const auto zone = (sign == '-' ? -1 : 1) * (std::chrono::hours(zone_hours) + std::chrono::minutes(zone_minutes));
  const auto at = std::chrono::sys_days(date) + std::chrono::hours(hour) + std::chrono::minutes(minute) - zone;
  constexpr double ms_per_second = 1e3;
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             at.time_since_epoch() + std::chrono::milliseconds(std::llround(ms_per_second * second)))
      .count();
}

std::optional<RunValue> number_of(std::string_view text) {
  const char* const end = text.data() + text.size();
  double number = 0.0;
  if (const auto [stop, error] = std::from_chars(text.data(), end, number); error != std::errc{} || stop != end)
    return {};
  std::int64_t whole = 0;
  const auto [stop, error] = std::from_chars(text.data(), end, whole);
  // Up to here every whole number is a double.
  constexpr std::int64_t exact = std::int64_t{1} << std::numeric_limits<double>::digits;
  if (error == std::errc{} && stop == end && (whole > exact || whole < -exact)) return whole;
  return number;
}

namespace {

constexpr const char* seal = "sha256";

std::string text_of(const nlohmann::ordered_json& story) {
  return story.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

}  // namespace

std::string sealed(nlohmann::ordered_json story) {
  story.erase(seal);
  story[seal] = sha256_of_text(text_of(story));
  return text_of(story) + '\n';
}

std::optional<bool> seal_holds(nlohmann::ordered_json story) {
  if (!story.contains(seal)) return {};
  const std::string found = text_at(story, seal);
  story.erase(seal);
  return found == sha256_of_text(text_of(story));
}

std::string text_at(const nlohmann::ordered_json& story, const char* key) {
  const auto found = story.is_object() ? story.find(key) : story.end();
  return found != story.end() && found->is_string() ? found->get<std::string>() : std::string();
}

std::string text_at(const nlohmann::ordered_json& story, const char* table, const char* key) {
  const auto found = story.find(table);
  return found != story.end() ? text_at(*found, key) : std::string();
}

std::string calibration_in_folder(const std::string& name, std::size_t camera) {
  const fs::path path = fs::path(name).lexically_normal();
  if (path.is_absolute() || path.empty() || *path.begin() == "..") return kept_calibration(camera);
  std::string here = path.string();
  for (const char* const taken : {run_files::story, run_files::record, run_files::as_written, run_files::as_run,
                                  run_files::summary, run_files::robots})
    if (here == taken) return kept_calibration(camera);
  constexpr std::size_t most_cameras = 64;
  for (std::size_t other = 0; other < most_cameras; ++other)
    if (here == kept_calibration(other)) return kept_calibration(camera);
  return here;
}

std::map<std::string, RunValue> run_facts(const nlohmann::ordered_json& story) {
  std::map<std::string, RunValue> facts;
  const auto add = [&](const std::string& key, const nlohmann::ordered_json& value) {
    if (value.is_number())
      facts[key] = number_of(value.dump()).value_or(value.get<double>());
    else if (value.is_boolean())
      facts[key] = std::string(value.get<bool>() ? "true" : "false");
    else if (value.is_string())
      facts[key] = value.get<std::string>();
  };
  for (const auto& [key, value] : story.items()) {
    const bool flat = key == "experiment" || key == "summary";  // their keys stand for themselves
    if (value.is_object() && key != "files" && key != "inputs")
      for (const auto& [inner, part] : value.items()) {
        // The word none is written as null. In an experiment it is a value (no camera), in a summary there is none.
        const bool is_word = part.is_null() && key == "experiment";
        add(flat ? inner : fmt::format("{}.{}", key, inner), is_word ? nlohmann::ordered_json("none") : part);
      }
    else if (key != seal)
      add(key, value);
  }
  return facts;
}

}  // namespace skein::app

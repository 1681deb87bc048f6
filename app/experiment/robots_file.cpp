#include "app/experiment/robots_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "app/experiment/file_change.h"
#include "app/experiment/text_file.h"
#include "app/experiment/toml_edit.h"

namespace skein::app {

tl::expected<std::size_t, std::string> add_to_robots_file(const std::string& file,
                                                          const std::vector<KnownRobot>& more) {
  auto change = FileChange::begin(file);
  if (!change) return tl::unexpected(change.error());
  std::string text;
  std::vector<KnownRobot> there;
  if (std::filesystem::exists(file)) {
    const auto read = read_text(file);
    auto robots = load_known_robots(file);
    if (!read || !robots) return tl::unexpected(messages(robots ? read.error() : robots.error()));
    text = *read;
    there = std::move(*robots);
  }
  const Added added = with_robots(text, there, more);
  if (added.robots > 0)
    if (const auto saved = change->save(added.text); !saved) return tl::unexpected(saved.error());
  return added.robots;
}

tl::expected<SavedValues, std::string> save_to_robots_file(const std::string& file,
                                                           const std::vector<FoundRobot>& robots) {
  auto change = FileChange::begin(file);
  if (!change) return tl::unexpected(change.error());
  const auto known = load_known_robots(file);
  const auto text = read_text(file);
  if (!known || !text) return tl::unexpected(messages(known ? text.error() : known.error()));
  SavedValues saved;
  std::string changed = *text;
  for (const FoundRobot& robot : robots) {
    const auto there = std::find_if(known->begin(), known->end(), [&](const auto& k) { return is(k, robot.spec); });
    if (there == known->end()) {
      saved.problems.push_back(fmt::format("{} is not in {}: none of its values was saved", robot.name, file));
      continue;
    }
    ++saved.robots;
    for (const auto& [key, value] : robot.values) {
      auto with = with_toml_value(changed, fmt::format("robot.{}.{}", there - known->begin() + 1, key), value);
      if (with)
        changed = std::move(*with);
      else
        saved.problems.push_back(fmt::format("{}: {}", file, with.error()));
    }
  }
  saved.changed = changed != *text;
  if (saved.changed)
    if (const auto written = change->save(changed); !written) return tl::unexpected(written.error());
  return saved;
}

}  // namespace skein::app

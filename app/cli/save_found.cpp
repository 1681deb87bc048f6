#include <fmt/format.h>

#include <algorithm>

#include "app/cli/commands.h"
#include "app/experiment/file_change.h"
#include "app/experiment/known_robots.h"
#include "app/experiment/text_file.h"
#include "app/experiment/toml_edit.h"
#include "app/run/exit_status.h"
#include "app/run/output.h"

namespace skein::app {

int save_found(const std::string& file, const std::vector<FoundRobot>& robots) {
  auto change = FileChange::begin(file);
  if (!change) {
    complain(change.error());
    return wrong_input;
  }
  const auto known = load_known_robots(file);
  const auto text = read_text(file);
  if (!known || !text) {
    print_error(messages(known ? text.error() : known.error()) + "\n");
    return wrong_input;
  }
  std::string changed = *text;
  for (const FoundRobot& robot : robots) {
    const auto there = std::find_if(known->begin(), known->end(), [&](const auto& k) { return is(k, robot.spec); });
    if (there == known->end()) {
      complain(fmt::format("{} is not in {}: none of its values was saved", robot.name, file));
      continue;
    }
    for (const auto& [key, value] : robot.values) {
      auto with = with_toml_value(changed, fmt::format("robot.{}.{}", there - known->begin() + 1, key), value);
      if (with)
        changed = std::move(*with);
      else
        complain(fmt::format("{}: {}", file, with.error()));
    }
  }
  if (changed == *text) return done;
  if (const auto saved = change->save(changed); !saved) {
    complain(saved.error());
    return wrong_input;
  }
  fmt::print("# saved in {}\n", file);
  return done;
}

}  // namespace skein::app

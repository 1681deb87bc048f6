#include <fmt/format.h>

#include <filesystem>
#include <optional>
#include <string>
#include <utility>

#include "app/cli/commands.h"
#include "app/experiment/file_change.h"
#include "app/experiment/text_file.h"
#include "app/experiment/toml_edit.h"
#include "app/run/exit_status.h"
#include "app/run/output.h"
#include "app/run/resources.h"
#include "app/run/terminal_text.h"

namespace skein::app {
namespace {

/// A file that is about to be changed, with its text after that; none: it is not possible, and stderr says why.
struct Changed {
  FileChange change;
  std::string text;
};
std::optional<Changed> changed(const std::string& file, const KeyValues& values) {
  auto change = FileChange::begin(file);
  if (!change) {
    complain(change.error());
    return {};
  }
  auto text = read_text(file);
  if (!text) {
    print_error(messages(text.error()) + "\n");
    return {};
  }
  for (const auto& [key, value] : values) {
    auto with = with_toml_value(*text, key, value);
    if (!with) {
      complain(fmt::format("{}: {}", file, with.error()));
      return {};
    }
    *text = std::move(*with);
  }
  return Changed{std::move(*change), std::move(*text)};
}

}  // namespace

bool can_save_keys(const std::string& file, const KeyValues& values) {
  // A name becomes the path of an experiment that comes with Skein, which all users of the machine have.
  if (const std::string shipped = resource_folder("experiments");
      !shipped.empty() && file == (std::filesystem::path(shipped) / std::filesystem::path(file).filename()).string()) {
    complain(fmt::format("{}: comes with Skein and is not changed, allowed with --save: the path of a copy of your own",
                         file));
    return false;
  }
  return changed(file, values).has_value();
}

int save_keys(const std::string& file, const KeyValues& values) {
  auto now = changed(file, values);
  if (!now) return wrong_input;
  if (const auto saved = now->change.save(now->text); !saved) {
    complain(saved.error());
    return wrong_input;
  }
  print_out(fmt::format("# saved in {}\n", shown(file)));
  return done;
}

int save_found(const std::string& file, const std::vector<FoundRobot>& robots) {
  const auto saved = save_to_robots_file(file, robots);
  if (!saved) {
    print_error(saved.error() + "\n");
    return wrong_input;
  }
  for (const std::string& problem : saved->problems) complain(problem);
  if (saved->changed) print_out(fmt::format("# saved in {}\n", shown(file)));
  return robots.empty() || saved->robots > 0 ? done : expectation_failed;
}

}  // namespace skein::app

#include "app/manual/mistakes.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <regex>
#include <utility>
#include <vector>

#include "app/run/nearest_word.h"
#include "app/run/terminal_text.h"

namespace skein::app {
namespace {

/// The innermost command that was given, and its name as it is typed.
std::pair<const CLI::App*, std::string> given_command(const CLI::App& program) {
  const CLI::App* command = &program;
  std::string name = program.get_name();
  for (;;) {
    const auto below = command->get_subcommands();
    if (below.empty()) return {command, name};
    command = below.front();
    name += " " + command->get_name();
  }
}

std::vector<std::string> names_of_options(const CLI::App& command) {
  std::vector<std::string> names;
  for (const CLI::Option* option : command.get_options())
    if (!option->get_positional() && !option->get_group().empty())
      for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  return names;
}

std::string first_sentence(const std::string& text) {
  return text.substr(0, text.find('\n'));
}

std::string unexpected(const CLI::App& program, const CLI::App& command) {
  std::vector<std::string> words = program.remaining(true);
  const auto options = names_of_options(command), commands = names_of_commands(command);
  const bool option = std::any_of(words.begin(), words.end(), [](const auto& word) { return word.starts_with("-"); });
  for (std::string& word : words)
    if (word.starts_with("--")) word.resize(std::min(word.find('='), word.size()));
  const std::string found = fmt::format("{}", fmt::join(words, ", ")), first = words.empty() ? "" : words.front();
  if (option)
    return fmt::format("found {}{} allowed: {}", found, did_you_mean(first, options), fmt::join(options, ", "));
  if (!commands.empty())
    return fmt::format("found {}{} allowed: {}", found, did_you_mean(first, commands), fmt::join(commands, ", "));
  std::string places;
  for (const CLI::Option* place : command.get_options())
    if (place->get_positional()) places += (places.empty() ? "" : " ") + place->get_name(true);
  return fmt::format("found {} at the end, allowed: {}", found,
                     places.empty() ? "options only" : "no more than " + places);
}

/// CLI11's texts, and what they are in plain words: $1, $2 are their parts.
std::string in_plain_words(const std::string& text) {
  static const std::vector<std::pair<std::regex, const char*>> table{
      {std::regex(R"(^(.*): At [Mm]ost 1 required but received 2$)"), "$1: found twice, allowed: once"},
      {std::regex(R"(^(.*): At [Mm]ost 1 required but received (\d+)$)"), "$1: found $2 times, allowed: once"},
      {std::regex(R"(^(.*): 1 required (?:[^ ]*:)?(INT|FLOAT)(?: in \[(.*) - (.*)\])? missing$)"),
       "$1: found no value, allowed: a number"},
      {std::regex(R"(^(.*): 1 required (.*) missing$)"), "$1: found no value, allowed: $2"},
      {std::regex(R"(^(.*): Value (.*) not in range (.*) to (.*)$)"), "$1: found $2, allowed: a number from $3 to $4"},
      {std::regex(R"(^Could not convert: (.*) = (.*)$)"), "$1: found $2, allowed: a number"},
      {std::regex(R"(^(.*) requires (.*)$)"), "$1: found without $2, allowed: with it"},
      {std::regex(R"(^(.*) excludes (.*)$)"), "$1: found beside $2, allowed: one of the two"},
      {std::regex(R"(^(.*): (.* is missing before .*)$)"), "$1: $2"},
  };
  static const std::regex one_of(R"(^(.*): (.*) not in \{(.*)\}$)");
  std::smatch found;
  for (const auto& [pattern, words] : table)
    if (std::regex_match(text, found, pattern)) return found.format(words);
  if (std::regex_match(text, found, one_of))
    return fmt::format("{}: found {}, allowed: {}", found.str(1), found.str(2),
                       std::regex_replace(found.str(3), std::regex(","), ", "));
  return text;
}

}  // namespace

std::vector<std::string> names_of_commands(const CLI::App& command) {
  std::vector<std::string> names;
  for (const CLI::App* below : command.get_subcommands([](const CLI::App* c) { return !c->get_group().empty(); }))
    names.push_back(below->get_name());
  return names;
}

std::string what_is_wrong(const CLI::App& program, const CLI::ParseError& error) {
  const auto [command, name] = given_command(program);
  const std::string text = error.what();
  const auto line = [&, &called = name](const std::string& mistake) {
    return fmt::format("{}: {} ({} --help)", called, mistake, called);
  };
  if (dynamic_cast<const CLI::ExtrasError*>(&error) != nullptr) return line(unexpected(program, *command));
  if (dynamic_cast<const CLI::RequiredError*>(&error) != nullptr) {
    if (text == "A subcommand is required" && !program.remaining(true).empty())
      return line(unexpected(program, *command));
    if (text == "A subcommand is required")
      return line(fmt::format("found no command, allowed: {}", fmt::join(names_of_commands(*command), ", ")));
    const std::string missing = text.substr(0, text.find(" is required"));
    const CLI::Option* const option = command->get_option_no_throw(missing);
    return line(fmt::format("{}: missing, allowed: {}", missing,
                            option != nullptr ? first_sentence(option->get_description()) : "a value"));
  }
  return line(in_plain_words(text));
}

std::optional<std::string> misplaced(const CLI::App& program) {
  const CLI::App* command = &program;
  std::string name = program.get_name();
  while (!command->get_subcommands().empty()) {
    const CLI::App* const below = command->get_subcommands().front();
    const std::string whole = name + " " + below->get_name();
    for (const CLI::Option* option : command->get_options()) {
      if (option->count() == 0) continue;
      const std::string called = option->get_positional() ? option->results().front() : option->get_name();
      if (command == &program || option->get_positional() || below->get_option_no_throw(called) == nullptr)
        return fmt::format("{}: found {} before the name {}, allowed: options and files of {} behind it ({} --help)",
                           name, called, below->get_name(), whole, whole);
    }
    command = below;
    name = whole;
  }
  return {};
}

void say_mistakes_plainly(CLI::App& program) {
  program.failure_message([](const CLI::App* app, const CLI::Error& error) {
    const auto* const parsed = dynamic_cast<const CLI::ParseError*>(&error);
    return shown(parsed != nullptr ? what_is_wrong(*app, *parsed) : std::string(error.what())) + "\n";
  });
  for (CLI::Option* option : program.get_options([](const CLI::Option* o) { return o->get_expected_max() == 0; }))
    if (option->get_lnames() != std::vector<std::string>{"help"})
      option->check([](const std::string& value) -> std::string {
        return value == "true" || value == "false" ? "" : fmt::format("found {}, allowed: no value", value);
      });
  for (CLI::App* command : program.get_subcommands([](const CLI::App*) { return true; }))
    say_mistakes_plainly(*command);
}

}  // namespace skein::app

#include "app/manual/manual.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string_view>

namespace skein::app {
namespace {

/// Text as roff takes it: hyphens that can be copied, no line that is taken for a request.
std::string roff(std::string_view text) {
  std::string result;
  for (const char c : text) {
    const bool line_begins = result.empty() || result.back() == '\n';
    if (line_begins && (c == '.' || c == '\'')) result += "\\&";
    if (c == '\\')
      result += "\\e";
    else if (c == '-')
      result += "\\-";
    else
      result += c;
  }
  return result;
}

bool hidden(const CLI::App& command) {
  return command.get_group().empty();
}

std::vector<const CLI::App*> commands_of(const CLI::App& program) {
  auto all = program.get_subcommands([](const CLI::App* command) { return !hidden(*command); });
  return {all.begin(), all.end()};
}

std::vector<const CLI::Option*> options_of(const CLI::App& command, bool positional) {
  std::vector<const CLI::Option*> result;
  for (const CLI::Option* option : command.get_options())
    if (option->get_positional() == positional && !option->get_group().empty()) result.push_back(option);
  return result;
}

/// "PATH:FILE" and the like, as --help prints it; empty for a flag.
std::string value_of(const CLI::Option& option) {
  return option.get_expected_max() == 0 ? "" : option.get_type_name();
}

/// The words of "TEXT:{max,realtime}".
std::vector<std::string> allowed_words(const CLI::Option& option) {
  const std::string type = option.get_type_name();
  const auto open = type.find('{'), close = type.find('}', open);
  std::vector<std::string> result;
  if (open == std::string::npos || close == std::string::npos) return result;
  for (std::size_t begin = open + 1; begin < close;) {
    const std::size_t end = std::min(type.find(',', begin), close);
    result.push_back(type.substr(begin, end - begin));
    begin = end + 1;
  }
  return result;
}

std::string first_line(const std::string& text) {
  return text.substr(0, text.find('\n'));
}

std::string lower_first(std::string text) {
  if (!text.empty()) text[0] = static_cast<char>(std::tolower(static_cast<unsigned char>(text[0])));
  return text;
}

/// "EXPERIMENT" for the positional "experiment".
std::string place_of(const CLI::Option& option) {
  std::string name = option.get_name(true);
  std::transform(name.begin(), name.end(), name.begin(), [](unsigned char c) { return std::toupper(c); });
  return option.get_required() ? name : "[" + name + "]";
}

std::string synopsis(const CLI::App& command, const std::string& words) {
  std::string line = fmt::format(".B {}\n", roff(words));
  if (!options_of(command, false).empty()) line += "[\\fIOPTIONS\\fR]\n";
  for (const CLI::Option* option : options_of(command, true))
    line += fmt::format("\\fI{}\\fR\n", roff(place_of(*option)));
  if (!commands_of(command).empty())
    line += command.get_require_subcommand_min() > 0 ? "\\fICOMMAND\\fR ...\n" : "[\\fICOMMAND\\fR ...]\n";
  return line;
}

std::string entry(const CLI::Option& option, bool positional) {
  std::string head = positional ? fmt::format("\\fI{}\\fR", roff(place_of(option)))
                                : fmt::format("\\fB{}\\fR", roff(option.get_name(false, true)));
  if (const std::string value = value_of(option); !value.empty() && !positional)
    head += fmt::format(" \\fI{}\\fR", roff(value));
  std::string text = fmt::format(".TP\n{}\n{}\n", head, roff(option.get_description()));
  if (const std::string standard = option.get_default_str(); !standard.empty())
    text += fmt::format("Default: {}.\n", roff(standard));
  return text;
}

void add_pages(std::vector<ManualPage>& pages, const CLI::App& command, const std::string& words,
               const std::string& version) {
  std::string name = words;
  std::replace(name.begin(), name.end(), ' ', '-');
  std::string text = fmt::format(".\\\" Made from the texts of --help.\n.TH \"{}\" 1 \"\" \"Skein {}\" \"Skein\"\n",
                                 roff(name), roff(version));
  std::string what = first_line(command.get_description());
  while (what.ends_with('.')) what.pop_back();
  text += fmt::format(".SH NAME\n{} \\- {}\n.SH SYNOPSIS\n{}", roff(name), roff(lower_first(what)),
                      synopsis(command, words));
  text += fmt::format(".SH DESCRIPTION\n{}\n", roff(command.get_description()));
  if (const auto places = options_of(command, true); !places.empty()) {
    text += ".SH ARGUMENTS\n";
    for (const CLI::Option* option : places) text += entry(*option, true);
  }
  if (const auto options = options_of(command, false); !options.empty()) {
    text += ".SH OPTIONS\n";
    for (const CLI::Option* option : options) text += entry(*option, false);
  }
  if (const auto below = commands_of(command); !below.empty()) {
    text += ".SH COMMANDS\n";
    for (const CLI::App* sub : below)
      text += fmt::format(".TP\n\\fB{}\\fR\n{}. See\n.BR {}\\-{} (1).\n", roff(sub->get_name()),
                          roff(sub->get_description()), roff(name), roff(sub->get_name()));
  }
  if (const std::string footer = command.get_footer(); !footer.empty())
    text += fmt::format(".SH NOTES\n.nf\n{}\n.fi\n", roff(footer));
  text += ".SH SEE ALSO\n";
  const auto last = words.rfind(' ');
  if (last != std::string::npos) {
    std::string above = words.substr(0, last);
    std::replace(above.begin(), above.end(), ' ', '-');
    text += fmt::format(".BR {} (1),\n", roff(above));
  }
  text += "the documents in /usr/share/doc/skein.\n";
  pages.push_back({name, text});
  for (const CLI::App* sub : commands_of(command)) add_pages(pages, *sub, words + " " + sub->get_name(), version);
}

const CLI::Option* find_option(const CLI::App& command, const std::string& word) {
  for (const CLI::Option* option : options_of(command, false))
    if (option->check_name(word)) return option;
  return nullptr;
}

/// Keys as long as there is no "=", then their values.
bool shows(const std::string& word, const std::string& typed) {
  const auto equals = word.find('=');
  if (equals == std::string::npos) return true;
  return (equals + 1 < word.size()) == (typed.find('=') != std::string::npos);
}

const CLI::App* find_command(const CLI::App& command, const std::string& word) {
  for (const CLI::App* sub : commands_of(command))
    if (sub->check_name(word)) return sub;
  return nullptr;
}

}  // namespace

std::vector<ManualPage> manual_pages(const CLI::App& program, const std::string& version) {
  std::vector<ManualPage> pages;
  add_pages(pages, program, program.get_name(), version);
  return pages;
}

tl::expected<void, std::string> write_manual(const CLI::App& program, const std::string& version,
                                             const std::string& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) return tl::unexpected(fmt::format("{}: cannot be made: {}", folder, error.message()));
  for (const ManualPage& page : manual_pages(program, version)) {
    const std::string path = fmt::format("{}/{}.1", folder, page.name);
    std::ofstream file(path, std::ios::binary | std::ios::trunc);
    file << page.text;
    file.close();
    if (!file) return tl::unexpected(fmt::format("{}: cannot be written: {}", path, std::strerror(errno)));
  }
  return {};
}

void refuse_missing_values(CLI::App& program) {
  for (CLI::Option* option : program.get_options([](const CLI::Option* o) { return !o->get_positional(); }))
    if (option->get_expected_max() != 0)
      option->check([what = option->get_type_name()](const std::string& value) -> std::string {
        if (value == "-") return "found -, allowed: for a pipe /dev/stdout or /dev/stdin, for a file of this name ./-";
        if (!value.starts_with("--")) return {};
        return fmt::format("{} is missing before {}", what.empty() ? "the value" : what, value);
      });
  for (CLI::Option* option : program.get_options())
    if (option->get_expected_max() != 0)
      option->check([](const std::string& value) -> std::string {
        return value.empty() ? "found an empty text, allowed: a value" : "";
      });
  for (CLI::App* command : program.get_subcommands([](const CLI::App*) { return true; }))
    refuse_missing_values(*command);
}

std::string completions(const CLI::App& program, const std::vector<std::string>& words, const ValuesOf& values) {
  Typed so_far{words.empty() ? "" : words.back(), {}};
  const std::string& typed = so_far.word;
  const CLI::App* command = &program;
  const CLI::Option* wants = nullptr;  // the option whose value is typed
  std::size_t places = 0;              // positionals that are filled
  for (std::size_t k = 0; k + 1 < words.size(); ++k) {
    const std::string& word = words[k];
    if (wants != nullptr) {
      so_far.options[wants->get_name(false, false)] = word;
      wants = nullptr;
    } else if (word.starts_with("-") && word.size() > 1) {
      const std::size_t equals = word.find('=');
      const CLI::Option* option = find_option(*command, word.substr(0, equals));
      if (option == nullptr || option->get_expected_max() == 0) continue;
      if (equals == std::string::npos)
        wants = option;
      else
        so_far.options[option->get_name(false, false)] = word.substr(equals + 1);
    } else if (const CLI::App* sub = find_command(*command, word); sub != nullptr) {
      command = sub;
      places = 0;
    } else {
      ++places;
    }
  }

  std::vector<Candidate> found;
  bool files = false;
  const auto add_values = [&](const CLI::Option& option, const std::string& name) {
    std::optional<std::vector<Candidate>> known;
    if (values) known = values(name, so_far);
    // What the shell would give back as another word: names of two lines (each line is a candidate), or of an option.
    const auto cannot_be = [](const Candidate& one) {
      return one.word.starts_with('-') || one.word.find_first_of("\n\t") != std::string::npos;
    };
    if (known) std::remove_copy_if(known->begin(), known->end(), std::back_inserter(found), cannot_be);
    const std::vector<std::string> allowed = allowed_words(option);
    for (const std::string& word : allowed) found.push_back({word, {}});
    files = allowed.empty() && (!known || !name.starts_with("-"));
  };
  if (wants != nullptr) {
    add_values(*wants, wants->get_name(false, false));
  } else {
    if (typed.starts_with("-") || typed.empty())
      for (const CLI::Option* option : options_of(*command, false))
        for (const std::string& name : option->get_lnames())
          if (typed.starts_with("-")) found.push_back({"--" + name, option->get_description()});
    if (!typed.starts_with("-")) {
      if (places == 0)
        for (const CLI::App* sub : commands_of(*command)) found.push_back({sub->get_name(), sub->get_description()});
      const auto positionals = options_of(*command, true);
      if (!positionals.empty()) {
        const CLI::Option& here = *positionals[std::min(places, positionals.size() - 1)];
        if (places < positionals.size() || here.get_expected_max() > 1) add_values(here, here.get_name(true));
      }
    }
  }
  std::string lines = files ? "@files\n" : "";
  for (const Candidate& candidate : found)
    if (candidate.word.starts_with(typed) && shows(candidate.word, typed))
      lines += candidate.word + '\t' + first_line(candidate.help) + '\n';
  return lines;
}

}  // namespace skein::app

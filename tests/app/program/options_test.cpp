// Every command, as its --help says it: an option that it takes stands in its help, its page of the manual and its
// completion, and it takes no other.
#include <gmock/gmock.h>

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "tests/app/folder.h"
#include "tests/files.h"
#include "tests/places.h"

namespace {

using ::testing::HasSubstr;
using Words = std::set<std::string>;

/// Everything that a shell's line prints, stdout and stderr.
std::string said(const std::string& line) {
  std::string text;
  FILE* const pipe = ::popen((line + " 2>&1").c_str(), "r");
  if (pipe == nullptr) return text;
  char block[4096];
  for (std::size_t n = 0; (n = std::fread(block, 1, sizeof block, pipe)) > 0;) text.append(block, n);
  ::pclose(pipe);
  return text;
}

struct Command {
  std::string name;  ///< "calibrate floor", empty: the program itself
  std::string help;
  Words options;
  std::vector<std::string> below;     ///< names of commands
  std::vector<std::string> required;  ///< words with which nothing is missing
};

/// The part of a help below a heading, which newer versions of CLI11 write in capitals.
std::string section(const std::string& help, std::string heading) {
  auto begin = help.find("\n" + heading + ":\n");
  if (begin == std::string::npos) {
    for (char& letter : heading) letter = static_cast<char>(std::toupper(static_cast<unsigned char>(letter)));
    begin = help.find("\n" + heading + ":\n");
  }
  if (begin == std::string::npos) return {};
  const auto text = begin + heading.size() + 3, end = help.find("\n\n", text);
  return help.substr(text, end - text);
}

std::vector<std::string> matches(const std::string& text, const std::string& pattern) {
  std::vector<std::string> all;
  const std::regex expression(pattern, std::regex::ECMAScript | std::regex::multiline);
  for (std::sregex_iterator it(text.begin(), text.end(), expression), end; it != end; ++it) all.push_back((*it)[1]);
  return all;
}

Words options_in(const std::string& text, const std::string& pattern) {
  const auto all = matches(text, pattern);
  return {all.begin(), all.end()};
}

void add_commands(const std::string& skein, const std::string& name, std::vector<Command>& all) {
  Command command{name, said(skein + " " + name + " --help"), {}, {}, {}};
  command.options = options_in(section(command.help, "Options"), "^ {2,10}(?:-\\w, *)?(--[a-z-]+)");
  command.below = matches(section(command.help, "Subcommands"), "^  ([a-z-]+) ");
  for (const std::string& line : matches(section(command.help, "Positionals"), "^  (\\S+ .*)$"))
    if (line.find("REQUIRED") != std::string::npos) command.required.emplace_back("./word");
  for (const std::string& option : matches(command.help, "^ {2,10}(--[a-z-]+) .*REQUIRED")) {
    command.required.push_back(option);
    command.required.emplace_back(option == "--to" ? "mcap" : "word");
  }
  all.push_back(command);
  for (const std::string& below : all.back().below) {
    const std::string longer = name.empty() ? below : std::string(name).append(" ").append(below);
    add_commands(skein, longer, all);
  }
}

class Options : public ::testing::Test {
 protected:
  static void SetUpTestSuite() { add_commands(skein(), "", commands()); }
  static std::string skein() { return "'" + skein::test::program() + "'"; }
  static std::vector<Command>& commands() {
    static std::vector<Command> all;
    return all;
  }
};

TEST_F(Options, EveryCommandIsFound) {
  EXPECT_GT(commands().size(), 35u);
  for (const Command& command : commands()) EXPECT_TRUE(command.options.contains("--help")) << command.help;
}

TEST_F(Options, StandInTheManual) {
  const skein::test::Folder own_folder;
  const std::filesystem::path folder = own_folder.path;
  EXPECT_EQ(said(skein() + " manual '" + folder.string() + "'"), "");
  std::size_t pages = 0;
  for (const Command& command : commands()) {
    std::string name = command.name.empty() ? "skein" : "skein " + command.name;
    std::replace(name.begin(), name.end(), ' ', '-');
    const std::string page =
        std::regex_replace(skein::test::read_file(folder / (name + ".1")), std::regex("\\\\-"), "-");
    EXPECT_EQ(options_in(page, "^\\\\fB(?:-\\w,)?(--[a-z-]+)"), command.options) << command.name;
    ++pages;
  }
  EXPECT_EQ(static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(folder), {})), pages)
      << "a page of no command";
}

TEST_F(Options, StandInTheCompletion) {
  for (const Command& command : commands())
    EXPECT_EQ(options_in(said(skein() + " complete " + command.name + " --"), "^(--[a-z-]+)\\t"), command.options)
        << command.name;
}

TEST_F(Options, AreTakenByNoCommandThatDoesNotNameThem) {
  Words everywhere;
  for (const Command& command : commands()) everywhere.insert(command.options.begin(), command.options.end());
  for (const Command& command : commands()) {
    if (!command.below.empty() && command.name != "tags") continue;  // they want a command first
    std::string line = skein() + " " + command.name;
    for (const std::string& word : command.required) line += " " + word;
    Words others;
    std::set_difference(everywhere.begin(), everywhere.end(), command.options.begin(), command.options.end(),
                        std::inserter(others, others.end()));
    for (const std::string& option : others) line += " " + option + "=1";
    const std::string all = said(line), found = all.substr(0, all.find("allowed: "));
    EXPECT_EQ(options_in(std::regex_replace(found, std::regex("[ ,;]+"), "\n"), "^(--[a-z-]+)$"), others) << all;
  }
}

TEST_F(Options, ThatStandBeforeTheNameOfACommandAreRefused) {
  EXPECT_EQ(said(skein() + " --seed 3 run platoon"),
            "skein: found --seed before the name run, allowed: options and files of skein run behind it (skein run "
            "--help)\n");
  EXPECT_THAT(said(skein() + " tags --size 40 board"), HasSubstr("skein tags: found --size before the name board"));
  EXPECT_THAT(said(skein() + " tags 1-4 board"), HasSubstr("skein tags: found 1-4 before the name board"));
}

}  // namespace

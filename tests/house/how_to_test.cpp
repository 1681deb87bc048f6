// The pages of docs/how-to name real files and real symbols, and are as short a walk as they say.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <regex>
#include <string>
#include <vector>

#include "rules.h"
#include "tests/places.h"

namespace skein::test {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> pages() {
  std::vector<std::string> all;
  for (const auto& entry : fs::directory_iterator(test::in_source("docs/how-to")))
    if (entry.path().extension() == ".md") all.push_back("docs/how-to/" + entry.path().filename().string());
  return all;
}

/// What stands between backticks.
std::vector<std::string> spans_of(const std::string& text) {
  static const std::regex span("`([^`\n]+)`");
  std::vector<std::string> all;
  for (auto at = std::sregex_iterator(text.begin(), text.end(), span); at != std::sregex_iterator(); ++at)
    all.push_back((*at)[1]);
  return all;
}

bool is_path(const std::string& span) {
  static const std::regex path("[A-Za-z0-9_./-]+/[A-Za-z0-9_.-]+\\.(h|cpp|c|ino|txt|md|toml)");
  return std::regex_match(span, path);
}

bool names(const std::string& text, const std::string& symbol) {
  return std::regex_search(text, std::regex("\\b" + symbol + "\\b"));
}

TEST(HowTo, NamesFilesThatExist) {
  ASSERT_FALSE(pages().empty());
  for (const std::string& page : pages())
    for (const std::string& span : spans_of(text_of(page))) {
      if (!is_path(span)) continue;
      EXPECT_TRUE(fs::exists(test::in_source(span))) << page << ": `" << span << "`";
    }
}

TEST(HowTo, NamesSymbolsThatStandInTheFilesItNames) {
  static const std::regex symbol("[A-Za-z_][A-Za-z0-9_]*(::[A-Za-z_][A-Za-z0-9_]*)*");
  static const std::regex test_name("([A-Z][A-Za-z0-9]*)\\.([A-Z][A-Za-z0-9]*)");
  int symbols = 0;
  for (const std::string& page : pages()) {
    const std::vector<std::string> spans = spans_of(text_of(page));
    std::string sources;
    for (const std::string& span : spans)
      if (is_path(span)) sources += text_of(span);
    for (const std::string& span : spans) {
      std::smatch parts;
      if (std::regex_match(span, parts, test_name)) {
        EXPECT_TRUE(sources.find("TEST(" + parts[1].str() + ", " + parts[2].str() + ")") != std::string::npos)
            << page << ": no test `" << span << "` in the files that it names";
      } else if (std::regex_match(span, symbol)) {
        ++symbols;
        EXPECT_TRUE(names(sources, span)) << page << ": `" << span << "` is in none of the files that it names";
      }
    }
  }
  EXPECT_GT(symbols, 10);
}

std::ptrdiff_t lines_of(const std::string& path) {
  const std::string text = text_of(path);
  return std::count(text.begin(), text.end(), '\n');
}

TEST(HowTo, ARobotIsOneFileOfAtMost300Lines) {
  EXPECT_LE(lines_of("comms/khepera_session.h") + lines_of("comms/khepera_session.cpp"), 200);
  EXPECT_LE(lines_of("comms/open_session.h") + lines_of("comms/open_session.cpp"), 300);
  EXPECT_LE(lines_of("resources/robots/open_robot/open_robot.h") + lines_of("resources/robots/open_robot/open_robot.c"),
            300);
}

}  // namespace
}  // namespace skein::test

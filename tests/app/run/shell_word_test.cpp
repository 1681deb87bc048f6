// Commands that are printed to be copied: a shell reads back what they mean.
#include "app/run/shell_word.h"

#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <string>

namespace skein::app {
namespace {

/// What a shell takes for the words behind printf.
std::string read_by_a_shell(const std::string& words) {
  std::string text;
  FILE* const pipe = ::popen(("printf '[%s]' " + words).c_str(), "r");
  if (!pipe) return text;
  std::array<char, 256> part{};
  while (std::fgets(part.data(), part.size(), pipe)) text += part.data();
  EXPECT_EQ(::pclose(pipe), 0) << words;
  return text;
}

TEST(ShellWord, IsReadAsItIsMeant) {
  for (const std::string word : {"/opt/lab one/skein", "it's", "$HOME", "a;b", "`id`", "*", "", "~", "a\\b", "x=1"}) {
    EXPECT_EQ(read_by_a_shell(shell_word(word)), "[" + word + "]");
    EXPECT_EQ(read_by_a_shell(shell_word_if_needed(word)), "[" + word + "]");
  }
}

TEST(ShellWord, HasQuotesOnlyWhereItNeedsThem) {
  EXPECT_EQ(shell_word_if_needed("gnuplot-nox"), "gnuplot-nox");
  EXPECT_EQ(shell_word_if_needed("/var/lib/a.b"), "/var/lib/a.b");
  EXPECT_EQ(shell_word_if_needed("lab one"), "'lab one'");
}

}  // namespace
}  // namespace skein::app

#include "app/run/terminal_text.h"

#include <gtest/gtest.h>

namespace {

using namespace skein::app;

TEST(TerminalText, NothingInItIsObeyed) {
  EXPECT_EQ(shown("\x1b[2J\x1b]0;all is well\x07"), "\\u001b[2J\\u001b]0;all is well\\u0007");
  EXPECT_EQ(shown("a\nskein: b\tc\rd"), "a\\nskein: b\\tc\\rd");
  EXPECT_EQ(shown_lines("a\nb\tc\rd"), "a\nb\tc\\rd");
  EXPECT_EQ(shown("\x7f\xc2\x9b[2J"), "\\u007f\\u009b[2J") << "DEL, and CSI in one letter";
  EXPECT_EQ(shown("run\xe2\x80\xaevsc.exe"), "run\\u202evsc.exe") << "right to left";
  EXPECT_EQ(shown("\xf3\xa0\x80\x81"), "\\U000e0001") << "a letter that is not seen";
  EXPECT_EQ(shown(std::string_view("a\0b", 3)), "a\\u0000b");
}

TEST(TerminalText, WhatIsNoUtf8IsShownAsBytes) {
  EXPECT_EQ(shown("r\xff\xe9t"), "r\\xff\\xe9t");
  EXPECT_EQ(shown("\xc0\x9b"), "\\xc0\\x9b") << "a control character that is longer than it must be";
  EXPECT_EQ(shown("\xed\xa0\x80"), "\\xed\\xa0\\x80") << "half of a pair";
  EXPECT_EQ(shown("\xf4\x90\x80\x80"), "\\xf4\\x90\\x80\\x80") << "beyond Unicode";
  EXPECT_EQ(shown("\xe2\x82"), "\\xe2\\x82") << "cut off";
}

TEST(TerminalText, LettersOfAllLanguagesStay) {
  for (const char* text : {"", "C:\\runs", "Käfer", "機器人", "e\xcc\x81", "👩‍🔬", "\xd7\xa9\xd7\x9c"})
    EXPECT_EQ(shown(text), text);
}

TEST(TerminalText, TakesAsManyColumnsAsATerminalGives) {
  EXPECT_EQ(columns("robot"), 5U);
  EXPECT_EQ(columns("Käfer"), 5U);
  EXPECT_EQ(columns("e\xcc\x81"), 1U) << "with a combining accent";
  EXPECT_EQ(columns("機器人"), 6U);
  EXPECT_EQ(columns("🦆"), 2U);
}

TEST(TerminalText, TablesAreAlignedWhateverTheirLetters) {
  EXPECT_EQ(table({{"run", "state", "seed"},
                   {"Käfer", "complete", "1"},
                   {"機器人", "torn", "2"},
                   {"e\xcc\x81te\xcc\x81", "", "3"},
                   {"a\nb", "failed", "4"}}),
            "run     state     seed\n"
            "Käfer   complete  1\n"
            "機器人  torn      2\n"
            "e\xcc\x81te\xcc\x81               3\n"
            "a\\nb    failed    4\n");
}

}  // namespace

#include "vision/frames/frame.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>
#include <utility>

namespace skein::vision {
namespace {

/// What the kernel was told of the mapping that holds this address ("VmFlags" of proc(5)).
std::string flags_of(const void* address) {
  std::ifstream maps("/proc/self/smaps");
  const auto wanted = reinterpret_cast<std::uintptr_t>(address);
  bool inside = false;
  for (std::string line; std::getline(maps, line);) {
    unsigned long from = 0, to = 0;
    if (std::sscanf(line.c_str(), "%lx-%lx ", &from, &to) == 2) inside = from <= wanted && wanted < to;
    if (inside && line.starts_with("VmFlags:")) return line;
  }
  return {};
}

TEST(Frame, LiesInPagesOfTwoMegabytesWhereTheSystemHasThem) {
  if (!std::filesystem::exists("/sys/kernel/mm/transparent_hugepage/enabled")) GTEST_SKIP() << "no huge pages here";
  Frame frame;
  for (const auto& [width, height] : {std::pair{640, 480}, {1280, 960}, {3840, 2160}}) {
    frame.resize(width, height);
    EXPECT_EQ(reinterpret_cast<std::uintptr_t>(frame.row(0)) % (1U << 21), 0U) << width;
    for (const int row : {0, height - 1})
      EXPECT_NE(flags_of(frame.row(row)).find(" hg"), std::string::npos) << width << ", row " << row;
  }
  const Frame copy = frame;
  EXPECT_NE(flags_of(copy.row(0)).find(" hg"), std::string::npos) << "as a film's frames are copied";
  frame.resize(16, 16);
  EXPECT_EQ(frame.grey.size(), 256U);
}

}  // namespace
}  // namespace skein::vision

#pragma once

#include <string>
#include <vector>

namespace skein::test {

/// One source file of a room: its path from the project's root ("core/geometry/pose.h") and its text.
struct SourceFile {
  std::string path;
  std::string text;
};

/// Everything in `file` that the house rules of ARCHITECTURE.md forbid, one sentence each, with path and line.
std::vector<std::string> broken_rules(const SourceFile& file);

/// The sources of one room, read from the disk.
std::vector<SourceFile> sources_of(const std::string& room);

}  // namespace skein::test
